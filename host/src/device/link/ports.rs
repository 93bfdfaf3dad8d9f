//! Finds and opens the robot's port.
//!
//! Holds the USB adapters that Nanos come with, and the handling of DTR, whose
//! falling edge resets a Nano. With several Nanos the user has to name one. Does not
//! depend on what is sent.
//!
//! The first opening after the robot was plugged in resets it. From then on DTR
//! stays as it is, where the system allows it (Linux, macOS), so that a command
//! finds the robot as the last one left it: walking, or with a gait in RAM.

use super::{Link, LinkError, Timeouts};
use protocol::frame::STOP_BYTE;
#[cfg(unix)]
use serialport::TTYPort;
use serialport::{SerialPort, SerialPortInfo, SerialPortType};
use std::io::Write as _;
use std::time::Duration;

/// The firmware's baud rate, 8N1.
pub const BAUD_RATE: u32 = 115_200;
/// A read returns at the latest after this time, a third of a frame, so that a
/// stream of setpoints keeps its pace; [`Link`] reads again.
const READ_TIMEOUT: Duration = Duration::from_millis(5);

/// USB vendor and product of the chips on Nanos; `None` is every product. `firmware/Ravedude.toml`
/// has the same list, with the products of the boards that have one of their own.
pub const NANO_USB_IDS: [(u16, Option<u16>, &str); 10] = [
    (0x0403, Some(0x6001), "FTDI FT232R"),
    (0x0403, Some(0x6015), "FTDI FT231X"),
    (0x1A86, Some(0x7523), "CH340"),
    (0x1A86, Some(0x7522), "CH340K"),
    (0x1A86, Some(0x5523), "CH341"),
    (0x1A86, Some(0x55D4), "CH9102"),
    (0x10C4, Some(0xEA60), "CP210x"),
    (0x067B, Some(0x2303), "PL2303"),
    (0x2341, None, "Arduino"),
    (0x2A03, None, "Arduino.org"),
];

/// A link over a serial port.
pub type SerialLink = Link<Box<dyn SerialPort>>;

/// Opens `port`, or the only Nano there is, and waits for the robot's hello.
///
/// # Errors
/// [`LinkError::NoPort`] and [`LinkError::SeveralPorts`] list what is there;
/// else as [`Link::connect`].
pub fn connect(port: Option<&str>) -> Result<SerialLink, LinkError> {
    let (opened, name) = open(port)?;
    Link::connect(opened, &name, Timeouts::default())
}

/// As [`connect`], but the first byte on the wire stops the robot, whoever started its walk.
///
/// # Errors
/// As [`connect`].
pub fn connect_and_stop(port: Option<&str>) -> Result<SerialLink, LinkError> {
    let (mut opened, name) = open(port)?;
    opened.write_all(&[STOP_BYTE]).map_err(|source| LinkError::Broken {
        port: name.clone(),
        action: "write to",
        source,
    })?;
    Link::connect(opened, &name, Timeouts::default())
}

fn open(port: Option<&str>) -> Result<(Box<dyn SerialPort>, String), LinkError> {
    let name = match port {
        Some(name) => name.to_owned(),
        None => choose(available()?)?,
    };
    let opened = serialport::new(&name, BAUD_RATE)
        .timeout(READ_TIMEOUT)
        // Some adapters send nothing without it.
        .dtr_on_open(true)
        .open_native()
        .map_err(|source| not_opened(&name, source))?;
    #[cfg(unix)]
    {
        keep_dtr(&opened);
        never_block(&opened);
    }
    Ok((Box::new(opened), name))
}

fn not_opened(port: &str, source: serialport::Error) -> LinkError {
    let port = port.to_owned();
    // On Windows this kind is a port that does not exist.
    if cfg!(unix) && source.kind() == serialport::ErrorKind::NoDevice {
        LinkError::Busy { port }
    } else {
        LinkError::Open { port, source }
    }
}

/// Lets reads return at once where another program took the bytes first: it would hold the
/// terminal's lock for as long as it waits for more, and this program with it.
#[cfg(unix)]
#[allow(unsafe_code)]
fn never_block(port: &TTYPort) {
    use nix::fcntl::{FcntlArg, OFlag, fcntl};
    use std::os::fd::{AsRawFd as _, BorrowedFd};
    // SAFETY: `port` is open, and stays so for longer than this function runs.
    let port = unsafe { BorrowedFd::borrow_raw(port.as_raw_fd()) };
    // A port that cannot do so blocks as it did before.
    let _ = fcntl(port, FcntlArg::F_SETFL(OFlag::O_NONBLOCK));
}

/// Another program that has the port open, as `NAME (process N)`: the first that this user may see.
pub(super) fn other_reader(port: &str) -> Option<String> {
    let port = std::fs::canonicalize(port).ok()?;
    let own = std::process::id().to_string();
    for process in std::fs::read_dir("/proc").ok()?.flatten() {
        let id = process.file_name().to_string_lossy().into_owned();
        if id == own || !id.bytes().all(|byte| byte.is_ascii_digit()) {
            continue;
        }
        let Ok(files) = std::fs::read_dir(process.path().join("fd")) else { continue };
        let has_it = |file: std::fs::DirEntry| std::fs::read_link(file.path()).is_ok_and(|at| at == port);
        if files.flatten().any(has_it) {
            let name = std::fs::read_to_string(process.path().join("comm")).unwrap_or_default();
            // It holds both ends of its own terminal, and reads the other one.
            if name.trim() == "virtual-robot" {
                continue;
            }
            return Some(format!("{} (process {id})", name.trim()));
        }
    }
    None
}

/// Keeps the closing of the port from lowering DTR, which the next opening would raise again.
#[cfg(unix)]
#[allow(unsafe_code)]
fn keep_dtr(port: &TTYPort) {
    use nix::sys::termios::{ControlFlags, SetArg, tcgetattr, tcsetattr};
    use std::os::fd::{AsRawFd as _, BorrowedFd};
    // SAFETY: `port` is open, and stays so for longer than this function runs.
    let port = unsafe { BorrowedFd::borrow_raw(port.as_raw_fd()) };
    // A port that cannot do so resets its robot, which is what it did before.
    if let Ok(mut settings) = tcgetattr(port) {
        settings.control_flags.remove(ControlFlags::HUPCL);
        let _ = tcsetattr(port, SetArg::TCSANOW, &settings);
    }
}

fn available() -> Result<Vec<SerialPortInfo>, LinkError> {
    // serialport panics where this is missing, as in some containers.
    if cfg!(target_os = "linux") && !std::path::Path::new("/sys/class/tty").is_dir() {
        return Ok(Vec::new());
    }
    serialport::available_ports().map_err(|source| LinkError::List { source })
}

/// The one port that can be a Nano.
fn choose(ports: Vec<SerialPortInfo>) -> Result<String, LinkError> {
    let nanos: Vec<_> = ports.iter().filter_map(|p| Some((&p.port_name, nano_chip(&p.port_type)?))).collect();
    match nanos.as_slice() {
        [(name, _)] => Ok((*name).clone()),
        [] => {
            let likely = only_usb(&ports);
            Err(LinkError::NoPort { others: ports.into_iter().map(|p| p.port_name).collect(), likely })
        }
        several => {
            let ports = several.iter().map(|(name, chip)| format!("{name} ({chip})")).collect();
            Err(LinkError::SeveralPorts { ports })
        }
    }
}

/// The one USB adapter that there is, with its USB ID.
fn only_usb(ports: &[SerialPortInfo]) -> Option<(String, String)> {
    let usb = ports.iter().filter_map(|port| match &port.port_type {
        SerialPortType::UsbPort(usb) => {
            Some((port.port_name.clone(), format!("{:04X}:{:04X}", usb.vid, usb.pid)))
        }
        _ => None,
    });
    let all: Vec<_> = usb.collect();
    <[_; 1]>::try_from(all).ok().map(|[only]| only)
}

/// The adapter's name if it is one that Nanos come with.
fn nano_chip(port: &SerialPortType) -> Option<&'static str> {
    let SerialPortType::UsbPort(usb) = port else { return None };
    NANO_USB_IDS
        .iter()
        .find(|(vid, pid, _)| *vid == usb.vid && pid.is_none_or(|pid| pid == usb.pid))
        .map(|(_, _, name)| *name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serialport::UsbPortInfo;

    fn usb(name: &str, vid: u16, pid: u16) -> SerialPortInfo {
        let info = UsbPortInfo { vid, pid, serial_number: None, manufacturer: None, product: None };
        SerialPortInfo { port_name: name.into(), port_type: SerialPortType::UsbPort(info) }
    }

    #[test]
    fn the_only_nano_is_chosen_among_other_devices() {
        let modem = usb("/dev/ttyACM0", 0x1234, 0x0001);
        let builtin = SerialPortInfo { port_name: "/dev/ttyS0".into(), port_type: SerialPortType::Unknown };
        let nano = usb("/dev/ttyUSB0", 0x1A86, 0x7523);

        assert_eq!(choose(vec![modem, builtin, nano]).unwrap(), "/dev/ttyUSB0");
    }

    #[test]
    fn no_nano_lists_what_is_there() {
        let message = choose(vec![usb("/dev/ttyACM0", 0x1234, 1)]).unwrap_err().to_string();

        assert_eq!(message, "no robot found: none of the serial ports is a Nano's (/dev/ttyACM0)");
        assert_eq!(choose(vec![]).unwrap_err().to_string(), "no robot found: there is no serial port at all");
    }

    #[cfg(unix)]
    #[test]
    fn a_port_that_another_command_holds_is_busy_and_the_help_says_how_to_end_it() {
        let (_robot, slave) = TTYPort::pair().unwrap();
        let name = slave.name().unwrap();
        drop(slave);
        let _held = open(Some(&name)).unwrap();

        let error = open(Some(&name)).map(|_| ()).unwrap_err();

        assert!(matches!(error, LinkError::Busy { .. }), "{error:?}");
        assert!(error.help().is_some_and(|help| help.contains("Ctrl-C")), "{error:?}");
    }

    #[test]
    fn two_nanos_are_not_guessed_between() {
        let error = choose(vec![usb("/dev/ttyUSB0", 0x0403, 0x6001), usb("/dev/ttyACM1", 0x2341, 0x0043)])
            .unwrap_err();

        assert_eq!(
            error.to_string(),
            "2 ports could be the robot: /dev/ttyUSB0 (FTDI FT232R), /dev/ttyACM1 (Arduino)"
        );
        assert_eq!(error.help().unwrap(), "say which one: --port /dev/ttyUSB0");
    }
}
