//! Reset cause and watchdog.
//!
//! Holds the registers MCUSR and WDTCSR, and a word of memory that a reset does not
//! clear, which says whether servos were on. Does not guess a cause: bootloaders may
//! clear the flags before the program sees them. A watchdog reset then reads as
//! unknown: servos go off as after any reset, but no fault is latched. The
//! bootloader of Nanos from before 2018 leaves the watchdog on and never gets
//! as far as this program: the servos keep their last pulses until power-off.
//! Does not depend on the application beyond [`firmware::Boot`].

use avr_device::atmega328p::{CPU, WDT};
use core::arch::{asm, global_asm};

use firmware::Boot;
use protocol::ResetCause;

/// Servos were on: a pattern that memory does not hold by chance after power-on.
const SERVOS_ON: u32 = 0x5E41_0FF1;

// Memory outside .data and .bss: the start-up code leaves it alone. Rust has no
// way to ask for a section without contents, hence the assembler.
global_asm!(
    // Writable memory without contents in the image; a name; four bytes; back to code.
    ".section .noinit,\"aw\",@nobits",
    ".global psto_servos_note",
    "psto_servos_note:",
    ".skip 4",
    ".text",
);

unsafe extern "C" {
    /// Whether servos were on; used by the main program only.
    static mut psto_servos_note: u32;
}

/// Reads and clears the reset flags, and turns the watchdog off.
pub fn take_cause() -> Boot {
    // SAFETY: nothing else touches MCUSR.
    let flags = unsafe { &*CPU::ptr() }.mcusr().read();
    let cause = if flags.porf().bit_is_set() {
        ResetCause::PowerOn
    } else if flags.wdrf().bit_is_set() {
        ResetCause::Watchdog
    } else if flags.borf().bit_is_set() {
        ResetCause::BrownOut
    } else if flags.extrf().bit_is_set() {
        ResetCause::External
    } else {
        ResetCause::Unknown
    };
    // SAFETY: as above. WDRF must be 0 before the watchdog can be turned off.
    unsafe { &*CPU::ptr() }.mcusr().reset();
    write_watchdog(0);
    // SAFETY: a static of our own; volatile, because its value comes from
    // before the reset, which the compiler knows nothing of. Any bits are a u32.
    let note = unsafe { (&raw const psto_servos_note).read_volatile() };
    Boot { cause, servos_were_on: note == SERVOS_ON }
}

/// Writes WDTCSR in its timed sequence, and restarts the watchdog's count.
fn write_watchdog(bits: u8) {
    let register = WDT::ptr().cast::<u8>();
    // SAFETY: the change-enable bits open WDTCSR for 4 cycles (data sheet
    // 10.8.2), which two adjacent stores meet with interrupts off. The register
    // block of the watchdog is WDTCSR alone.
    unsafe {
        #[rustfmt::skip] // Keeps the remarks in a column.
        asm!(
            "in {sreg}, 0x3F",  // keep the flags, and whether interrupts are on
            "cli",              // interrupts off
            "wdr",              // restart the count: the new period may be short
            "st Z, {open}",     // WDTCSR = WDCE and WDE: changes are allowed
            "st Z, {bits}",     // WDTCSR = the new bits
            "wdr",              // restart the count
            "out 0x3F, {sreg}", // interrupts as they were
            sreg = out(reg) _,
            open = in(reg) 0x18_u8,
            bits = in(reg) bits,
            in("Z") register,
        );
    }
}

/// Resets the board 32 ms after the main loop stopped feeding it; then the chip
/// takes 65 ms to start. The longest turn, a start with a stuck bus, takes half
/// of that.
pub struct Watchdog(());

impl Watchdog {
    /// System reset mode, 4 K cycles of 128 kHz.
    pub fn start() -> Self {
        // WDE, and WDP 0b0001.
        write_watchdog(0b0000_1001);
        Self(())
    }
}

impl firmware::hal::Watchdog for Watchdog {
    fn feed(&mut self, servos_on: bool) {
        avr_device::asm::wdr();
        // SAFETY: a static of our own, used by the main program only.
        unsafe { (&raw mut psto_servos_note).write_volatile(if servos_on { SERVOS_ON } else { 0 }) };
    }
}
