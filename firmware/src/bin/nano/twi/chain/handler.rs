//! The bus's interrupt handler, by hand, as far as it is always the same.
//!
//! A frame calls it 160 times. Compiled, it takes 89 cycles, most of them to save
//! registers and to tell the states apart; so, the next byte of the burst takes
//! 53, and a frame 2 % less of the processor. Refuses decisions: an end, a
//! refusal, or anything unknown goes on to [`super::step`].

use core::arch::global_asm;

use crate::shared::{GPIOR0, GPIOR1};

use super::super::{
    ADDRESS_R_ACK, ADDRESS_W_ACK, BURSTS, DATA_R_ACK, DATA_W_ACK, OWNER, READINGS, REPEATED_START, START,
    owner,
};
use super::{ADDRESS, AT, END, power, step};

// TWCR: TWINT, TWEN and TWIE go on; TWSTA asks for a START, TWEA acknowledges.
const GO_ON: u8 = 0x85;
const START_ANEW: u8 = GO_ON | 0x20;
const ACKNOWLEDGE: u8 = GO_ON | 0x40;

// 0xB9 is TWSR, 0xBB TWDR, 0xBC TWCR.
global_asm!(
    ".section .text.twi,\"ax\",@progbits",
    ".global __vector_24",
    "__vector_24:",
    "out {keep_r24}, r24",
    "in r24, 0x3F",
    "out {keep_sreg}, r24",
    "lds r24, 0xB9",
    "andi r24, 0xF8",
    "cpi r24, {data_w_ack}",
    "breq 4f",
    "cpi r24, {repeated_start}",
    "breq 3f",
    "cpi r24, {address_w_ack}",
    "breq 6f",
    "cpi r24, {address_r_ack}",
    "breq 7f",
    "cpi r24, {data_r_ack}",
    "breq 8f",
    "cpi r24, {start}",
    "breq 3f",
    // None of these.
    "2:",
    "in r24, {keep_sreg}",
    "out 0x3F, r24",
    "in r24, {keep_r24}",
    "jmp {step}",
    // A START: the address.
    "3:",
    "lds r24, {address}",
    "sts 0xBB, r24",
    "rjmp 10f",
    // A byte was taken: of a reading, it was the register's number.
    "4:",
    "lds r24, {owner}",
    "cpi r24, {burst}",
    "breq 5f",
    "ldi r24, {address_r}",
    "sts {address}, r24",
    "ldi r24, {start_anew}",
    "rjmp 11f",
    // The burst's next byte.
    "5:",
    "push r30",
    "lds r30, {at}",
    "lds r24, {end}",
    "cp r30, r24",
    "breq 9f",
    "push r31",
    "mov r24, r30",
    "inc r24",
    "sts {at}, r24",
    "ldi r31, 0",
    "subi r30, lo8(-({bursts}))",
    "sbci r31, hi8(-({bursts}))",
    "ld r24, Z",
    "sts 0xBB, r24",
    "pop r31",
    "pop r30",
    "rjmp 10f",
    // An address for writing: the burst's first byte, or the number of a
    // reading's register, 2 at its byte 0 and 1 at its byte 2.
    "6:",
    "lds r24, {owner}",
    "cpi r24, {burst}",
    "breq 5b",
    "lds r24, {at}",
    "andi r24, 2",
    "lsr r24",
    "subi r24, 2",
    "neg r24",
    "sts 0xBB, r24",
    "rjmp 10f",
    // An address for reading: the first of two bytes.
    "7:",
    "ldi r24, {acknowledge}",
    "rjmp 11f",
    // The first of two bytes came.
    "8:",
    "push r30",
    "push r31",
    "lds r30, {at}",
    "mov r24, r30",
    "inc r24",
    "sts {at}, r24",
    "ldi r31, 0",
    "subi r30, lo8(-({readings}))",
    "sbci r31, hi8(-({readings}))",
    "lds r24, 0xBB",
    "st Z, r24",
    "pop r31",
    "pop r30",
    "10:",
    "ldi r24, {go_on}",
    "11:",
    "sts 0xBC, r24",
    "in r24, {keep_sreg}",
    "out 0x3F, r24",
    "in r24, {keep_r24}",
    "reti",
    // The burst's end.
    "9:",
    "pop r30",
    "rjmp 2b",
    ".text",
    keep_r24 = const GPIOR0,
    keep_sreg = const GPIOR1,
    start = const START,
    repeated_start = const REPEATED_START,
    address_w_ack = const ADDRESS_W_ACK,
    data_w_ack = const DATA_W_ACK,
    address_r_ack = const ADDRESS_R_ACK,
    data_r_ack = const DATA_R_ACK,
    burst = const owner::BURST,
    address_r = const power::ADDRESS << 1 | 1,
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
