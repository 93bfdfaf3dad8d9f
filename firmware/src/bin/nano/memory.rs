//! The two loops that compiled code calls to copy and to fill memory.
//!
//! In the compiler's own library they take 480 bytes of flash, unrolled for
//! processors with words to move; here 34.

use core::arch::global_asm;

// memcpy(to r25:r24, from r23:r22, len r21:r20) and memset(to r25:r24, byte
// r22, len r21:r20), by the C calling convention: r0, X, Z and the arguments are
// free to use, and `to` is returned where it came in.
global_asm!(
    ".section .text.psto_memory,\"ax\",@progbits",
    ".global memcpy",
    "memcpy:",
    "movw r26, r24",
    "movw r30, r22",
    "rjmp 2f",
    "1: ld r0, Z+",
    "st X+, r0",
    "2: subi r20, 1",
    "sbci r21, 0",
    "brcc 1b",
    "ret",
    ".global memset",
    "memset:",
    "movw r26, r24",
    "rjmp 2f",
    "1: st X+, r22",
    "2: subi r20, 1",
    "sbci r21, 0",
    "brcc 1b",
    "ret",
    ".text",
);
