//! The Arduino Nano: wiring, start-up order, and the loop around [`App::poll`].
//!
//! | pin | goes to |
//! |---|---|
//! | A4 (PC4) | SDA of PCA9685 (0x40) and INA219 (0x41) |
//! | A5 (PC5) | SCL of both |
//! | D0, D1 | USB serial, 115,200 baud |
//! | D2 (PD2) | start button to ground, optional |
//! | D4 (PD4) | `/OE` of the PCA9685, optional, with 2.2 k to 5 V |
//! | D13 (PB5) | the light on the board: see `firmware::app` |
//!
//! Holds every register and interrupt of the chip, one module each. What can be
//! wrong without hardware is in the library; nothing there depends on this program.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt, asm_experimental_arch)]
#![deny(unsafe_op_in_unsafe_fn)]

mod eeprom;
mod frame_clock;
mod memory;
mod panel;
mod product;
mod reset;
mod shared;
mod stack;
mod timer;
mod twi;
mod usart;

use avr_device::interrupt;
use core::cell::UnsafeCell;
use firmware::App;
use firmware::chips::{ServoChip, ServoDriver};
use firmware::hal::Board;

/// All of the board, in the library's terms.
struct Nano {
    i2c: twi::Twi,
    servos: twi::Bursts,
    sensor: twi::Readings,
    clock: frame_clock::Timer,
    serial: usart::Usart,
    memory: eeprom::Eeprom,
    watchdog: reset::Watchdog,
    panel: panel::Panel,
}

impl Board for Nano {
    type Product = product::Mul;
    type I2c = twi::Twi;
    type Servos = twi::Bursts;
    type Sensor = twi::Readings;
    type Clock = frame_clock::Timer;
    type Delay = timer::Delay;
    type Serial = usart::Usart;
    type Memory = eeprom::Eeprom;
    type Watchdog = reset::Watchdog;
    type Panel = panel::Panel;

    fn i2c(&mut self) -> &mut twi::Twi {
        &mut self.i2c
    }

    fn servos(&mut self) -> &mut twi::Bursts {
        &mut self.servos
    }

    fn sensor(&mut self) -> &mut twi::Readings {
        &mut self.sensor
    }

    fn clock(&mut self) -> &mut frame_clock::Timer {
        &mut self.clock
    }

    fn delay(&self) -> timer::Delay {
        timer::Delay
    }

    fn serial(&mut self) -> &mut usart::Usart {
        &mut self.serial
    }

    fn memory(&mut self) -> &mut eeprom::Eeprom {
        &mut self.memory
    }

    fn watchdog(&mut self) -> &mut reset::Watchdog {
        &mut self.watchdog
    }

    fn panel(&mut self) -> &mut panel::Panel {
        &mut self.panel
    }

    fn bus_errors(&self) -> u16 {
        twi::errors()
    }

    fn stack_left(&self) -> u16 {
        stack::left()
    }
}

/// In static memory, so that the size report sees it.
struct MainOnly(UnsafeCell<App>);

// SAFETY: the main program alone refers to it, no interrupt does.
unsafe impl Sync for MainOnly {}

static APP: MainOnly = MainOnly(UnsafeCell::new(App::new()));

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: the start-up code calls this function once, and nothing else
    // refers to the static.
    let app = unsafe { &mut *APP.0.get() };

    let panel = panel::Panel::start();
    // A watchdog that caused this reset is still on, at its shortest period.
    let boot = reset::take_cause();
    // The servos come first: the PCA9685 pulses on through a reset of the Nano.
    // Timer and bus come before them only because nothing waits without a bound.
    let clock = frame_clock::Timer::start();
    let (mut i2c, servos, sensor) = twi::start();
    if ServoChip::switch_off(&mut i2c).is_err() {
        // A reset in the middle of a transfer left it stuck; it has been freed.
        let _ = ServoChip::switch_off(&mut i2c);
    }
    stack::paint();
    let mut board = Nano {
        i2c,
        servos,
        sensor,
        clock,
        serial: usart::Usart::start(),
        memory: eeprom::Eeprom::start(),
        watchdog: reset::Watchdog::start(),
        panel,
    };
    // SAFETY: no critical section is open, and every interrupt's state has its
    // start value.
    unsafe { interrupt::enable() };
    app.boot(&mut board, boot);
    loop {
        app.poll(&mut board);
    }
}

/// Nothing here panics; should it, the watchdog resets, and start-up takes the
/// pulses away.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
