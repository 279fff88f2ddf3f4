//! Words of programs (`glsl/include/texture/program.glsl`). Each instruction is a word with its operation and the places of its
//! operands, then the constants among the operands, then the operation's numbers.

use std::collections::HashMap;

use crate::generated::constants::{
    OPERAND_CONSTANT, OPERAND_INCOMING, OPERAND_NORMAL, OPERAND_POSITION, OPERAND_SHADING_NORMAL, OPERAND_UV,
    PROGRAM_LENGTH_SHIFT, PROGRAM_OPERAND_BITS, PROGRAM_OPERAND_SHIFT, PROGRAM_OUTPUT_SHIFT,
};
use crate::math::perlin::PERMUTATION;
use crate::scene::program::operation::Parameter;
use crate::scene::program::{Instruction, Place};
use crate::scene::texture::{Pattern, Texture};

/// Addresses of programs, and what they use.
pub(super) struct Programs {
    /// Address of each texture's program; 0 for other textures.
    pub addresses: Vec<u32>,
    /// Bits `1 << OPERATION_*`.
    pub operations: u64,
}

impl Programs {
    /// Appends the words of all programs, and the table of noise if one needs it.
    pub fn append(textures: &[Texture], words: &mut Vec<u32>) -> Self {
        let mut programs = Self { addresses: Vec::with_capacity(textures.len()), operations: 0 };
        let all = || {
            textures.iter().filter_map(|texture| match &texture.pattern {
                Pattern::Program(program) => Some(program),
                _ => None,
            })
        };
        let table = words.len() as u32;
        if all().flat_map(|program| &program.instructions).any(|instruction| instruction.operation.needs_noise_table())
        {
            words.extend(PERMUTATION.as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes)));
        }
        let mut tables = HashMap::new();
        for program in all() {
            append_tables(&program.instructions, &mut tables, words);
        }
        for texture in textures {
            let Pattern::Program(program) = &texture.pattern else {
                programs.addresses.push(0);
                continue;
            };
            programs.addresses.push(words.len() as u32);
            for instruction in &program.instructions {
                programs.operations |= 1 << instruction.operation.row().code;
                append_instruction(instruction, table, &tables, words);
            }
        }
        programs
    }
}

/// Appends the tables that instructions look up, each once.
fn append_tables<'p>(instructions: &'p [Instruction], tables: &mut HashMap<&'p [u32], u32>, words: &mut Vec<u32>) {
    for instruction in instructions {
        let Some((_, table)) = split_table(instruction) else { continue };
        tables.entry(table).or_insert_with(|| {
            words.extend(table);
            (words.len() - table.len()) as u32
        });
    }
}

/// Numbers of an instruction before its table, and the table; `None` where it has no table.
fn split_table(instruction: &Instruction) -> Option<(&[u32], &[u32])> {
    let parameters = instruction.operation.row().parameters;
    let (Parameter::Table(_), before) = parameters.split_last()? else { return None };
    instruction.numbers.split_at_checked(before.len())
}

/// Appends an instruction. `noise` is the address of the permutation, `tables` has those of tables.
fn append_instruction(instruction: &Instruction, noise: u32, tables: &HashMap<&[u32], u32>, words: &mut Vec<u32>) {
    let Instruction { operation, operands, numbers, output } = instruction;
    let first = words.len();
    let mut head = operation.row().code | u32::from(*output) << PROGRAM_OUTPUT_SHIFT;
    words.push(head);
    for (at, operand) in operands.iter().enumerate() {
        let place = match operand {
            Place::Register(register) => u32::from(*register),
            Place::Constant(value) => {
                words.extend(value.to_array().map(f32::to_bits));
                OPERAND_CONSTANT
            }
            Place::Uv => OPERAND_UV,
            Place::Position => OPERAND_POSITION,
            Place::Normal => OPERAND_NORMAL,
            Place::ShadingNormal => OPERAND_SHADING_NORMAL,
            Place::Incoming => OPERAND_INCOMING,
        };
        head |= place << (PROGRAM_OPERAND_SHIFT + at as u32 * PROGRAM_OPERAND_BITS);
    }
    match split_table(instruction) {
        Some((before, table)) => {
            words.extend(before);
            words.extend([tables.get(table).copied().unwrap_or(0), table.len() as u32 / 3]);
        }
        None => words.extend(numbers),
    }
    if operation.needs_noise_table() {
        words.push(noise);
    }
    words[first] = head | ((words.len() - first - 1) as u32) << PROGRAM_LENGTH_SHIFT;
}
