//! The two loops that compiled code calls to copy and to fill memory.
//!
//! Holds `memcpy` and `memset`. In the compiler's own library they take 480 bytes
//! of flash, unrolled for processors with words to move; here 34. Does not depend
//! on anything else.

use core::arch::global_asm;

// memcpy(to r25:r24, from r23:r22, len r21:r20) and memset(to r25:r24, byte
// r22, len r21:r20), by the C calling convention: r0, X, Z and the arguments are
// free to use, and `to` is returned where it came in.
// X is r27:r26, Z is r31:r30; `Z+` is the byte at Z, which then points at the next.
#[rustfmt::skip] // Keeps the remarks in a column.
global_asm!(
    ".section .text.psto_memory,\"ax\",@progbits",
    ".global memcpy",
    "memcpy:",
    "movw r26, r24",   // X = to
    "movw r30, r22",   // Z = from
    "rjmp 2f",         // count first: the length may be 0
    "1: ld r0, Z+",    // r0 = the next byte
    "st X+, r0",       // store it
    "2: subi r20, 1",  // length - 1
    "sbci r21, 0",
    "brcc 1b",         // again, unless it was 0 before
    "ret",
    ".global memset",
    "memset:",
    "movw r26, r24",   // X = to
    "rjmp 2f",         // count first: the length may be 0
    "1: st X+, r22",   // store the byte
    "2: subi r20, 1",  // length - 1
    "sbci r21, 0",
    "brcc 1b",         // again, unless it was 0 before
    "ret",
    ".text",           // compiled code goes on in its own section
);
