//! Blocks of a function: decides branches and removes unreachable blocks. The result keeps SPIR-V's structured control
//! flow (SPIR-V specification 2.11).

use std::collections::{HashMap, HashSet};

use rspirv::dr::{Block, Function, Instruction, Operand};
use rspirv::grammar::INSTRUCTION_TABLE;
use rspirv::spirv::{Op, Word};

use super::values::Values;

/// Replaces each branch whose condition is known by a jump to its target. Returns whether there were any.
pub(super) fn decide(function: &mut Function, globals: &Values) -> bool {
    let mut values = globals.clone();
    let mut is_changed = false;
    // A definition comes before its uses, except along back edges.
    for block in &mut function.blocks {
        block.instructions.iter().for_each(|instruction| values.learn(instruction));
        is_changed |= decide_block(block, &values);
    }
    is_changed
}

fn decide_block(block: &mut Block, values: &Values) -> bool {
    let Some(last) = block.instructions.last() else { return false };
    let condition = || last.operands.first().and_then(Operand::id_ref_any).and_then(|id| values.get(id));
    match last.class.opcode {
        Op::BranchConditional => {
            let Some(condition) = condition() else { return false };
            let target = last.operands[if condition == 0 { 2 } else { 1 }].clone();
            block.instructions.pop();
            // A loop keeps its merge instruction.
            if block.instructions.last().is_some_and(|i| i.class.opcode == Op::SelectionMerge) {
                block.instructions.pop();
            }
            block.instructions.push(instruction(Op::Branch, None, None, vec![target]));
            true
        }
        // Blocks inside may break out of a switch, so it stays a switch, of a single case.
        Op::Switch if last.operands.len() > 2 => {
            let Some(selector) = condition() else { return false };
            let is_chosen = |case: &&[Operand]| case[0] == Operand::LiteralBit32(selector);
            let target = last.operands[2..].chunks(2).find(is_chosen).map_or(&last.operands[1], |case| &case[1]);
            let operands = vec![last.operands[0].clone(), target.clone()];
            block.instructions.pop();
            block.instructions.push(instruction(Op::Switch, None, None, operands));
            true
        }
        _ => false,
    }
}

/// Removes unreachable blocks and their entries in phis. Returns definitions of undefined values that are now needed;
/// their ids start at `bound`, which grows.
pub(super) fn remove_unreachable(function: &mut Function, bound: &mut Word) -> Vec<Instruction> {
    let reached = reached(function);
    // A construct needs a merge block and a continue target even where they are unreachable.
    let mut merges = HashSet::new();
    let mut headers = HashMap::new();
    for block in function.blocks.iter().filter(|block| reached.contains(&label(block))) {
        for i in &block.instructions {
            match i.class.opcode {
                Op::SelectionMerge => _ = merges.insert(id(i, 0)),
                Op::LoopMerge => {
                    merges.insert(id(i, 0));
                    headers.insert(id(i, 1), label(block));
                }
                _ => {}
            }
        }
    }
    function.blocks.retain_mut(|block| {
        let label = label(block);
        if reached.contains(&label) {
            return true;
        }
        let stub = match headers.get(&label) {
            Some(&header) => instruction(Op::Branch, None, None, vec![Operand::IdRef(header)]),
            None => instruction(Op::Unreachable, None, None, Vec::new()),
        };
        block.instructions = vec![stub];
        headers.contains_key(&label) || merges.contains(&label)
    });
    mend_phis(function, &reached, bound)
}

/// Gives every phi one value for each block that leads to it.
fn mend_phis(function: &mut Function, reached: &HashSet<Word>, bound: &mut Word) -> Vec<Instruction> {
    let mut predecessors: HashMap<Word, Vec<Word>> = HashMap::new();
    for block in &function.blocks {
        for target in targets(block) {
            predecessors.entry(target).or_default().push(label(block));
        }
    }
    let mut undefined = Vec::new();
    for block in &mut function.blocks {
        let from = predecessors.get(&label(block)).map(Vec::as_slice).unwrap_or_default();
        for phi in block.instructions.iter_mut().filter(|i| i.class.opcode == Op::Phi) {
            let is_kept = |pair: &&[Operand]| {
                pair[1].id_ref_any().is_some_and(|block| from.contains(&block) && reached.contains(&block))
            };
            let mut kept: Vec<Operand> = phi.operands.chunks(2).filter(is_kept).flatten().cloned().collect();
            // An unreachable continue target jumps to the loop's head, so the phi needs a value for it.
            for stub in from.iter().filter(|block| !reached.contains(block)) {
                undefined.push(instruction(Op::Undef, phi.result_type, Some(*bound), Vec::new()));
                kept.extend([Operand::IdRef(*bound), Operand::IdRef(*stub)]);
                *bound += 1;
            }
            phi.operands = kept;
        }
    }
    undefined
}

fn reached(function: &Function) -> HashSet<Word> {
    let by_label: HashMap<Word, &Block> = function.blocks.iter().map(|block| (label(block), block)).collect();
    let mut reached = HashSet::new();
    let mut open: Vec<Word> = function.blocks.first().map(label).into_iter().collect();
    while let Some(next) = open.pop() {
        if reached.insert(next)
            && let Some(block) = by_label.get(&next)
        {
            open.extend(targets(block));
        }
    }
    reached
}

/// Blocks to which a block may jump, each once.
fn targets(block: &Block) -> Vec<Word> {
    let Some(last) = block.instructions.last() else { return Vec::new() };
    let all = last.operands.iter().filter_map(Operand::id_ref_any);
    let mut targets: Vec<Word> = match last.class.opcode {
        Op::Branch => all.collect(),
        // The condition comes first.
        Op::BranchConditional | Op::Switch => all.skip(1).collect(),
        _ => Vec::new(),
    };
    targets.sort_unstable();
    targets.dedup();
    targets
}

fn label(block: &Block) -> Word {
    block.label.as_ref().and_then(|label| label.result_id).unwrap_or_default()
}

fn id(instruction: &Instruction, place: usize) -> Word {
    instruction.operands.get(place).and_then(Operand::id_ref_any).unwrap_or_default()
}

fn instruction(opcode: Op, ty: Option<Word>, result: Option<Word>, operands: Vec<Operand>) -> Instruction {
    Instruction { class: INSTRUCTION_TABLE.get(opcode), result_type: ty, result_id: result, operands }
}
