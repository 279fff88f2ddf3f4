//! Variants of a module: specialization constants set and folded, and dead code removed.

use rspirv::binary::Assemble;
use rspirv::dr::Operand;
use rspirv::grammar::INSTRUCTION_TABLE;
use rspirv::spirv::Op;

use crate::spirv::module::Module;
use crate::spirv::tools::{self, ToolFault};

/// SPIR-V of the variant in which the specialization constants have the given (id, bits).
pub fn specialize(module: &Module, constants: &[(u32, u32)]) -> Result<Vec<u8>, ToolFault> {
    tools::fold_constants(&with_defaults(module, constants))
}

/// Words of the module, with the given values as defaults of its specialization constants.
fn with_defaults(module: &Module, constants: &[(u32, u32)]) -> Vec<u32> {
    let mut changed = module.parsed.clone();
    for instruction in &mut changed.types_global_values {
        let id = instruction.result_id.and_then(|id| module.spec_id(id));
        let Some(&(_, bits)) = constants.iter().find(|(constant, _)| Some(*constant) == id) else { continue };
        match instruction.class.opcode {
            Op::SpecConstant => instruction.operands = vec![Operand::LiteralBit32(bits)],
            Op::SpecConstantTrue | Op::SpecConstantFalse => {
                let opcode = if bits == 0 { Op::SpecConstantFalse } else { Op::SpecConstantTrue };
                instruction.class = INSTRUCTION_TABLE.get(opcode);
            }
            _ => {}
        }
    }
    changed.assemble()
}
