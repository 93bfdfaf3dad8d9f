//! 32 by 16 bits, by the multiplier of the chip.
//!
//! Holds one product, rounded to its upper 32 bits. The compiler knows products of
//! 8 bits and of equal halves only: through its library, one of these takes 150
//! cycles instead of 50, and a frame has a hundred of them. Does not depend on
//! what is multiplied.
//!
//! # Reading it
//! `mul` (unsigned), `muls` (signed) and `mulsu` (signed, unsigned) multiply two
//! registers of 8 bits and leave 16 in r1:r0. So the product is made of eight, each
//! added at its weight. The value's bytes come in r20 (lowest) to r23, the factor's
//! in r18 and r19; r30 is 0, for adding nothing but a carry. A signed product that is
//! negative leaves the carry set, and `sbc` with 0 takes it from the byte above: the
//! extension of its sign.

use core::arch::asm;

use protocol::gait::Product;

/// [`Product`] in eight instructions of `mul`'s family.
pub struct Mul;

impl Product for Mul {
    #[inline(always)]
    fn of(value: i32, factor: i16) -> i32 {
        let (low, high): (u16, u16);
        // SAFETY: arithmetic on the named registers; r1 is zero again at the end,
        // as compiled code expects it.
        unsafe {
            #[rustfmt::skip] // Keeps the remarks in a column.
            asm!(
                // The value's lower half, unsigned, times the factor: only what it
                // carries into the upper half counts, rounded. Sum in r27:r26:r25:r24.
                "mul r20, r18",    // byte 0 x factor low
                "movw r24, r0",    // sum = it
                "mulsu r19, r21",  // factor high x byte 1, at weight 2^16
                "movw r26, r0",    // upper bytes of the sum = it
                "mul r21, r18",    // byte 1 x factor low, at weight 2^8
                "add r25, r0",     // sum += it
                "adc r26, r1",
                "adc r27, r30",    // and the carry
                "mulsu r19, r20",  // factor high x byte 0, at weight 2^8
                "sbc r27, r30",    // extend its sign
                "add r25, r0",     // sum += it
                "adc r26, r1",
                "adc r27, r30",    // and the carry
                "subi r25, 0x80",  // sum += 2^15, to round: minus -0x8000
                "sbci r26, 0xFF",
                "sbci r27, 0xFF",
                // The upper half, signed, times the factor. Sum in r25:r24:r21:r20.
                "mul r22, r18",    // byte 2 x factor low
                "movw r20, r0",    // sum = it
                "muls r23, r19",   // byte 3 x factor high, at weight 2^16
                "movw r24, r0",    // upper bytes of the sum = it
                "mulsu r23, r18",  // byte 3 x factor low, at weight 2^8
                "sbc r25, r30",    // extend its sign
                "add r21, r0",     // sum += it
                "adc r24, r1",
                "adc r25, r30",    // and the carry
                "mulsu r19, r22",  // factor high x byte 2, at weight 2^8
                "sbc r25, r30",    // extend its sign
                "add r21, r0",     // sum += it
                "adc r24, r1",
                "adc r25, r30",    // and the carry
                // Add what the lower half carries: 16 bits with a sign.
                "add r20, r26",    // sum += r27:r26
                "adc r21, r27",
                "adc r24, r30",    // and the carry
                "adc r25, r30",
                "sbrc r27, 7",     // skip a line unless that was negative
                "sbiw r24, 1",     //   extend its sign
                "movw r22, r24",   // the result in r23 to r20
                "eor r1, r1",      // r1 = 0 again
                inout("r21r20") value as u16 => low,
                inout("r23r22") (value >> 16) as u16 => high,
                in("r19r18") factor,
                in("r30") 0_u8,
                out("r25r24") _,
                out("r27r26") _,
                options(pure, nomem, nostack),
            );
        }
        (u32::from(high) << 16 | u32::from(low)) as i32
    }
}
