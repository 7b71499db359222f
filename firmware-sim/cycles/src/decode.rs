//! Decodes Thumb instructions as far as their cycles depend on them.

/// Cycles of an instruction, and what decides whether it waits for the one before it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Instruction {
    /// Cycles without a wait, and without the refill of the pipeline after a branch.
    pub(crate) cycles: u32,
    /// The core register with the result of an operation on data.
    pub(crate) result: Option<u16>,
    /// The core register that a single load fills.
    pub(crate) loaded: Option<u16>,
    /// Whether it is a load or a store of one core register.
    pub(crate) is_single: bool,
    /// Core registers of the address of a load or a store.
    pub(crate) address: [Option<u16>; 2],
    /// The floating-point register with the result of arithmetic.
    pub(crate) float_result: Option<u16>,
    /// Floating-point registers that are needed at once. The addend of a multiply-accumulate is needed later.
    pub(crate) float_operands: [Option<u16>; 2],
}

/// Longest division of integers. The manual gives 2 to 12 cycles.
const DIVISION: u32 = 12;
/// A floating-point division or square root.
const FLOAT_DIVISION: u32 = 14;
/// A floating-point multiply-accumulate.
const FLOAT_ACCUMULATE: u32 = 3;

/// The program counter as a register: an instruction with it as result compares only.
const PC: u16 = 15;

impl Instruction {
    /// Decodes an instruction by its halfwords. The second one counts only in a wide instruction.
    pub(crate) fn decode([first, second]: [u16; 2], is_wide: bool) -> Self {
        if is_wide { wide(first, second) } else { narrow(first) }
    }

    fn taking(cycles: u32) -> Self {
        Self { cycles, ..Self::default() }
    }

    fn operation(register: u16) -> Self {
        let result = (register != PC).then_some(register);
        Self { result, ..Self::taking(1) }
    }

    fn load(register: u16, address: [Option<u16>; 2]) -> Self {
        Self { loaded: Some(register), is_single: true, address, ..Self::taking(2) }
    }

    /// A store with an immediate offset takes one cycle, one with a register as offset takes two.
    fn store(address: [Option<u16>; 2]) -> Self {
        let cycles = if address[1].is_some() { 2 } else { 1 };
        Self { is_single: true, address, ..Self::taking(cycles) }
    }

    fn multiple(registers: u32, base: u16) -> Self {
        Self { address: [Some(base), None], ..Self::taking(1 + registers) }
    }
}

/// Bits of a halfword, from the lowest one on.
fn bits(halfword: u16, from: u32, count: u32) -> u16 {
    (halfword >> from) & ((1 << count) - 1)
}

fn bit(halfword: u16, at: u32) -> bool {
    bits(halfword, at, 1) == 1
}

fn narrow(h: u16) -> Instruction {
    let low = |from| bits(h, from, 3);
    match bits(h, 11, 5) {
        // Additions and shifts with the result in the lowest bits.
        0b00000..=0b00011 => Instruction::operation(low(0)),
        // Immediates of 8 bits, addresses from the program counter and from the stack pointer.
        0b00100 | 0b00110 | 0b00111 | 0b10100 | 0b10101 => Instruction::operation(low(8)),
        0b01000 => match bits(h, 8, 3) {
            // Tests, comparisons and branches to a register.
            0b010 if matches!(bits(h, 6, 2), 0 | 2 | 3) => Instruction::taking(1),
            0b101 | 0b111 => Instruction::taking(1),
            0b100 | 0b110 => Instruction::operation(bits(h, 7, 1) << 3 | low(0)),
            _ => Instruction::operation(low(0)),
        },
        0b01001 => Instruction::load(low(8), [Some(PC), None]),
        0b01010 | 0b01011 => {
            let address = [Some(low(3)), Some(low(6))];
            let is_store = bits(h, 9, 3) < 0b011;
            if is_store { Instruction::store(address) } else { Instruction::load(low(0), address) }
        }
        // Even codes store, odd ones load, with an immediate offset.
        code @ (0b01100..=0b10001) => {
            let address = [Some(low(3)), None];
            if code & 1 == 0 {
                Instruction::store(address)
            } else {
                Instruction::load(low(0), address)
            }
        }
        0b10010 => Instruction::store([Some(13), None]),
        0b10011 => Instruction::load(low(8), [Some(13), None]),
        // Push and pop, then other instructions of the same group.
        0b10110 | 0b10111 if bits(h, 9, 2) == 0b10 => {
            Instruction::multiple(bits(h, 0, 9).count_ones(), 13)
        }
        0b11000 | 0b11001 => Instruction::multiple(bits(h, 0, 8).count_ones(), low(8)),
        _ => Instruction::taking(1),
    }
}

fn wide(h: u16, second: u16) -> Instruction {
    let base = bits(h, 0, 4);
    // Coprocessors 10 and 11.
    let is_float = bits(h, 10, 2) == 0b11 && bits(second, 9, 3) == 0b101;
    match bits(h, 9, 7) {
        _ if is_float => float(h, second),
        0b111_0100 if bit(h, 6) => match bits(h, 4, 5) {
            // A branch by a table: the load and the addition.
            0b01101 if bits(second, 5, 3) == 0 => Instruction {
                address: [Some(base), Some(bits(second, 0, 4))],
                ..Instruction::taking(3)
            },
            // Exclusive access.
            0b00100 | 0b00101 | 0b01100 | 0b01101 => {
                Instruction { address: [Some(base), None], ..Instruction::taking(2) }
            }
            // Two registers.
            _ => Instruction::multiple(2, base),
        },
        0b111_0100 => Instruction::multiple(second.count_ones(), base),
        0b111_0101 => Instruction::operation(bits(second, 8, 4)),
        0b111_1000..=0b111_1011 if !bit(second, 15) => Instruction::operation(bits(second, 8, 4)),
        0b111_1100 => single(h, second),
        0b111_1101 => match bits(h, 4, 5) {
            // A division, signed or not.
            0b11001 | 0b11011 => {
                Instruction { cycles: DIVISION, ..Instruction::operation(bits(second, 8, 4)) }
            }
            _ => Instruction::operation(bits(second, 8, 4)),
        },
        // Branches, special registers, barriers.
        _ => Instruction::taking(1),
    }
}

/// A load or a store of one core register.
fn single(h: u16, second: u16) -> Instruction {
    let (base, register) = (bits(h, 0, 4), bits(second, 12, 4));
    let has_index = base != PC && !bit(h, 7) && bits(second, 6, 6) == 0;
    let address = [Some(base), has_index.then(|| bits(second, 0, 4))];
    match (bit(h, 4), bits(h, 5, 2)) {
        (false, _) => Instruction::store(address),
        // A preload of a byte or a halfword.
        (true, 0b00 | 0b01) if register == PC => Instruction::taking(1),
        (true, _) => Instruction::load(register, address),
    }
}

/// A floating-point instruction of single precision.
fn float(h: u16, second: u16) -> Instruction {
    let is_double = bit(second, 8);
    // The number of a register of single precision has its lowest bit apart.
    let destination = Some(bits(second, 12, 4) << 1 | bits(h, 6, 1));
    let n = Some(bits(h, 0, 4) << 1 | bits(second, 7, 1));
    let m = Some(bits(second, 0, 4) << 1 | bits(second, 5, 1));
    if bits(h, 9, 3) == 0b110 {
        let address = [Some(bits(h, 0, 4)), None];
        let is_one = bit(h, 8) && !bit(h, 5);
        return match bits(h, 5, 4) {
            // Two core registers.
            0b0010 => Instruction { float_operands: [m, None], ..Instruction::taking(2) },
            _ if is_one => Instruction {
                address,
                float_operands: [destination.filter(|_| !bit(h, 4)), None],
                ..Instruction::taking(if is_double { 3 } else { 2 })
            },
            _ => Instruction::multiple(bits(second, 0, 8).into(), bits(h, 0, 4)),
        };
    }
    let arithmetic = |cycles, float_operands| Instruction {
        cycles,
        float_result: destination,
        float_operands,
        ..Instruction::default()
    };
    match (bit(h, 7), bits(h, 4, 2)) {
        // One core register, or the status.
        _ if bit(second, 4) => Instruction { float_operands: [n, None], ..Instruction::taking(1) },
        (false, 0b00 | 0b01) | (true, 0b01 | 0b10) => arithmetic(FLOAT_ACCUMULATE, [n, m]),
        (false, _) => arithmetic(1, [n, m]),
        (true, 0b00) => arithmetic(FLOAT_DIVISION, [n, m]),
        _ if !bit(second, 6) => Instruction::taking(1),
        _ => match (bits(h, 0, 4), bit(second, 7)) {
            (0b0001, true) => arithmetic(FLOAT_DIVISION, [m, None]),
            // Moves, absolute values, negations.
            (0b0000 | 0b0001, _) => {
                Instruction { float_operands: [m, None], ..Instruction::taking(1) }
            }
            // A comparison, with a register or with zero.
            (0b0100, _) => {
                Instruction { float_operands: [destination, m], ..Instruction::taking(1) }
            }
            (0b0101, _) => {
                Instruction { float_operands: [destination, None], ..Instruction::taking(1) }
            }
            // Conversions.
            _ => arithmetic(1, [m, None]),
        },
    }
}
