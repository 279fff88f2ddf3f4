//! A module as words: its instructions stay slices of the kernel's words, because a kernel of many features has 10^5 of them, of which
//! few are altered.

use std::borrow::Cow;
use std::sync::LazyLock;

use rspirv::grammar::{INSTRUCTION_TABLE, OperandKind};
use rspirv::spirv::{MAGIC_NUMBER, Op, Word};

/// Words of a module's header. The fourth is the bound of ids.
const HEADER_WORDS: usize = 5;
pub(super) const BOUND: usize = 3;
/// Largest bound that SPIR-V allows (SPIR-V specification, 2.17).
const MAX_BOUND: Word = 4_194_303;

/// Instruction: its first word has its length and its operation, then come its operands.
pub(super) type Instruction<'a> = Cow<'a, [Word]>;

/// Block of a function, without its label's instruction.
pub(super) struct Block<'a> {
    pub label: Word,
    pub instructions: Vec<Instruction<'a>>,
}

pub(super) struct Function<'a> {
    /// Instructions before the first block.
    pub head: Vec<Instruction<'a>>,
    pub blocks: Vec<Block<'a>>,
}

pub(super) struct Module<'a> {
    header: [Word; HEADER_WORDS],
    /// Instructions before the first function.
    pub globals: Vec<Instruction<'a>>,
    pub functions: Vec<Function<'a>>,
}

impl<'a> Module<'a> {
    /// Splits words into instructions; `None` where they are no module with a function.
    pub fn parse(words: &'a [Word]) -> Option<Self> {
        let (header, mut rest) = words.split_first_chunk::<HEADER_WORDS>()?;
        if header[0] != MAGIC_NUMBER || header[BOUND] > MAX_BOUND {
            return None;
        }
        let mut module = Self { header: *header, globals: Vec::new(), functions: Vec::new() };
        // Whether the end of a function has not come yet.
        let mut is_inside = false;
        while let Some(&first) = rest.first() {
            let (code, after) = rest.split_at_checked(length(first)).filter(|(code, _)| !code.is_empty())?;
            rest = after;
            let operation = first & 0xffff;
            if operation == Op::Function as u32 {
                module.functions.push(Function { head: Vec::new(), blocks: Vec::new() });
                is_inside = true;
            }
            match module.functions.last_mut() {
                None => module.globals.push(Cow::Borrowed(code)),
                Some(_) if operation == Op::FunctionEnd as u32 => is_inside = false,
                Some(_) if !is_inside => return None,
                Some(function) if operation == Op::Label as u32 => {
                    function.blocks.push(Block { label: *code.get(1)?, instructions: Vec::new() });
                }
                Some(function) => match function.blocks.last_mut() {
                    None => function.head.push(Cow::Borrowed(code)),
                    // Lines between blocks say nothing of an instruction.
                    Some(block) if block.is_complete() => {}
                    Some(block) => block.instructions.push(Cow::Borrowed(code)),
                },
            }
        }
        (!is_inside && !module.functions.is_empty()).then_some(module)
    }

    /// Smallest number that is above all ids.
    pub fn bound(&mut self) -> &mut Word {
        &mut self.header[BOUND]
    }

    /// For each id whether the module defines it.
    pub fn defined(&self) -> Vec<bool> {
        let mut defined = vec![false; self.header[BOUND] as usize];
        let mut add = |id: Option<Word>| {
            if let Some(defined) = id.and_then(|id| defined.get_mut(id as usize)) {
                *defined = true;
            }
        };
        self.globals.iter().for_each(|code| add(result(code)));
        for function in &self.functions {
            function.head.iter().for_each(|code| add(result(code)));
            for block in &function.blocks {
                add(Some(block.label));
                block.instructions.iter().for_each(|code| add(result(code)));
            }
        }
        defined
    }

    pub fn assemble(&self) -> Vec<Word> {
        let mut words = self.header.to_vec();
        for code in &self.globals {
            words.extend_from_slice(code);
        }
        for function in &self.functions {
            for code in &function.head {
                words.extend_from_slice(code);
            }
            for block in &function.blocks {
                words.extend_from_slice(&instruction(Op::Label, &[block.label]));
                for code in &block.instructions {
                    words.extend_from_slice(code);
                }
            }
            words.extend_from_slice(&instruction(Op::FunctionEnd, &[]));
        }
        words
    }
}

impl Block<'_> {
    /// Whether the block has the instruction that ends it.
    fn is_complete(&self) -> bool {
        const ENDS: [Op; 6] = [Op::Branch, Op::BranchConditional, Op::Switch, Op::Return, Op::Unreachable, Op::Kill];
        self.instructions.last().is_some_and(|last| {
            is(last, Op::ReturnValue) || is(last, Op::TerminateInvocation) || ENDS.iter().any(|&end| is(last, end))
        })
    }
}

/// Number of words of an instruction, of which its first word is given.
fn length(first: Word) -> usize {
    (first >> 16) as usize
}

pub(super) fn operation(code: &[Word]) -> Word {
    code.first().map_or(0, |first| first & 0xffff)
}

pub(super) fn is(code: &[Word], expected: Op) -> bool {
    operation(code) == expected as u32
}

/// Instruction with these operands, the type and the id of its result included.
pub(super) fn instruction<'a>(operation: Op, operands: &[Word]) -> Instruction<'a> {
    let mut code = Vec::with_capacity(1 + operands.len());
    code.push((1 + operands.len() as u32) << 16 | operation as u32);
    code.extend_from_slice(operands);
    Cow::Owned(code)
}

/// Id of an instruction's result.
pub(super) fn result(code: &[Word]) -> Option<Word> {
    /// Place of the result's id by operation; 0 where an operation has no result.
    static PLACES: LazyLock<Vec<u8>> = LazyLock::new(|| {
        let mut places = Vec::new();
        for known in INSTRUCTION_TABLE.iter() {
            let place = known.operands.iter().position(|operand| operand.kind == OperandKind::IdResult);
            let operation = known.opcode as usize;
            if places.len() <= operation {
                places.resize(operation + 1, 0);
            }
            places[operation] = place.map_or(0, |place| place as u8 + 1);
        }
        places
    });
    match PLACES.get(operation(code) as usize) {
        None | Some(0) => None,
        Some(&place) => code.get(usize::from(place)).copied(),
    }
}
