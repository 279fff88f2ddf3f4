//! Twin of the quadtrees in `glsl/include/guide/samplers/quadtree.glsl`, of their layout in `quadtree_nodes.glsl`, and
//! of their refinement in `glsl/kernels/learn/refine_quadtrees.comp`.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};
use lodestar::settings::DirectionMap;

use super::direction_map::sphere_to_map;

/// Maximum number of levels of nodes: `QUADTREE_LEVELS` in GLSL.
pub const LEVELS: u32 = 12;
/// Share of its tree's flux above which a square has a node: `FLUX_SHARE` in GLSL.
pub const FLUX_SHARE: f64 = 0.01;
/// Share of samples drawn by the cosine: `bsdf_share` in GLSL.
pub const COSINE_SHARE: f64 = 0.5;

/// Layout of links: `LEARNED_LINK`, `LEVEL_SHIFT` and `FIRST_LINK_SHIFT` in GLSL.
const LEARNED_LINK: u32 = 16;
const LEVEL_SHIFT: u32 = 5;
const FIRST_LINK_SHIFT: u32 = 9;

/// Square of the map of directions. A tree is the square of all directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Square {
    /// Flux that arrives through the square, in any unit.
    pub flux: f64,
    /// Quarters: lower left, lower right, upper left, upper right. `None` for a square without a node.
    pub quarters: Option<Box<[Square; 4]>>,
}

impl Square {
    /// Square without a node.
    pub fn leaf(flux: f64) -> Self {
        Self { flux, quarters: None }
    }

    /// Square with a node for these quarters.
    pub fn of(quarters: [Self; 4]) -> Self {
        Self { flux: quarters.iter().map(|quarter| quarter.flux).sum(), quarters: Some(Box::new(quarters)) }
    }

    /// Tree after an iteration that learned these fluxes. The first square always has a node.
    pub fn refined(&self) -> Self {
        let threshold = if self.flux > 0.0 { FLUX_SHARE * self.flux } else { f64::INFINITY };
        Self::of(self.quarters_or_even().map(|quarter| quarter.refined_at(1, threshold)))
    }

    fn refined_at(&self, level: u32, threshold: f64) -> Self {
        match self.flux > threshold && level < LEVELS {
            true => Self::of(self.quarters_or_even().map(|quarter| quarter.refined_at(level + 1, threshold))),
            false => Self::leaf(self.flux),
        }
    }

    fn quarters_or_even(&self) -> [Self; 4] {
        match &self.quarters {
            Some(quarters) => (**quarters).clone(),
            None => std::array::from_fn(|_| Self::leaf(0.25 * self.flux)),
        }
    }

    /// Number of nodes of this square and of all squares within it.
    pub fn node_count(&self) -> usize {
        self.quarters.iter().map(|quarters| 1 + quarters.iter().map(Self::node_count).sum::<usize>()).sum()
    }

    /// Density at a point of the unit square.
    pub fn density(&self, at: DVec2) -> f64 {
        let Some(quarters) = &self.quarters else { return 1.0 };
        let part = |x: f64| usize::from(x >= 0.5);
        let quarter = &quarters[2 * part(at.y) + part(at.x)];
        4.0 * quarter.flux / self.flux * quarter.density((2.0 * at).fract())
    }

    /// All squares without a node: lower left corner and side in the unit square, and probability.
    pub fn leaves(&self) -> Vec<(DVec2, f64, f64)> {
        let mut leaves = Vec::new();
        self.collect_leaves(DVec2::ZERO, 1.0, self.flux, &mut leaves);
        leaves
    }

    fn collect_leaves(&self, corner: DVec2, side: f64, whole: f64, leaves: &mut Vec<(DVec2, f64, f64)>) {
        let Some(quarters) = &self.quarters else { return leaves.push((corner, side, self.flux / whole)) };
        for (i, quarter) in quarters.iter().enumerate() {
            let at = DVec2::new((i % 2) as f64, (i / 2) as f64);
            quarter.collect_leaves(corner + 0.5 * side * at, 0.5 * side, whole, leaves);
        }
    }

    /// Density of the descent, per steradian.
    pub fn descent(&self, map: DirectionMap, wi: DVec3) -> f64 {
        let at = 0.5 * sphere_to_map(map, wi) + 0.5;
        self.density(at.clamp(DVec2::ZERO, DVec2::splat(1.0 - f64::EPSILON))) / (4.0 * std::f64::consts::PI)
    }

    /// Density of the mixture of descent and cosine, per steradian.
    pub fn pdf(&self, map: DirectionMap, n: DVec3, wi: DVec3) -> f64 {
        let of_cosine = wi.dot(n).max(0.0) / std::f64::consts::PI;
        (1.0 - COSINE_SHARE) * self.descent(map, wi) + COSINE_SHARE * of_cosine
    }

    /// Nodes in the form that a kernel reads, level by level.
    pub fn words(&self) -> Vec<[u32; 4]> {
        let (mut words, mut known) = (Vec::new(), 1);
        let mut open = VecDeque::from([(self, 0)]);
        while let Some((square, level)) = open.pop_front() {
            let Some(quarters) = &square.quarters else { continue };
            let inner = || quarters.iter().enumerate().filter(|(_, quarter)| quarter.quarters.is_some());
            let mask: u32 = inner().map(|(i, _)| 1 << i).sum();
            let links = known << FIRST_LINK_SHIFT | level << LEVEL_SHIFT | LEARNED_LINK | mask;
            known += mask.count_ones();
            open.extend(inner().map(|(_, quarter)| (quarter, level + 1)));
            let [a, b, c, d] = quarters.each_ref().map(|quarter| quarter.flux);
            let shares = [share(a + b, c + d), share(a, b), share(c, d)].map(|share| (share as f32).to_bits());
            words.push(if square.flux > 0.0 { [shares[0], shares[1], shares[2], links] } else { [0; 4] });
        }
        words
    }

    /// The tree whose first node is the first of `words`, with that flux.
    ///
    /// # Panics
    /// Where a link leads out of them.
    pub fn of_words(words: &[[u32; 4]], flux: f64) -> Self {
        Self::of_node(words, 0, flux)
    }

    fn of_node(words: &[[u32; 4]], node: usize, flux: f64) -> Self {
        let [lower, in_lower, in_upper] = std::array::from_fn(|i| f64::from(f32::from_bits(words[node][i])));
        let links = words[node][3];
        let shares =
            [lower * in_lower, lower * (1.0 - in_lower), (1.0 - lower) * in_upper, (1.0 - lower) * (1.0 - in_upper)];
        let quarter = |i: usize| {
            let below = (links >> FIRST_LINK_SHIFT) + (links & ((1 << i) - 1)).count_ones();
            match links >> i & 1 {
                0 => Self::leaf(shares[i] * flux),
                _ => Self::of_node(words, below as usize, shares[i] * flux),
            }
        };
        Self { flux, quarters: Some(Box::new(std::array::from_fn(quarter))) }
    }

    /// Whether another tree has nodes for the same squares, and fluxes that differ by at most `share` of this tree's
    /// flux.
    pub fn is_near(&self, other: &Self, share: f64) -> bool {
        self.is_within(other, share * self.flux)
    }

    fn is_within(&self, other: &Self, most: f64) -> bool {
        let are_near = match (&self.quarters, &other.quarters) {
            (Some(ours), Some(theirs)) => ours.iter().zip(theirs.iter()).all(|(a, b)| a.is_within(b, most)),
            (None, None) => true,
            _ => false,
        };
        are_near && (self.flux - other.flux).abs() <= most
    }
}

fn share(part: f64, other: f64) -> f64 {
    if part + other > 0.0 { part / (part + other) } else { 0.5 }
}
