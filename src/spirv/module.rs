//! A parsed SPIR-V module.

use std::collections::HashMap;

use rspirv::binary::Disassemble;
use rspirv::dr::{self, Instruction, Operand};
use rspirv::spirv::{Decoration, Op, StorageClass};

/// First word of every SPIR-V module.
const MAGIC: u32 = 0x0723_0203;

/// SPIR-V module, as words and as instructions.
pub struct Module {
    words: Vec<u32>,
    pub(super) parsed: dr::Module,
    /// Instructions outside functions, by result id.
    globals: HashMap<u32, Instruction>,
}

impl Module {
    /// Parses little-endian words. The error says why they are no SPIR-V.
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

    /// Disassembly with numbers for names.
    pub fn disassemble(&self) -> String {
        self.parsed.disassemble()
    }

    /// Type, constant or variable with the given id.
    pub fn global(&self, id: u32) -> Option<&Instruction> {
        self.globals.get(&id)
    }

    /// Name in the GLSL of the given id.
    pub fn name(&self, id: u32) -> Option<&str> {
        let named = |i: &&Instruction| i.class.opcode == Op::Name && operand_id(i, 0) == Some(id);
        let name = self.parsed.debug_names.iter().find(named)?;
        match name.operands.get(1) {
            Some(Operand::LiteralString(name)) if !name.is_empty() => Some(name),
            _ => None,
        }
    }

    /// Ids with the given decoration, and the decoration's operand.
    pub fn decorated(&self, decoration: Decoration) -> impl Iterator<Item = (u32, Option<&Operand>)> {
        self.parsed.annotations.iter().filter_map(move |i| {
            let is_it = i.class.opcode == Op::Decorate && i.operands.get(1) == Some(&Operand::Decoration(decoration));
            if is_it { Some((operand_id(i, 0)?, i.operands.get(2))) } else { None }
        })
    }

    /// Specialization constant id of the given result id; `None` where it is no specialization constant.
    pub fn spec_id(&self, id: u32) -> Option<u32> {
        let mut all = self.decorated(Decoration::SpecId);
        all.find(|&(target, _)| target == id).and_then(|(_, operand)| literal(operand?))
    }

    /// Number of scalars in a value of the given type. An array whose length is a specialization constant counts by its
    /// default length.
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

    /// Storage class of a pointer type.
    pub fn storage_class(&self, pointer_type: u32) -> Option<StorageClass> {
        let instruction = self.global(pointer_type).filter(|i| i.class.opcode == Op::TypePointer)?;
        match instruction.operands.first() {
            Some(&Operand::StorageClass(class)) => Some(class),
            _ => None,
        }
    }
}

/// Id that an operand refers to.
pub fn operand_id(instruction: &Instruction, place: usize) -> Option<u32> {
    instruction.operands.get(place).and_then(Operand::id_ref_any)
}

/// Bits of a literal of 32 bits.
pub fn literal(operand: &Operand) -> Option<u32> {
    match *operand {
        Operand::LiteralBit32(bits) => Some(bits),
        _ => None,
    }
}
