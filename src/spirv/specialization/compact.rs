//! Numbers of ids without gaps. Drivers keep a table with a place for every number below the bound, and optimizers leave millions of
//! numbers unused.

use std::collections::HashMap;

use rspirv::binary::{Assemble, Consumer, ParseAction, parse_words};
use rspirv::dr;
use rspirv::spirv::Word;

use super::code::BOUND;

/// Module whose ids are numbered in the order in which they occur, from 1 on; `None` where the module has an instruction that is not
/// known.
pub fn compact(words: &[Word]) -> Option<Vec<Word>> {
    let mut compacted = Compacted::default();
    parse_words(words, &mut compacted).ok()?;
    *compacted.words.get_mut(BOUND)? = compacted.numbers.len() as Word + 1;
    Some(compacted.words)
}

#[derive(Default)]
struct Compacted {
    words: Vec<Word>,
    /// New numbers by old ones.
    numbers: HashMap<Word, Word>,
}

impl Compacted {
    fn renumber(&mut self, id: &mut Word) {
        let next = self.numbers.len() as Word + 1;
        *id = *self.numbers.entry(*id).or_insert(next);
    }
}

impl Consumer for Compacted {
    fn initialize(&mut self) -> ParseAction {
        ParseAction::Continue
    }

    fn finalize(&mut self) -> ParseAction {
        ParseAction::Continue
    }

    fn consume_header(&mut self, header: dr::ModuleHeader) -> ParseAction {
        header.assemble_into(&mut self.words);
        ParseAction::Continue
    }

    fn consume_instruction(&mut self, mut instruction: dr::Instruction) -> ParseAction {
        let operands = instruction.operands.iter_mut().filter_map(dr::Operand::id_ref_any_mut);
        instruction
            .result_type
            .iter_mut()
            .chain(&mut instruction.result_id)
            .chain(operands)
            .for_each(|id| self.renumber(id));
        instruction.assemble_into(&mut self.words);
        ParseAction::Continue
    }
}
