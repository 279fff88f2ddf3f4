//! Compressed wide hierarchy over boxes (Ylitie et al. 2017): a binary hierarchy is built, and its subtrees are widened
//! in parallel.

use std::collections::HashMap;

use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

use super::split::Boxes;

/// Most children of a wide node.
const WIDTH: usize = 8;
/// Most primitives of a leaf, limited by the encoding of nodes.
const LEAF_SIZE: usize = 3;
/// Most primitives of a subtree that one task widens, so that its data stays in a core's cache.
const SUBTREE_SIZE: usize = 1 << 14;
/// Levels of the binary tree whose nodes' primitives are counted. Subtrees below are small, unless the tree is very
/// uneven.
const COUNTED_LEVELS: u32 = 14;
/// Share of the nodes that are tried elsewhere in the tree (Meister and Bittner 2018, "Parallel Reinsertion").
const REINSERTED_SHARE: f32 = 0.02;

/// Meta bytes of children by number of primitives. The upper three bits hold the number, unary; the lower five hold the
/// first primitive. An inner child counts as one primitive and holds 24 plus its slot there.
const COUNTS: [u8; LEAF_SIZE + 1] = [0b000_00000, 0b001_00000, 0b011_00000, 0b111_00000];
const INNER: u8 = COUNTS[1] | 24;
const FIRST: u8 = 0b000_11111;

/// Wide nodes, the root first, and the primitives' indices in the order of the leaves.
pub(super) struct Wide {
    pub nodes: Vec<CwBvhNode>,
    pub order: Vec<u32>,
}

/// Builds the hierarchy over at least one box.
pub(super) fn build(boxes: Boxes) -> Wide {
    let binary = build_binary(boxes);
    if binary.primitive_indices.len() <= SUBTREE_SIZE {
        return widen(&binary);
    }
    let Top { mut wide, parts, .. } = Top::new(&binary);
    let widened: Vec<Wide> = parts.par_iter().map(|part| widen(&subtree(&binary, part.root))).collect();
    drop(binary);
    widened.into_iter().zip(parts).for_each(|(below, part)| wide.hang(below, part.place));
    wide
}

/// Builds the binary hierarchy by locally ordered clustering (Meister and Bittner 2018).
fn build_binary(Boxes { boxes, primitives }: Boxes) -> Bvh2 {
    let mut binary = PlocBuilder::new().build(PlocSearchDistance::VeryLow, &boxes, primitives, SortPrecision::U64, 2);
    drop(boxes);
    binary.uses_spatial_splits = true;
    ReinsertionOptimizer::default().run(&mut binary, REINSERTED_SHARE, None);
    binary
}

fn widen(binary: &Bvh2) -> Wide {
    let CwBvh { nodes, primitive_indices, .. } = bvh2_to_cwbvh(binary, LEAF_SIZE as u32, true, false);
    Wide { nodes, order: primitive_indices }
}

impl Wide {
    /// Attaches a hierarchy, with its root at index `place`.
    fn hang(&mut self, part: Wide, place: usize) {
        let (first_node, first_primitive) = (self.nodes.len() as u32 - 1, self.order.len() as u32);
        let mut moved = part.nodes.iter().map(|node| CwBvhNode {
            child_base_idx: node.child_base_idx + first_node,
            primitive_base_idx: node.primitive_base_idx + first_primitive,
            ..*node
        });
        self.nodes[place] = moved.next().unwrap_or_default();
        self.nodes.extend(moved);
        self.order.extend(part.order);
    }
}

/// Uppermost wide nodes, and the subtrees that will hang below them.
struct Top<'a> {
    binary: &'a Bvh2,
    counts: HashMap<u32, usize>,
    wide: Wide,
    parts: Vec<Part>,
}

/// Subtree of the binary tree, and the index at which its wide root belongs.
struct Part {
    root: u32,
    place: usize,
}

impl<'a> Top<'a> {
    fn new(binary: &'a Bvh2) -> Self {
        let wide = Wide { nodes: vec![CwBvhNode::default()], order: Vec::new() };
        let mut top = Self { binary, counts: primitive_counts(binary), wide, parts: Vec::new() };
        top.add(0, 0);
        top
    }

    /// Makes the binary node `root` the wide node at `place`, or leaves it to be widened later if it is small.
    fn add(&mut self, root: u32, place: usize) {
        if self.counts.get(&root).is_none_or(|&count| count <= SUBTREE_SIZE) {
            self.parts.push(Part { root, place });
            return;
        }
        let (mut node, slots) = encode(self.binary, root, &self.open(root));
        let mut inner = Vec::new();
        node.child_base_idx = self.wide.nodes.len() as u32;
        node.primitive_base_idx = self.wide.order.len() as u32;
        for (slot, child) in slots {
            node.child_meta[slot] = if let Some(primitives) = leaf_primitives(self.binary, child) {
                let first = self.wide.order.len() as u32 - node.primitive_base_idx;
                self.wide.order.extend(&primitives);
                COUNTS[primitives.len()] | first as u8
            } else {
                inner.push((child, self.wide.nodes.len()));
                self.wide.nodes.push(CwBvhNode::default());
                node.imask |= 1 << slot;
                INNER + slot as u8
            };
        }
        self.wide.nodes[place] = node;
        inner.into_iter().for_each(|(child, place)| self.add(child, place));
    }

    /// Descendants of a node that become its children. The largest is opened first (Wald et al. 2008, "Getting Rid of
    /// Packets"), unless it fits into a leaf.
    fn open(&self, root: u32) -> Vec<u32> {
        let mut open = vec![root];
        while open.len() < WIDTH
            && let Some(largest) = self.largest_inner(&open)
        {
            let index = open.swap_remove(largest);
            open.extend(children(self.binary, index).into_iter().flatten());
        }
        open
    }

    fn largest_inner(&self, open: &[u32]) -> Option<usize> {
        let area = |&at: &usize| self.binary.nodes[open[at] as usize].aabb().half_area();
        let inner = (0..open.len()).filter(|&at| leaf_primitives(self.binary, open[at]).is_none());
        inner.max_by(|a, b| area(a).total_cmp(&area(b)))
    }
}

/// Wide node of `root` alone, without inner children so far, and the member of `ends` in each slot.
fn encode(binary: &Bvh2, root: u32, ends: &[u32]) -> (CwBvhNode, Vec<(usize, u32)>) {
    let tree = copy(binary, root, |index| ends.contains(&index).then_some(index));
    // A second node would gain nothing for so few.
    let CwBvh { nodes, primitive_indices, .. } = bvh2_to_cwbvh(&tree, 1, true, false);
    let node = nodes[0];
    let slots = node.child_meta.iter().enumerate().filter(|(_, meta)| **meta != 0);
    let slots = slots.map(|(slot, meta)| (slot, primitive_indices[usize::from(meta & FIRST)])).collect();
    (node, slots)
}

fn subtree(binary: &Bvh2, root: u32) -> Bvh2 {
    copy(binary, root, |index| {
        let node = &binary.nodes[index as usize];
        node.is_leaf().then(|| binary.primitive_indices[node.first_index as usize])
    })
}

/// Copy of the tree from `root` down to the nodes that `primitive` makes leaves, in an order that suits caches.
fn copy(binary: &Bvh2, root: u32, primitive: impl Fn(u32) -> Option<u32>) -> Bvh2 {
    let mut copy = Bvh2 { nodes: vec![Bvh2Node::default()], ..Bvh2::default() };
    let mut pending = vec![(root, 0)];
    while let Some((from, to)) = pending.pop() {
        let node = &binary.nodes[from as usize];
        copy.nodes[to] = if let Some(primitive) = primitive(from) {
            copy.primitive_indices.push(primitive);
            Bvh2Node::new(*node.aabb(), 1, copy.primitive_indices.len() as u32 - 1)
        } else {
            let first = copy.nodes.len();
            copy.nodes.extend([Bvh2Node::default(); 2]);
            pending.extend([(node.first_index + 1, first + 1), (node.first_index, first)]);
            Bvh2Node::new(*node.aabb(), 0, first as u32)
        };
    }
    copy
}

/// Number of primitives below each of the uppermost nodes.
fn primitive_counts(binary: &Bvh2) -> HashMap<u32, usize> {
    let mut counts = HashMap::new();
    let (mut level, mut parents) = (vec![0], Vec::new());
    for _ in 0..COUNTED_LEVELS {
        let (leaves, inner): (Vec<u32>, Vec<u32>) = level.into_iter().partition(|&i| children(binary, i).is_none());
        counts.extend(leaves.into_iter().map(|leaf| (leaf, 1)));
        level = inner.iter().filter_map(|&index| children(binary, index)).flatten().collect();
        parents.extend(inner);
    }
    counts.par_extend(level.into_par_iter().map(|root| (root, primitive_count(binary, root))));
    for parent in parents.into_iter().rev() {
        let count = children(binary, parent).into_iter().flatten().map(|child| counts[&child]).sum();
        counts.insert(parent, count);
    }
    counts
}

fn primitive_count(binary: &Bvh2, root: u32) -> usize {
    let (mut count, mut pending) = (0, vec![root]);
    while let Some(index) = pending.pop() {
        match children(binary, index) {
            Some(children) => pending.extend(children),
            None => count += 1,
        }
    }
    count
}

/// Primitives below `root` if they fit into one leaf, else `None`.
fn leaf_primitives(binary: &Bvh2, root: u32) -> Option<Vec<u32>> {
    let (mut found, mut pending) = (Vec::new(), vec![root]);
    while let Some(index) = pending.pop() {
        match children(binary, index) {
            Some(children) => pending.extend(children),
            None => found.push(binary.primitive_indices[binary.nodes[index as usize].first_index as usize]),
        }
        if found.len() + pending.len() > LEAF_SIZE {
            return None;
        }
    }
    Some(found)
}

fn children(binary: &Bvh2, index: u32) -> Option<[u32; 2]> {
    let node = &binary.nodes[index as usize];
    (!node.is_leaf()).then_some([node.first_index, node.first_index + 1])
}
