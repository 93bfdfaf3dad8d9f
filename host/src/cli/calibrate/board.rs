//! The questions about the board: PWM, shunt, supply, start button.
//!
//! Does not depend on the joints.

use super::dialog::{Dialog, Key};
use super::joint::Stopped;
use super::servo::{HEARTBEAT_EVERY, Servo, let_go};
use crate::calibration::{Board, oscillator_mhz};
use crate::device::link::ports::SerialLink;
use crate::pwm::count_us;
use protocol::calibration::BoardCalibration;

/// Any servo's middle.
const METERED_PULSE_US: f64 = 1500.0;

/// Asks, and changes `board`; until the end the robot uses `in_use`.
pub fn ask(
    dialog: &mut Dialog,
    link: &mut SerialLink,
    board: &mut Board,
    in_use: BoardCalibration,
) -> Result<(), Stopped> {
    dialog.say(&format!(
        "\nThe board: PWM {} Hz, its oscillator {} MHz, shunt {} ohm, stops below {} V or at {} A, \
         starts from {} V, start button {}",
        board.pwm_hz,
        board.oscillator_mhz,
        board.shunt_ohm,
        board.undervoltage_v,
        board.overcurrent_a,
        board.start_v,
        button(board.autostart_s)
    ));
    if !dialog.agrees("Change any of that?", false)? {
        return Ok(());
    }
    if dialog.agrees("Can you measure the PWM frequency with a meter or an oscilloscope?", false)? {
        metered(dialog, link, board, in_use)?;
    }
    board.pwm_hz =
        dialog.number("PWM rate in Hz: 60, or more for digital servos", board.pwm_hz, (40.0, 339.0))?;
    if let Some(warning) = board.in_step() {
        dialog.say(&format!("warning: {warning}"));
        board.pwm_hz = dialog.number("PWM rate to use, in Hz", board.pwm_hz - 2.0, (40.0, 339.0))?;
    }
    board.shunt_ohm = dialog.number("Shunt of the INA219, in ohm", board.shunt_ohm, (0.067, 0.2))?;
    board.start_v =
        dialog.number("Lowest supply voltage at which a walk may start, in V", board.start_v, (0.0, 16.0))?;
    board.undervoltage_v = dialog.number(
        "Supply voltage below which it stops, in V: the lowest that the cells allow, or 3.8 V for a Nano that runs from it",
        board.undervoltage_v.min(board.start_v),
        (0.0, board.start_v),
    )?;
    board.overcurrent_a =
        dialog.number("Current at which it stops, in A", board.overcurrent_a, (0.001, 3.15))?;
    board.autostart_s = dialog.whole(
        "Seconds that it walks after a press of the start button; 0 disables the button, 255 walks until it is pressed again",
        board.autostart_s,
        u8::MAX,
    )?;
    Ok(())
}

/// Lets an output pulse until it is read off, and asks what it was.
fn metered(
    dialog: &mut Dialog,
    link: &mut SerialLink,
    board: &mut Board,
    in_use: BoardCalibration,
) -> Result<(), Stopped> {
    dialog.say("Unplug the servo of output 0 and hold the meter to its signal pin; Enter starts the pulses");
    wait_for_enter(dialog, None)?;
    let mut output = Servo::on(link, 0, count_us(&in_use), METERED_PULSE_US)?;
    dialog.say("Output 0 pulses; Enter when you have read the frequency");
    let read = wait_for_enter(dialog, Some(&mut output));
    let_go(link, 0);
    read?;
    let nominal_hz = board.oscillator_mhz * 1e6 / 4096.0 / (f64::from(in_use.prescale) + 1.0);
    let hz = |mhz: f64| (nominal_hz * mhz / board.oscillator_mhz * 10.0).round() / 10.0;
    let nominal_hz = (nominal_hz * 100.0).round() / 100.0;
    let measured_hz = dialog.number("How many Hz?", nominal_hz, (hz(20.1), hz(29.9)))?;
    if measured_hz != nominal_hz {
        board.oscillator_mhz = oscillator_mhz(measured_hz, in_use.prescale);
        dialog.say(&format!("So the PCA9685's oscillator runs at {} MHz", board.oscillator_mhz));
    }
    Ok(())
}

fn wait_for_enter(dialog: &mut Dialog, mut output: Option<&mut Servo<'_>>) -> Result<(), Stopped> {
    loop {
        if dialog.key(HEARTBEAT_EVERY)? == Some(Key::Enter) {
            return Ok(());
        }
        if let Some(output) = &mut output {
            output.repeat()?;
        }
    }
}

fn button(autostart_s: u8) -> String {
    match autostart_s {
        0 => "off".into(),
        255 => "walks until pressed again".into(),
        seconds => format!("walks {seconds} s"),
    }
}
