//! Scalars that are known before a kernel runs: 32-bit integers, and booleans as 0 and 1.

use std::collections::HashMap;

use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::Op;

/// Known values by result id.
#[derive(Debug, Clone, Default)]
pub(super) struct Values(HashMap<u32, u32>);

impl Values {
    /// Values of a module's constants; `specialized` gives the bits of the specialization constants that are set.
    pub fn of_globals(module: &Module, specialized: impl Fn(u32) -> Option<u32>) -> Self {
        let mut values = Self::default();
        for instruction in &module.types_global_values {
            let chosen = || instruction.result_id.and_then(&specialized);
            let value = match (instruction.class.opcode, instruction.operands.first()) {
                (Op::ConstantTrue, _) => Some(1),
                (Op::ConstantFalse, _) => Some(0),
                (Op::SpecConstantTrue, _) => chosen().or(Some(1)),
                (Op::SpecConstantFalse, _) => chosen().or(Some(0)),
                (Op::Constant, Some(&Operand::LiteralBit32(bits))) => Some(bits),
                (Op::SpecConstant, Some(&Operand::LiteralBit32(bits))) => chosen().or(Some(bits)),
                (Op::SpecConstantOp, Some(&Operand::LiteralSpecConstantOpInteger(operation))) => {
                    values.result(operation, &instruction.operands[1..])
                }
                _ => None,
            };
            values.insert(instruction, value);
        }
        values
    }

    pub fn get(&self, id: u32) -> Option<u32> {
        self.0.get(&id).copied()
    }

    /// Notes the result of a function's instruction, where it is known.
    pub fn learn(&mut self, instruction: &Instruction) {
        let value = match instruction.class.opcode {
            Op::Phi => self.common_value(&instruction.operands),
            operation => self.result(operation, &instruction.operands),
        };
        self.insert(instruction, value);
    }

    fn insert(&mut self, instruction: &Instruction, value: Option<u32>) {
        if let (Some(id), Some(value)) = (instruction.result_id, value) {
            self.0.insert(id, value);
        }
    }

    /// Value that all entries of a phi share. An entry along a back edge is not known yet, so the result is then
    /// `None`.
    fn common_value(&self, operands: &[Operand]) -> Option<u32> {
        let mut values = operands.iter().step_by(2).map(|operand| self.get(operand.id_ref_any()?));
        let first = values.next()??;
        values.all(|value| value == Some(first)).then_some(first)
    }

    fn result(&self, operation: Op, operands: &[Operand]) -> Option<u32> {
        let known = |place: usize| self.get(operands.get(place)?.id_ref_any()?);
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
