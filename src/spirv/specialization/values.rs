//! Scalars that are known before a kernel runs: 32-bit integers, and booleans as 0 and 1.

use rspirv::spirv::{Op, Word};

use super::code::{self, Instruction};

/// Words of an instruction before its operands: the first, the type and the id of its result.
const OPERANDS: usize = 3;

/// Number of ids that a page has.
const PAGE_IDS: usize = 64;

/// Known values by result id, in pages: few of the ids below the bound are in use, and few of their values are known.
#[derive(Debug, Clone)]
pub(super) struct Values(Vec<Option<Box<[Option<u32>; PAGE_IDS]>>>);

impl Values {
    /// Values of a module's constants, whose ids are below `bound`; `specialized` gives the bits of the specialization constants that are
    /// set.
    pub fn of_globals(globals: &[Instruction], bound: Word, specialized: impl Fn(Word) -> Option<u32>) -> Self {
        let mut values = Self(vec![None; (bound as usize).div_ceil(PAGE_IDS)]);
        for instruction in globals {
            let chosen = || specialized(code::result(instruction)?);
            let value = match Op::from_u32(code::operation(instruction)) {
                Some(Op::ConstantTrue) => Some(1),
                Some(Op::ConstantFalse) => Some(0),
                Some(Op::SpecConstantTrue) => chosen().or(Some(1)),
                Some(Op::SpecConstantFalse) => chosen().or(Some(0)),
                // A number of 64 bits has two words, and is not known.
                Some(Op::Constant) if instruction.len() == OPERANDS + 1 => Some(instruction[OPERANDS]),
                Some(Op::SpecConstant) if instruction.len() == OPERANDS + 1 => chosen().or(Some(instruction[OPERANDS])),
                Some(Op::SpecConstantOp) => instruction
                    .get(OPERANDS)
                    .and_then(|&operation| values.result(Op::from_u32(operation)?, &instruction[OPERANDS + 1..])),
                _ => None,
            };
            values.insert(instruction, value);
        }
        values
    }

    pub fn get(&self, id: Word) -> Option<u32> {
        self.0.get(id as usize / PAGE_IDS)?.as_ref()?[id as usize % PAGE_IDS]
    }

    /// Notes the result of a function's instruction, where it is known.
    pub fn learn(&mut self, instruction: &[Word]) {
        let Some(operation) = Op::from_u32(code::operation(instruction)) else { return };
        let operands = instruction.get(OPERANDS..).unwrap_or_default();
        let value = match operation {
            Op::Phi => self.common_value(operands),
            operation => self.result(operation, operands),
        };
        if value.is_some() {
            self.insert(instruction, value);
        }
    }

    fn insert(&mut self, instruction: &[Word], value: Option<u32>) {
        let (Some(id), Some(value)) = (code::result(instruction), value) else { return };
        if let Some(page) = self.0.get_mut(id as usize / PAGE_IDS) {
            page.get_or_insert_with(|| Box::new([None; PAGE_IDS]))[id as usize % PAGE_IDS] = Some(value);
        }
    }

    /// Value that all entries of a phi share. An entry along a back edge is not known yet, so the result is then
    /// `None`.
    fn common_value(&self, operands: &[Word]) -> Option<u32> {
        let mut values = operands.iter().step_by(2).map(|&id| self.get(id));
        let first = values.next()??;
        values.all(|value| value == Some(first)).then_some(first)
    }

    fn result(&self, operation: Op, operands: &[Word]) -> Option<u32> {
        let known = |place: usize| self.get(*operands.get(place)?);
        let (a, b) = (known(0), known(1));
        // One operand may decide the result.
        match operation {
            Op::LogicalAnd | Op::BitwiseAnd if a == Some(0) || b == Some(0) => return Some(0),
            Op::LogicalOr if a == Some(1) || b == Some(1) => return Some(1),
            Op::Select => return known(if a? == 0 { 2 } else { 1 }),
            Op::CopyObject => return a,
            Op::LogicalNot => return Some(1 - a?),
            Op::Not => return Some(!a?),
            _ => {}
        }
        let (a, b) = (a?, b?);
        let (signed_a, signed_b) = (a.cast_signed(), b.cast_signed());
        Some(match operation {
            Op::LogicalAnd | Op::BitwiseAnd => a & b,
            Op::LogicalOr | Op::BitwiseOr => a | b,
            Op::BitwiseXor => a ^ b,
            Op::IEqual | Op::LogicalEqual => (a == b).into(),
            Op::INotEqual | Op::LogicalNotEqual => (a != b).into(),
            Op::UGreaterThan => (a > b).into(),
            Op::UGreaterThanEqual => (a >= b).into(),
            Op::ULessThan => (a < b).into(),
            Op::ULessThanEqual => (a <= b).into(),
            Op::SGreaterThan => (signed_a > signed_b).into(),
            Op::SGreaterThanEqual => (signed_a >= signed_b).into(),
            Op::SLessThan => (signed_a < signed_b).into(),
            Op::SLessThanEqual => (signed_a <= signed_b).into(),
            Op::IAdd => a.wrapping_add(b),
            Op::ISub => a.wrapping_sub(b),
            Op::IMul => a.wrapping_mul(b),
            // Larger shifts are undefined.
            Op::ShiftLeftLogical => a.checked_shl(b)?,
            Op::ShiftRightLogical => a.checked_shr(b)?,
            _ => return None,
        })
    }
}
