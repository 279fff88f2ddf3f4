//! A parsed SPIR-V module.

use std::collections::HashMap;

use rspirv::binary::Disassemble;
use rspirv::dr::{self, Instruction, Operand};
use rspirv::spirv::{Decoration, Op, StorageClass};

/// First word of every module.
const MAGIC: u32 = 0x0723_0203;

/// A module, as words and as instructions.
pub struct Module {
    words: Vec<u32>,
    pub(super) parsed: dr::Module,
    /// Every instruction outside functions that has a result, by that.
    globals: HashMap<u32, Instruction>,
}

impl Module {
    /// From little-endian words. The error says why they are no SPIR-V.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let words: Vec<u32> = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        if !bytes.len().is_multiple_of(4) || words.first() != Some(&MAGIC) {
            return Err("it is not SPIR-V: it does not consist of words that begin with 0x07230203; assemble it with \
                        spirv-as"
                .into());
        }
        let parsed = dr::load_words(&words).map_err(|error| format!("it is not valid SPIR-V: {error}"))?;
        let globals = parsed.types_global_values.iter().chain(&parsed.ext_inst_imports);
        let globals = globals.filter_map(|i| Some((i.result_id?, i.clone()))).collect();
        Ok(Self { words, parsed, globals })
    }

    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// With numbers for names.
    pub fn disassemble(&self) -> String {
        self.parsed.disassemble()
    }

    /// The type, constant or variable of that number.
    pub fn global(&self, id: u32) -> Option<&Instruction> {
        self.globals.get(&id)
    }

    /// The name of that number in the GLSL.
    pub fn name(&self, id: u32) -> Option<&str> {
        let named = |i: &&Instruction| i.class.opcode == Op::Name && operand_id(i, 0) == Some(id);
        let name = self.parsed.debug_names.iter().find(named)?;
        match name.operands.get(1) {
            Some(Operand::LiteralString(name)) if !name.is_empty() => Some(name),
            _ => None,
        }
    }

    /// (number, operand) of everything that has such a decoration.
    pub fn decorated(&self, decoration: Decoration) -> impl Iterator<Item = (u32, Option<&Operand>)> {
        self.parsed.annotations.iter().filter_map(move |i| {
            let is_it = i.class.opcode == Op::Decorate && i.operands.get(1) == Some(&Operand::Decoration(decoration));
            if is_it { Some((operand_id(i, 0)?, i.operands.get(2))) } else { None }
        })
    }

    /// The number's specialization constant id, if it is one.
    pub fn spec_id(&self, id: u32) -> Option<u32> {
        let mut all = self.decorated(Decoration::SpecId);
        all.find(|&(target, _)| target == id).and_then(|(_, operand)| literal(operand?))
    }

    /// Scalars in a value of that type; an array whose length a constant chooses counts by its default length.
    pub fn scalars(&self, ty: u32) -> u64 {
        let Some(instruction) = self.global(ty) else { return 0 };
        let operand = |place| operand_id(instruction, place);
        let element = || operand(0).map_or(0, |element| self.scalars(element));
        match instruction.class.opcode {
            Op::TypeBool | Op::TypeInt | Op::TypeFloat => 1,
            Op::TypeVector | Op::TypeMatrix => {
                element() * instruction.operands.get(1).and_then(literal).map_or(0, u64::from)
            }
            Op::TypeArray => {
                let length = operand(1).and_then(|length| literal(self.global(length)?.operands.first()?));
                element() * length.map_or(1, u64::from)
            }
            Op::TypeStruct => {
                (0..instruction.operands.len()).filter_map(operand).map(|member| self.scalars(member)).sum()
            }
            _ => 0,
        }
    }

    /// Where a pointer of that type points.
    pub fn storage_class(&self, pointer_type: u32) -> Option<StorageClass> {
        let instruction = self.global(pointer_type).filter(|i| i.class.opcode == Op::TypePointer)?;
        match instruction.operands.first() {
            Some(&Operand::StorageClass(class)) => Some(class),
            _ => None,
        }
    }
}

/// The number that an operand refers to.
pub fn operand_id(instruction: &Instruction, place: usize) -> Option<u32> {
    instruction.operands.get(place).and_then(Operand::id_ref_any)
}

/// The bits of a literal.
pub fn literal(operand: &Operand) -> Option<u32> {
    match *operand {
        Operand::LiteralBit32(bits) => Some(bits),
        _ => None,
    }
}
