//! Cycles of a block of instructions.

use crate::decode::Instruction;

/// Bytes that the flash delivers at once, 128 bits.
const LINE: u64 = 16;

/// Cycles of a block by the table of the processor's technical reference manual, with the waits that the manual states
/// for neighbours:
///
/// * A single load or store takes one cycle less after a load whose result is not part of its address.
/// * A load or store waits a cycle for an address that the instruction before it has computed.
/// * A floating-point result that the next instruction needs takes a cycle more.
pub(crate) fn cycles(block: &[Instruction]) -> u32 {
    let alone: u32 = block.iter().map(|instruction| instruction.cycles).sum();
    let (mut saved, mut waits) = (0, 0);
    for pair in block.windows(2) {
        let [before, now] = pair else { continue };
        let needs = |register: Option<u16>| register.is_some() && now.address.contains(&register);
        let follows_load = before.loaded.is_some() && now.is_single && now.cycles > 1;
        saved += u32::from(follows_load && !needs(before.loaded));
        waits += u32::from(needs(before.result));
        let float = before.float_result;
        waits += u32::from(float.is_some() && now.float_operands.contains(&float));
    }
    alone - saved + waits
}

/// Lines of flash that the addresses of a block are in.
pub(crate) fn lines(start: u64, end: u64) -> u32 {
    let lines = end.div_ceil(LINE) - start / LINE;
    u32::try_from(lines).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block by its halfwords; a wide instruction is one number.
    fn block(codes: &[u32]) -> Vec<Instruction> {
        let half = |code: u32| u16::try_from(code & 0xffff).unwrap();
        let decode = |&code: &u32| match code >> 16 {
            0 => Instruction::decode([half(code), 0], false),
            first => Instruction::decode([half(first), half(code)], true),
        };
        codes.iter().map(decode).collect()
    }

    /// Encodings of the assembler, and the cycles of the manual's tables 3-1 and 7-1.
    const ALONE: [(&str, u32, u32); 42] = [
        ("adds r0, r1, r2", 0x1888, 1),
        ("movs r0, #1", 0x2001, 1),
        ("cmp r0, r1", 0x4288, 1),
        ("muls r0, r1", 0x4348, 1),
        ("bx lr", 0x4770, 1),
        ("ldr r0, [pc, #4]", 0x4801, 2),
        ("ldr r0, [r1, r2]", 0x5888, 2),
        ("str r0, [r1, r2]", 0x5088, 2),
        ("ldr r0, [r1, #4]", 0x6848, 2),
        ("str r0, [r1, #4]", 0x6048, 1),
        ("ldrh r0, [r1, #2]", 0x8848, 2),
        ("str r0, [sp, #4]", 0x9001, 1),
        ("ldr r0, [sp, #4]", 0x9801, 2),
        ("push {r4, r5, lr}", 0xb530, 4),
        ("pop {r4, r5, pc}", 0xbd30, 4),
        ("cbz r0, 8", 0xb110, 1),
        ("it eq", 0xbf08, 1),
        ("stmia r0!, {r1, r2}", 0xc006, 3),
        ("ldmia r0!, {r1, r2, r3}", 0xc80e, 4),
        ("beq 8", 0xd002, 1),
        ("push.w {r4-r8, lr}", 0xe92d_41f0, 7),
        ("ldrd r0, r1, [r2]", 0xe9d2_0100, 3),
        ("ldrex r0, [r1]", 0xe851_0f00, 2),
        ("tbb [pc, r0]", 0xe8df_f000, 3),
        ("add.w r0, r1, r2, lsl #2", 0xeb01_0082, 1),
        ("movw r0, #1234", 0xf240_40d2, 1),
        ("bl 8", 0xf000_f802, 1),
        ("str.w r0, [r1, #64]", 0xf8c1_0040, 1),
        ("str.w r0, [r1, r2, lsl #2]", 0xf841_0022, 2),
        ("ldr.w r0, [r1, #-4]", 0xf851_0c04, 2),
        ("smull r0, r1, r2, r3", 0xfb82_0103, 1),
        ("udiv r0, r1, r2", 0xfbb1_f0f2, 12),
        ("vldr s0, [r0]", 0xed90_0a00, 2),
        ("vldr d0, [r0]", 0xed90_0b00, 3),
        ("vpush {d8-d9}", 0xed2d_8b04, 5),
        ("vmov r0, r1, d0", 0xec51_0b10, 2),
        ("vmov s0, r0", 0xee00_0a10, 1),
        ("vmla.f32 s0, s1, s2", 0xee00_0a81, 3),
        ("vfma.f32 s0, s1, s2", 0xeea0_0a81, 3),
        ("vdiv.f32 s0, s1, s2", 0xee80_0a81, 14),
        ("vsqrt.f32 s0, s1", 0xeeb1_0ae0, 14),
        ("vmov.f32 s0, s1", 0xeeb0_0a60, 1),
    ];

    #[test]
    fn an_instruction_alone_takes_the_cycles_of_the_manual() {
        for (text, code, expected) in ALONE {
            assert_eq!(cycles(&block(&[code])), expected, "{text}");
        }
    }

    #[test]
    fn loads_in_a_row_take_one_cycle_less() {
        // The manual's examples.
        let [load_r0_r1, load_r1_r2] = [0x6808, 0x6811];
        assert_eq!(cycles(&block(&[load_r0_r1, load_r1_r2])), 3);
        let [load_indexed, store_indexed] = [0x5888, 0x5099];
        assert_eq!(cycles(&block(&[load_indexed, store_indexed])), 3);
        assert_eq!(cycles(&block(&[0x5948, 0x6811, 0x685a])), 4);
        // The second load needs the result of the first one.
        let load_r1_r0 = 0x6801;
        assert_eq!(cycles(&block(&[load_r0_r1, load_r1_r0])), 4);
    }

    #[test]
    fn an_address_just_computed_takes_a_cycle_more() {
        let [add_r1, load_r0_r1, move_r2] = [0x1889, 0x6808, 0x2201];
        assert_eq!(cycles(&block(&[add_r1, load_r0_r1])), 4);
        assert_eq!(cycles(&block(&[add_r1, move_r2, load_r0_r1])), 4);
    }

    #[test]
    fn a_floating_point_result_that_is_needed_at_once_takes_a_cycle_more() {
        let multiply_s0 = 0xee20_0a81;
        let [add_s0_s0_s3, add_s4, accumulate_s0] = [0xee30_0a21, 0xee31_2a81, 0xee00_0a81];
        assert_eq!(cycles(&block(&[multiply_s0, add_s0_s0_s3])), 3);
        assert_eq!(cycles(&block(&[multiply_s0, add_s4])), 2);
        // The addend is needed later.
        assert_eq!(cycles(&block(&[multiply_s0, accumulate_s0])), 4);
        let store_s0 = 0xed80_0a00;
        assert_eq!(cycles(&block(&[multiply_s0, store_s0])), 4);
    }

    #[test]
    fn a_block_is_in_as_many_lines_as_its_addresses() {
        assert_eq!([lines(16, 18), lines(14, 18), lines(16, 32), lines(30, 50)], [1, 2, 1, 3]);
    }
}
