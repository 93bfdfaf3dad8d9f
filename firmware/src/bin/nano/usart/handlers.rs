//! The port's two interrupt handlers, by hand.
//!
//! A flooded line calls each of them 11,500 times a second. Compiled, they save
//! registers for a third of their time: 78 and 57 cycles, where these take 54 and
//! 43, together 4 % of the processor. The general-purpose I/O registers are the
//! handlers' scratch: nothing else uses them, and no handler is ever interrupted.

use core::arch::global_asm;
use core::mem::offset_of;

use super::{DROPPED, ENDS_IN, RECEIVED, RECEIVED_LEN, Ring, STOPPED, TO_SEND, TO_SEND_LEN};
use protocol::frame::STOP_BYTE;

// USART_RX: UDR0 to the ring. Bit 3 of UCSR0A, an overrun, belongs to the byte
// that is read next. r24 is the byte, r25 the ring's next head.
global_asm!(
    ".section .text.usart_rx,\"ax\",@progbits",
    ".global __vector_18",
    "__vector_18:",
    "out {keep_r24}, r24",
    "in r24, 0x3F",
    "out {keep_sreg}, r24",
    "out {keep_r25}, r25",
    "push r30",
    "push r31",
    "lds r30, 0xC0",
    "lds r24, 0xC6",
    "sbrc r30, 3",
    "rjmp 5f",
    "1:",
    "cpi r24, {stop}",
    "breq 4f",
    "lds r30, {ring} + {head}",
    "mov r25, r30",
    "inc r25",
    "andi r25, {mask}",
    "lds r31, {ring} + {tail}",
    "cp r25, r31",
    "breq 6f",
    "ldi r31, 0",
    "subi r30, lo8(-({ring}))",
    "sbci r31, hi8(-({ring}))",
    "st Z, r24",
    "sts {ring} + {head}, r25",
    // The end of a frame is counted.
    "tst r24",
    "brne 3f",
    "lds r24, {ends_in}",
    "inc r24",
    "sts {ends_in}, r24",
    "3:",
    "pop r31",
    "pop r30",
    "in r25, {keep_r25}",
    "in r24, {keep_sreg}",
    "out 0x3F, r24",
    "in r24, {keep_r24}",
    "reti",
    // The stop byte, which is not 0.
    "4:",
    "sts {stopped}, r24",
    "rjmp 3b",
    // A byte before this one was lost.
    "5:",
    "lds r30, {dropped}",
    "lds r31, {dropped} + 1",
    "adiw r30, 1",
    "sts {dropped} + 1, r31",
    "sts {dropped}, r30",
    "rjmp 1b",
    // The ring is full: this byte is lost.
    "6:",
    "lds r30, {dropped}",
    "lds r31, {dropped} + 1",
    "adiw r30, 1",
    "sts {dropped} + 1, r31",
    "sts {dropped}, r30",
    "rjmp 3b",
    ".text",
    keep_r24 = const GPIOR0,
    keep_sreg = const GPIOR1,
    keep_r25 = const GPIOR2,
    stop = const STOP_BYTE,
    ring = sym RECEIVED,
    head = const offset_of!(Ring<RECEIVED_LEN>, head),
    tail = const offset_of!(Ring<RECEIVED_LEN>, tail),
    mask = const Ring::<RECEIVED_LEN>::MASK,
    ends_in = sym ENDS_IN,
    stopped = sym STOPPED,
    dropped = sym DROPPED,
);

// USART_UDRE: the ring to UDR0; off where nothing is left.
global_asm!(
    ".section .text.usart_udre,\"ax\",@progbits",
    ".global __vector_19",
    "__vector_19:",
    "out {keep_r24}, r24",
    "in r24, 0x3F",
    "out {keep_sreg}, r24",
    "push r30",
    "push r31",
    "lds r30, {ring} + {tail}",
    "lds r31, {ring} + {head}",
    "cp r30, r31",
    "breq 2f",
    "mov r24, r30",
    "inc r24",
    "andi r24, {mask}",
    "sts {ring} + {tail}, r24",
    "ldi r31, 0",
    "subi r30, lo8(-({ring}))",
    "sbci r31, hi8(-({ring}))",
    "ld r24, Z",
    "sts 0xC6, r24",
    "1:",
    "pop r31",
    "pop r30",
    "in r24, {keep_sreg}",
    "out 0x3F, r24",
    "in r24, {keep_r24}",
    "reti",
    "2:",
    "ldi r24, {receive_only}",
    "sts 0xC1, r24",
    "rjmp 1b",
    ".text",
    keep_r24 = const GPIOR0,
    keep_sreg = const GPIOR1,
    ring = sym TO_SEND,
    head = const offset_of!(Ring<TO_SEND_LEN>, head),
    tail = const offset_of!(Ring<TO_SEND_LEN>, tail),
    mask = const Ring::<TO_SEND_LEN>::MASK,
    receive_only = const super::RECEIVE_ONLY,
);

// I/O addresses.
const GPIOR0: u8 = 0x1E;
const GPIOR1: u8 = 0x2A;
const GPIOR2: u8 = 0x2B;
