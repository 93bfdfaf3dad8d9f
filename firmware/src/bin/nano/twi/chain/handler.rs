//! The bus's interrupt handler, by hand, for the steps that are the same every time.
//!
//! A frame calls it 160 times. Compiled, it takes 89 cycles, most of them to save
//! registers and to tell the states apart; so, the next byte of the burst takes
//! 53, and a frame 2 % less of the processor. Holds no decisions: an end, a
//! refusal, or anything unknown is [`super::step`]'s. Does not depend on the main
//! loop: it only reads what [`super`] has set up.
//!
//! # Reading it
//! TWI interrupts after each step on the bus and puts a status code into TWSR. The
//! handler looks at it, prepares the next step, and starts that by writing TWCR.
//!
//! - r24 is the only register in use until a branch needs more; Z (r30 low, r31
//!   high) is a pointer. Each register that is changed is kept and restored, and so
//!   are the processor's flags (SREG), for the interrupted code depends on all of
//!   them. r24 and SREG go to two spare I/O registers, 1 cycle each way; `push` and
//!   `pop` take 2.
//! - `in`, `out` reach the I/O registers; `lds`, `sts` any memory, TWI's registers
//!   at their addresses included: 0xB9 is TWSR (status), 0xBB TWDR (data), 0xBC
//!   TWCR (control).
//! - `subi`, `sbci` with a negated constant add it: AVR has no "add immediate".
//! - `5f` is the next label `5:` forward, `5b` the last one backward.

use core::arch::global_asm;

use crate::shared::{GPIOR0, GPIOR1};

use super::super::{
    ADDRESS_R_ACK, ADDRESS_W_ACK, BURSTS, DATA_R_ACK, DATA_W_ACK, OWNER, READINGS, REPEATED_START, START,
    owner,
};
use super::{ADDRESS, AT, END, PowerSensor, SensorChip, step};

/// TWCR: TWINT (bit 7, writing 1 starts the next step), TWEN (2, the unit is on)
/// and TWIE (0, it interrupts).
const GO_ON: u8 = 0x85;
/// With TWSTA: a START.
const START_ANEW: u8 = GO_ON | 0x20;
/// With TWEA: acknowledge the byte that comes.
const ACKNOWLEDGE: u8 = GO_ON | 0x40;

#[rustfmt::skip] // Keeps the remarks in a column.
global_asm!(
    ".section .text.twi,\"ax\",@progbits",
    ".global __vector_24",     // the chip jumps here on interrupt 24, TWI
    "__vector_24:",
    // Keep what is changed, and read the status.
    "out {keep_r24}, r24",     // keep r24
    "in r24, 0x3F",            // r24 = SREG
    "out {keep_sreg}, r24",    // keep SREG
    "lds r24, 0xB9",           // r24 = TWSR
    "andi r24, 0xF8",          // without the prescaler's bits: the status code
    // The commonest status first.
    "cpi r24, {data_w_ack}",   // a byte that we sent was acknowledged?
    "breq 4f",                 //   then to 4
    "cpi r24, {repeated_start}", // a repeated START is on the bus?
    "breq 3f",                 //   then to 3
    "cpi r24, {address_w_ack}", // our address for writing was acknowledged?
    "breq 6f",                 //   then to 6
    "cpi r24, {address_r_ack}", // our address for reading was acknowledged?
    "breq 7f",                 //   then to 7
    "cpi r24, {data_r_ack}",   // a byte came, and we acknowledged it?
    "breq 8f",                 //   then to 8
    "cpi r24, {start}",        // a START is on the bus?
    "breq 3f",                 //   then to 3
    // None of these: as if nothing had happened so far, to the compiled handler.
    "2:",
    "in r24, {keep_sreg}",     // r24 = the kept SREG
    "out 0x3F, r24",           // restore SREG
    "in r24, {keep_r24}",      // restore r24
    "jmp {step}",              // `step` saves registers itself, and returns
    // After a START: send the address.
    "3:",
    "lds r24, {address}",      // r24 = ADDRESS, with the read bit
    "sts 0xBB, r24",           // TWDR = r24
    "rjmp 10f",                // go on
    // A byte of ours was taken. Of a burst: send the next one. Of a reading, it was
    // the register's number: a repeated START, then the address for reading.
    "4:",
    "lds r24, {owner}",        // r24 = who drives the bus
    "cpi r24, {burst}",        // the burst?
    "breq 5f",                 //   then to 5
    "ldi r24, {address_r}",    // r24 = the sensor's address, for reading
    "sts {address}, r24",      // ADDRESS = r24, for after the START
    "ldi r24, {start_anew}",   // r24 = TWCR's value for a repeated START
    "rjmp 11f",                // go on with it
    // The burst's next byte, BURSTS[AT].
    "5:",
    "push r30",                // keep Z's low byte
    "lds r30, {at}",           // r30 = AT
    "lds r24, {end}",          // r24 = END
    "cp r30, r24",             // was that the last byte?
    "breq 9f",                 //   then to 9
    "push r31",                // keep Z's high byte
    "mov r24, r30",            // r24 = AT
    "inc r24",                 // r24 = AT + 1
    "sts {at}, r24",           // AT = r24
    "ldi r31, 0",              // Z = the old AT, in 16 bits
    "subi r30, lo8(-({bursts}))", // Z += address of BURSTS, low byte
    "sbci r31, hi8(-({bursts}))", //   and high byte with the carry
    "ld r24, Z",               // r24 = the byte at Z
    "sts 0xBB, r24",           // TWDR = r24
    "pop r31",                 // restore Z
    "pop r30",
    "rjmp 10f",                // go on
    // Our address for writing was acknowledged. Of a burst: send its first byte. Of
    // a reading: send the number of the register to read, the voltage's when AT is
    // at byte 0 of its four, the current's when it is at byte 2.
    "6:",
    "lds r24, {owner}",        // r24 = who drives the bus
    "cpi r24, {burst}",        // the burst?
    "breq 5b",                 //   then to 5
    "lds r24, {at}",           // r24 = AT
    "andi r24, 2",             // byte 0 or byte 2? (`ldi` leaves the answer as it is)
    "ldi r24, {current_register}", // r24 = the current's register
    "brne 12f",                //   byte 2: that is right
    "ldi r24, {voltage_register}", //   byte 0: r24 = the voltage's register
    "12:",
    "sts 0xBB, r24",           // TWDR = r24
    "rjmp 10f",                // go on
    // Our address for reading was acknowledged: let the first of two bytes come.
    "7:",
    "ldi r24, {acknowledge}",  // r24 = TWCR's value to acknowledge it
    "rjmp 11f",                // go on with it
    // The first of two bytes came: READINGS[AT] = TWDR. The second one will not be
    // acknowledged, which makes its end `step`'s.
    "8:",
    "push r30",                // keep Z
    "push r31",
    "lds r30, {at}",           // r30 = AT
    "mov r24, r30",            // r24 = AT
    "inc r24",                 // r24 = AT + 1
    "sts {at}, r24",           // AT = r24
    "ldi r31, 0",              // Z = the old AT, in 16 bits
    "subi r30, lo8(-({readings}))", // Z += address of READINGS, low byte
    "sbci r31, hi8(-({readings}))", //   and high byte with the carry
    "lds r24, 0xBB",           // r24 = TWDR
    "st Z, r24",               // the byte at Z = r24
    "pop r31",                 // restore Z
    "pop r30",
    // Start the next step, restore what was kept, and return.
    "10:",
    "ldi r24, {go_on}",        // r24 = TWCR's value to go on without a START
    "11:",
    "sts 0xBC, r24",           // TWCR = r24: the bus moves
    "in r24, {keep_sreg}",     // r24 = the kept SREG
    "out 0x3F, r24",           // restore SREG
    "in r24, {keep_r24}",      // restore r24
    "reti",                    // back to the interrupted code
    // The burst's last byte was acknowledged: `step` ends it.
    "9:",
    "pop r30",                 // restore Z's low byte
    "rjmp 2b",                 // to 2
    ".text",                   // compiled code goes on in its own section
    keep_r24 = const GPIOR0,
    keep_sreg = const GPIOR1,
    start = const START,
    repeated_start = const REPEATED_START,
    address_w_ack = const ADDRESS_W_ACK,
    data_w_ack = const DATA_W_ACK,
    address_r_ack = const ADDRESS_R_ACK,
    data_r_ack = const DATA_R_ACK,
    burst = const owner::BURST,
    address_r = const SensorChip::ADDRESS << 1 | 1,
    voltage_register = const SensorChip::VOLTAGE_REGISTER,
    current_register = const SensorChip::CURRENT_REGISTER,
    go_on = const GO_ON,
    start_anew = const START_ANEW,
    acknowledge = const ACKNOWLEDGE,
    owner = sym OWNER,
    address = sym ADDRESS,
    at = sym AT,
    end = sym END,
    bursts = sym BURSTS,
    readings = sym READINGS,
    step = sym step,
);
