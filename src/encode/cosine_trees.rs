//! Trees of the clamped cosine, which the product sampler multiplies by trees of radiance: one tree for every
//! representative normal. The layout is that of `glsl/include/guide/samplers/tree.glsl`, the weights are those of
//! `glsl/include/math/small_floats.glsl`.

use crate::generated::constants::{BIAS_8, DROPPED_BITS, LARGEST_SMALL_FLOAT};
use crate::generated::layout::CosineIntegral;

/// Sixteen weights of eight bits, four to a row.
pub type Node = [u32; 4];

/// Parts of a node along each side, and blocks of the map.
const PARTS: u32 = 4;

/// Number of nodes of a tree of `directions * directions` bins.
pub fn nodes_per_tree(directions: u32) -> u32 {
    let middle = if directions > PARTS * PARTS { PARTS * PARTS } else { 0 };
    middle + (directions / PARTS).pow(2)
}

/// Trees of all normals, one after the other, from the integrals `[direction bin][normal bin]`.
pub fn cosine_trees(integrals: &[CosineIntegral], directions: u32, normals: u32) -> Vec<Node> {
    let normals = normals * normals;
    (0..normals)
        .flat_map(|normal| tree(directions, |bin| integrals[(bin * normals + normal) as usize].integral))
        .collect()
}

/// Tree of a non-negative function of the bins.
fn tree(directions: u32, value: impl Fn(u32) -> f32) -> Vec<Node> {
    let side = directions / PARTS;
    let bins = |node: u32| parts(node % side, node / side, PARTS).map(|(x, y)| value(y * directions + x));
    let sum = |x: u32, y: u32| bins(y * side + x).iter().sum::<f32>();
    let middle_side = side / PARTS;
    let middle = |node: u32| {
        let mut weights = [0.0; 16];
        for y in 0..middle_side {
            for x in 0..middle_side {
                let corner = (node % PARTS * middle_side, node / PARTS * middle_side);
                weights[(y * PARTS + x) as usize] = sum(corner.0 + x, corner.1 + y);
            }
        }
        weights
    };
    let middle_count = nodes_per_tree(directions) - side * side;
    (0..middle_count).map(middle).chain((0..side * side).map(bins)).map(|weights| pack(&weights)).collect()
}

/// Coordinates of the sixteen parts of a node.
fn parts(x: u32, y: u32, side: u32) -> [(u32, u32); 16] {
    std::array::from_fn(|i| (x * side + i as u32 % PARTS, y * side + i as u32 / PARTS))
}

/// Node of sixteen weights that are not negative.
pub(super) fn pack(weights: &[f32; 16]) -> Node {
    let largest = weights.iter().copied().fold(0.0, f32::max);
    let scale = if largest > 1.0e-36 { LARGEST_SMALL_FLOAT / largest } else { 0.0 };
    let code = |weight: f32| {
        let rounded = ((weight * scale).to_bits() + (1 << (DROPPED_BITS - 1))) >> DROPPED_BITS;
        rounded.saturating_sub(BIAS_8 << (23 - DROPPED_BITS))
    };
    std::array::from_fn(|row| (0..4).fold(0, |word, column| word | code(weights[4 * row + column]) << (8 * column)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::cosine_integrals::cosine_integrals;
    use crate::settings::DirectionMap;

    fn unpack(node: &Node) -> [f64; 16] {
        let code = |i: usize| node[i / 4] >> (8 * (i % 4)) & 255;
        std::array::from_fn(|i| f64::from(f32::from_bits((code(i) << DROPPED_BITS) + (BIAS_8 << 23))))
    }

    #[test]
    fn weights_are_within_a_sixteenth_and_never_zero() {
        let (directions, normals) = (32, 8);
        let integrals = cosine_integrals(DirectionMap::EqualArea, directions, normals);
        let trees = cosine_trees(&integrals, directions, normals);
        let count = nodes_per_tree(directions) as usize;
        assert_eq!(trees.len(), count * (normals * normals) as usize);
        for (normal, tree) in trees.chunks(count).enumerate() {
            for (last, node) in tree[16..].iter().enumerate() {
                let of_part = |(x, y): (u32, u32)| {
                    f64::from(integrals[(y * directions + x) as usize * (normals * normals) as usize + normal].integral)
                };
                let truth = parts(last as u32 % 8, last as u32 / 8, PARTS).map(of_part);
                let largest = truth.iter().copied().fold(0.0, f64::max);
                for (found, truth) in unpack(node).iter().zip(truth) {
                    let expected = if largest > 0.0 { 1.875 * truth / largest } else { 0.0 };
                    assert!(*found > 0.0);
                    let error = (found - expected).abs();
                    assert!(
                        error <= 0.0626 * expected + 1.0e-9,
                        "normal {normal}, node {last}: {found}, not {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn middle_levels_sum_up_their_parts() {
        for directions in [32, 64] {
            let tree = tree(directions, |bin| (bin % 7) as f32 + (bin / directions) as f32);
            let side = directions / 16;
            let block = unpack(&tree[5]);
            let value = |x: u32, y: u32| ((y * directions + x) % 7 + y) as f32;
            let sum = |x: u32, y: u32| {
                let corner = (4 * (side + x), 4 * (side + y));
                (0..16).map(|i| value(corner.0 + i % 4, corner.1 + i / 4)).sum::<f32>()
            };
            let truth = |i: u32| f64::from(sum(i % 4, i / 4) / sum(0, 0));
            for i in (0..16).filter(|i| i % 4 < side && i / 4 < side) {
                let found = block[i as usize] / block[0];
                assert!((found / truth(i) - 1.0).abs() < 0.14, "{directions}, part {i}: {found}, not {}", truth(i));
            }
        }
    }
}
