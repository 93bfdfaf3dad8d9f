//! The port's two interrupt handlers, by hand.
//!
//! A flooded line calls each of them 11,500 times a second. Compiled, they save
//! registers for a third of their time: 78 and 57 cycles, where these take 54 and
//! 43, together 3 % of the processor. Holds the way of a byte between UDR0 and a
//! ring. Does not depend on what the bytes mean, but for the stop byte and the 0
//! that ends a frame.
//!
//! # Reading it
//! - r24 and r25 hold bytes and indices, Z (r30 low, r31 high) is a pointer. Each
//!   register that is changed is kept and restored, and so are the processor's flags
//!   (SREG): to spare I/O registers, 1 cycle each way, or by `push` and `pop`.
//! - `in`, `out` reach the I/O registers; `lds`, `sts` any memory, the port's
//!   registers at their addresses included: 0xC0 is UCSR0A (status), 0xC1 UCSR0B
//!   (control), 0xC6 UDR0 (data).
//! - `subi`, `sbci` with a negated constant add it: AVR has no "add immediate".
//! - `5f` is the next label `5:` forward, `3b` the last one backward.
//! - A ring's bytes come first in its memory, then `head`, then `tail`.

use core::arch::global_asm;
use core::mem::offset_of;

use crate::shared::{GPIOR0, GPIOR1, GPIOR2};

use super::{DROPPED, ENDS_IN, RECEIVE_ONLY, RECEIVED, RECEIVED_LEN, Ring, STOPPED, TO_SEND, TO_SEND_LEN};
use protocol::frame::STOP_BYTE;

// USART_RX, a byte came: from UDR0 to the ring.
#[rustfmt::skip] // Keeps the remarks in a column.
global_asm!(
    ".section .text.usart_rx,\"ax\",@progbits",
    ".global __vector_18",     // the chip jumps here on interrupt 18, USART_RX
    "__vector_18:",
    // Keep what is changed.
    "out {keep_r24}, r24",     // keep r24
    "in r24, 0x3F",            // r24 = SREG
    "out {keep_sreg}, r24",    // keep SREG
    "out {keep_r25}, r25",     // keep r25
    "push r30",                // keep Z
    "push r31",
    // Read status and byte, in this order: reading the byte clears the status.
    "lds r30, 0xC0",           // r30 = UCSR0A
    "lds r24, 0xC6",           // r24 = UDR0, the byte
    "sbrc r30, 3",             // skip a line unless bit 3 tells of an overrun
    "rjmp 5f",                 //   an overrun: to 5, and back to 1
    "1:",
    "cpi r24, {stop}",         // the stop byte?
    "breq 4f",                 //   then to 4
    // The next head; if it is the tail, the ring is full.
    "lds r30, {ring} + {head}", // r30 = head
    "mov r25, r30",            // r25 = head
    "inc r25",                 // r25 = head + 1
    "andi r25, {mask}",        // around the ring's end
    "lds r31, {ring} + {tail}", // r31 = tail
    "cp r25, r31",             // no room?
    "breq 6f",                 //   then to 6
    // ring[head] = byte.
    "ldi r31, 0",              // Z = head, in 16 bits
    "subi r30, lo8(-({ring}))", // Z += address of the ring, low byte
    "sbci r31, hi8(-({ring}))", //   and high byte with the carry
    "st Z, r24",               // the byte at Z = r24
    "sts {ring} + {head}, r25", // head = r25: now the main loop may see the byte
    // The end of a frame is counted.
    "tst r24",                 // is the byte 0?
    "brne 3f",                 //   if not, to 3
    "lds r24, {ends_in}",      // r24 = ENDS_IN
    "inc r24",                 // r24 + 1
    "sts {ends_in}, r24",      // ENDS_IN = r24
    // Restore what was kept, and return.
    "3:",
    "pop r31",                 // restore Z
    "pop r30",
    "in r25, {keep_r25}",      // restore r25
    "in r24, {keep_sreg}",     // r24 = the kept SREG
    "out 0x3F, r24",           // restore SREG
    "in r24, {keep_r24}",      // restore r24
    "reti",                    // back to the interrupted code
    // The stop byte goes past the ring; it is not 0, and so marks itself.
    "4:",
    "sts {stopped}, r24",      // STOPPED = the byte
    "rjmp 3b",                 // done
    // A byte before this one was lost in the receiver: count it, and go on.
    "5:",
    "lds r30, {dropped}",      // Z = DROPPED, low byte
    "lds r31, {dropped} + 1",  //   and high byte
    "adiw r30, 1",             // Z + 1
    "sts {dropped} + 1, r31",  // DROPPED = Z
    "sts {dropped}, r30",
    "rjmp 1b",                 // on with this byte
    // The ring is full, and this byte is lost: count it.
    "6:",
    "lds r30, {dropped}",      // Z = DROPPED, low byte
    "lds r31, {dropped} + 1",  //   and high byte
    "adiw r30, 1",             // Z + 1
    "sts {dropped} + 1, r31",  // DROPPED = Z
    "sts {dropped}, r30",
    "rjmp 3b",                 // done
    ".text",                   // compiled code goes on in its own section
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

// USART_UDRE, the transmit register is empty: from the ring to UDR0.
#[rustfmt::skip] // Keeps the remarks in a column.
global_asm!(
    ".section .text.usart_udre,\"ax\",@progbits",
    ".global __vector_19",     // the chip jumps here on interrupt 19, USART_UDRE
    "__vector_19:",
    // Keep what is changed.
    "out {keep_r24}, r24",     // keep r24
    "in r24, 0x3F",            // r24 = SREG
    "out {keep_sreg}, r24",    // keep SREG
    "push r30",                // keep Z
    "push r31",
    // Anything to send?
    "lds r30, {ring} + {tail}", // r30 = tail
    "lds r31, {ring} + {head}", // r31 = head
    "cp r30, r31",             // an empty ring?
    "breq 2f",                 //   then to 2
    // UDR0 = ring[tail].
    "mov r24, r30",            // r24 = tail
    "inc r24",                 // r24 = tail + 1
    "andi r24, {mask}",        // around the ring's end
    "sts {ring} + {tail}, r24", // tail = r24: the place is free
    "ldi r31, 0",              // Z = the old tail, in 16 bits
    "subi r30, lo8(-({ring}))", // Z += address of the ring, low byte
    "sbci r31, hi8(-({ring}))", //   and high byte with the carry
    "ld r24, Z",               // r24 = the byte at Z
    "sts 0xC6, r24",           // UDR0 = r24: it goes out
    // Restore what was kept, and return.
    "1:",
    "pop r31",                 // restore Z
    "pop r30",
    "in r24, {keep_sreg}",     // r24 = the kept SREG
    "out 0x3F, r24",           // restore SREG
    "in r24, {keep_r24}",      // restore r24
    "reti",                    // back to the interrupted code
    // Nothing left: this interrupt off, or it would come again at once.
    "2:",
    "ldi r24, {receive_only}", // r24 = UCSR0B's value without it
    "sts 0xC1, r24",           // UCSR0B = r24
    "rjmp 1b",                 // done
    ".text",                   // compiled code goes on in its own section
    keep_r24 = const GPIOR0,
    keep_sreg = const GPIOR1,
    ring = sym TO_SEND,
    head = const offset_of!(Ring<TO_SEND_LEN>, head),
    tail = const offset_of!(Ring<TO_SEND_LEN>, tail),
    mask = const Ring::<TO_SEND_LEN>::MASK,
    receive_only = const RECEIVE_ONLY,
);
