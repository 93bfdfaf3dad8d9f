//! The adapters that Nanos come with, and ports that another program reads.

use host::device::link::LinkError;
use host::device::link::ports::NANO_USB_IDS;

/// What was just flashed must be found.
#[test]
fn the_flasher_and_the_host_know_the_same_adapters() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware/Ravedude.toml");
    let text = std::fs::read_to_string(file).unwrap();
    let known: toml::Table = toml::from_str(&text).unwrap();
    let ids: Vec<(u16, u16)> = known["board"]["usb-info"]["port-ids"]
        .as_array()
        .unwrap()
        .iter()
        .map(|id| (id["vid"].as_integer().unwrap() as u16, id["pid"].as_integer().unwrap() as u16))
        .collect();

    for (vid, pid, name) in NANO_USB_IDS {
        let has = ids.iter().any(|id| id.0 == vid && pid.is_none_or(|pid| pid == id.1));
        assert!(has, "{name} is not in firmware/Ravedude.toml");
    }
    for (vid, pid) in ids {
        let has = NANO_USB_IDS.iter().any(|id| id.0 == vid && id.1.is_none_or(|known| known == pid));
        assert!(has, "{vid:04X}:{pid:04X} is not in ports.rs");
    }
}

#[test]
fn a_missing_port_names_who_may_have_taken_it_and_the_likely_adapter() {
    let none = LinkError::NoPort { others: vec![], likely: None }.help().unwrap();
    let likely = Some(("/dev/ttyUSB0".to_owned(), "1234:0001".to_owned()));
    let one = LinkError::NoPort { others: vec!["/dev/ttyUSB0".into()], likely }.help().unwrap();

    for word in ["dmesg | tail", "sudo apt remove brltty", "ModemManager"] {
        assert!(none.contains(word), "{none}");
    }
    assert!(one.contains("--port /dev/ttyUSB0"), "{one}");
}
