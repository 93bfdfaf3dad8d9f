//! 32 by 16 bits, by the multiplier of the chip.
//!
//! Owns no register but those it names. The compiler knows products of 8 bits
//! and of equal halves only: through its library, one of these takes 150 cycles
//! instead of 50, and a frame has a hundred of them.

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
            asm!(
                // The lower half, unsigned, times the factor: only its carry into
                // the upper half counts, rounded.
                "mul r20, r18",
                "movw r24, r0",
                "mulsu r19, r21",
                "movw r26, r0",
                "mul r21, r18",
                "add r25, r0",
                "adc r26, r1",
                "adc r27, r30",
                "mulsu r19, r20",
                "sbc r27, r30",
                "add r25, r0",
                "adc r26, r1",
                "adc r27, r30",
                "subi r25, 0x80",
                "sbci r26, 0xFF",
                "sbci r27, 0xFF",
                // The upper half, signed, times the factor.
                "mul r22, r18",
                "movw r20, r0",
                "muls r23, r19",
                "movw r24, r0",
                "mulsu r23, r18",
                "sbc r25, r30",
                "add r21, r0",
                "adc r24, r1",
                "adc r25, r30",
                "mulsu r19, r22",
                "sbc r25, r30",
                "add r21, r0",
                "adc r24, r1",
                "adc r25, r30",
                // The carry is signed.
                "add r20, r26",
                "adc r21, r27",
                "adc r24, r30",
                "adc r25, r30",
                "sbrc r27, 7",
                "sbiw r24, 1",
                "movw r22, r24",
                "eor r1, r1",
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
