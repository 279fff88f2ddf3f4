//! Blocks of a function: decides branches and removes unreachable blocks. The result keeps SPIR-V's structured control
//! flow (SPIR-V specification 2.11).

use std::collections::{HashMap, HashSet};

use rspirv::spirv::{Op, Word};

use super::code::{Block, Function, Instruction, instruction, is};
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
    if is(last, Op::BranchConditional) && last.len() >= 4 {
        let Some(condition) = values.get(last[1]) else { return false };
        let target = last[if condition == 0 { 3 } else { 2 }];
        block.instructions.pop();
        // A loop keeps its merge instruction.
        if block.instructions.last().is_some_and(|i| is(i, Op::SelectionMerge)) {
            block.instructions.pop();
        }
        block.instructions.push(instruction(Op::Branch, &[target]));
        return true;
    }
    // Blocks inside may break out of a switch, so it stays a switch, of a single case.
    if is(last, Op::Switch) && last.len() > 3 {
        let Some(selector) = values.get(last[1]) else { return false };
        let target = last[3..].chunks_exact(2).find(|case| case[0] == selector).map_or(last[2], |case| case[1]);
        let decided = instruction(Op::Switch, &[last[1], target]);
        block.instructions.pop();
        block.instructions.push(decided);
        return true;
    }
    false
}

/// Removes unreachable blocks and their entries in phis. Returns definitions of undefined values that are now needed;
/// their ids start at `bound`, which grows.
pub(super) fn remove_unreachable<'a>(function: &mut Function<'a>, bound: &mut Word) -> Vec<Instruction<'a>> {
    let reached = reached(function);
    // A construct needs a merge block and a continue target even where they are unreachable.
    let mut merges = HashSet::new();
    let mut headers = HashMap::new();
    for block in function.blocks.iter().filter(|block| reached.contains(&block.label)) {
        for i in &block.instructions {
            if is(i, Op::SelectionMerge) && i.len() > 1 {
                merges.insert(i[1]);
            } else if is(i, Op::LoopMerge) && i.len() > 2 {
                merges.insert(i[1]);
                headers.insert(i[2], block.label);
            }
        }
    }
    function.blocks.retain_mut(|block| {
        if reached.contains(&block.label) {
            return true;
        }
        let header = headers.get(&block.label);
        let stub = header.map_or_else(|| instruction(Op::Unreachable, &[]), |&head| instruction(Op::Branch, &[head]));
        block.instructions = vec![stub];
        header.is_some() || merges.contains(&block.label)
    });
    mend_phis(function, &reached, bound)
}

/// Gives every phi one value for each block that leads to it.
fn mend_phis<'a>(function: &mut Function<'a>, reached: &HashSet<Word>, bound: &mut Word) -> Vec<Instruction<'a>> {
    let mut predecessors: HashMap<Word, Vec<Word>> = HashMap::new();
    for block in &function.blocks {
        for target in targets(block) {
            predecessors.entry(target).or_default().push(block.label);
        }
    }
    let mut undefined = Vec::new();
    for block in &mut function.blocks {
        let from = predecessors.get(&block.label).map(Vec::as_slice).unwrap_or_default();
        for phi in block.instructions.iter_mut().filter(|i| is(i, Op::Phi) && i.len() > 2) {
            let is_kept = |pair: &&[Word]| from.contains(&pair[1]) && reached.contains(&pair[1]);
            let mut operands = phi[1..3].to_vec();
            operands.extend(phi[3..].chunks_exact(2).filter(is_kept).flatten());
            // An unreachable continue target jumps to the loop's head, so the phi needs a value for it.
            for stub in from.iter().filter(|block| !reached.contains(block)) {
                undefined.push(instruction(Op::Undef, &[phi[1], *bound]));
                operands.extend([*bound, *stub]);
                *bound += 1;
            }
            if operands.len() + 1 != phi.len() || operands[..] != phi[1..] {
                *phi = instruction(Op::Phi, &operands);
            }
        }
    }
    undefined
}

fn reached(function: &Function) -> HashSet<Word> {
    let by_label: HashMap<Word, &Block> = function.blocks.iter().map(|block| (block.label, block)).collect();
    let mut reached = HashSet::new();
    let mut open: Vec<Word> = function.blocks.first().map(|block| block.label).into_iter().collect();
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
    let operands = &last[1..];
    // The condition of a branch comes first, and weights may come last. Cases of a switch follow its default.
    let mut targets: Vec<Word> = if is(last, Op::Branch) {
        operands.to_vec()
    } else if is(last, Op::BranchConditional) {
        operands.iter().skip(1).take(2).copied().collect()
    } else if is(last, Op::Switch) {
        operands.iter().skip(1).step_by(2).copied().collect()
    } else {
        Vec::new()
    };
    targets.sort_unstable();
    targets.dedup();
    targets
}
