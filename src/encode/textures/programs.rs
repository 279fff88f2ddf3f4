//! Words of programs (`glsl/include/texture/program.glsl`). Each instruction is a word with its operation and the places of its
//! operands, then the constants among the operands, then the operation's numbers.

use std::collections::HashMap;

use crate::generated::constants::{
    OPERAND_CONSTANT, OPERAND_INCOMING, OPERAND_NORMAL, OPERAND_POSITION, OPERAND_SHADING_NORMAL, OPERAND_UV,
    PROGRAM_LENGTH_SHIFT, PROGRAM_OPERAND_BITS, PROGRAM_OPERAND_SHIFT, PROGRAM_OUTPUT_SHIFT,
};
use crate::scene::program::operation::Parameter;
use crate::scene::program::{Instruction, Place};
use crate::scene::texture::{Pattern, Texture};

/// Ken Perlin's permutation of 2002.
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69, 142, 8, 99, 37, 240,
    21, 10, 23, 190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32, 57, 177, 33, 88,
    237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175, 74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83,
    111, 229, 122, 60, 211, 133, 230, 220, 105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54, 65, 25, 63, 161, 1, 216,
    80, 73, 209, 76, 132, 187, 208, 89, 18, 169, 200, 196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173, 186,
    3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147, 118, 126, 255, 82, 85, 212, 207, 206, 59, 227, 47, 16, 58, 17,
    182, 189, 28, 42, 223, 183, 170, 213, 119, 248, 152, 2, 44, 154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9, 129,
    22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232, 178, 185, 112, 104, 218, 246, 97, 228, 251, 34, 242, 193, 238,
    210, 144, 12, 191, 179, 162, 241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157, 184,
    84, 204, 176, 115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141, 128, 195,
    78, 66, 215, 61, 156, 180,
];

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
