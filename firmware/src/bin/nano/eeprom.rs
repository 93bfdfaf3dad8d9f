//! The EEPROM, one byte at a time.
//!
//! Holds the registers EEAR, EEDR and EECR. The ready interrupt tells when a byte
//! is done, 3.4 ms after it was started; nothing waits for it. Does not depend on
//! what the bytes mean.

use avr_device::atmega328p::{EEPROM, eeprom};
use avr_device::interrupt::{self, CriticalSection, Mutex};
use core::arch::asm;
use core::cell::Cell;

use firmware::hal::PersistentMemory;

static BUSY: Mutex<Cell<bool>> = Mutex::new(Cell::new(false));

fn registers() -> &'static eeprom::RegisterBlock {
    // SAFETY: the registers are there for good; the interrupt writes EECR only
    // after a write has ended, when the main loop is not using it.
    unsafe { &*EEPROM::ptr() }
}

#[avr_device::interrupt(atmega328p)]
fn EE_READY() {
    // SAFETY: interrupts are off inside an interrupt, and stay off.
    let cs = unsafe { CriticalSection::new() };
    registers().eecr().reset();
    BUSY.borrow(cs).set(false);
}

/// Where the gait is kept.
pub struct Eeprom(());

impl Eeprom {
    /// A reset may have come in the middle of a write, which goes on for up to
    /// 3.4 ms; nothing can be read before it has ended.
    pub fn start() -> Self {
        for _ in 0..40 {
            if registers().eecr().read().eepe().bit_is_clear() {
                break;
            }
            avr_device::asm::delay_cycles(100 * 16);
        }
        Self(())
    }
}

impl PersistentMemory for Eeprom {
    fn is_busy(&self) -> bool {
        interrupt::free(|cs| BUSY.borrow(cs).get())
    }

    fn read(&mut self, at: u16) -> u8 {
        let eeprom = registers();
        eeprom.eear().write(|w| w.set(at));
        eeprom.eecr().write(|w| w.eere().set_bit());
        eeprom.eedr().read().bits()
    }

    fn write(&mut self, at: u16, byte: u8) {
        let eeprom = registers();
        eeprom.eear().write(|w| w.set(at));
        eeprom.eedr().write(|w| w.set(byte));
        interrupt::free(|cs| {
            BUSY.borrow(cs).set(true);
            // SAFETY: EEPE counts only within 4 cycles of EEMPE (data sheet
            // 8.6.3): two adjacent instructions, interrupts off. Then EERIE,
            // for the interrupt at the end. EECR is I/O register 0x1F.
            #[rustfmt::skip] // Keeps the remarks in a column.
            unsafe {
                asm!(
                    "sbi 0x1F, 2", // EEMPE: a write is allowed
                    "sbi 0x1F, 1", // EEPE: write
                    "sbi 0x1F, 3", // EERIE: interrupt when it is done
                    options(nostack)
                );
            };
        });
    }
}
