//! Claim: each iteration of `quadtree` leaves valid trees. Squares of directions are divided exactly where they have
//! more than their share of a tree's flux. Trees do not overlap, and every leaf of space has a tree of its own.

use lodestar::renderer::{RenderState, Renderer};
use lodestar::settings::{SamplePattern, Sampler, Settings};
use support::scenes::ours;
use support::twins::quadtree::{FLUX_SHARE, LEVELS, Square};

use crate::evidence::Evidence;
use crate::renders::{Studio, steps};
use crate::rows::{Row, Scope};
use crate::subject::Subject;

const SIDE: u32 = 24;
const SEED: u32 = 1100;
/// Samples per pixel after which six iterations have ended.
const SPP: u32 = 63;
/// Error of a square's share of the flux in single precision.
const ROUNDING: f64 = 1.0e-6;

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let studio = Studio::new();
    for row in scope.rendered() {
        let settings = settings(&row);
        if settings.sampler != Sampler::Quadtree {
            continue;
        }
        let limit = (settings.grid().pow(3) * settings.directions.pow(2)) as usize;
        let mut renderer = studio.renderer(subject, &ours("cornell-box/scene.xml", &[]), settings);
        steps(&mut renderer, SPP, SPP);
        let forest = Forest::new(&renderer, limit);
        let mut hold = |what: &str, holds: bool, otherwise: &str| {
            evidence.hold(format!("{what}, {}, seed {SEED}", row.name), holds, || otherwise.into());
        };
        hold("leaves", forest.leaves.len() > 1, "space is not divided");
        let trees = || forest.leaves.iter().map(|leaf| &forest.words[leaf.first..=leaf.first + leaf.last]);
        hold("light", trees().all(|tree| tree[0][3] != 0), "a tree has learned nothing");
        let is_refined = |tree: &[[u32; 4]]| is_refined(&Square::of_words(tree, 1.0), 0);
        hold(
            "squares",
            trees().all(is_refined),
            "a square is divided that has little flux, or one that has much is not",
        );
        hold("places", forest.is_disjoint(limit), "trees overlap");
        hold("space", forest.is_linked(limit), "a leaf's place in the tree of space has another tree");
    }
}

fn settings(row: &Row) -> Settings {
    let scene = ours("cornell-box/scene.xml", &[]);
    let mut settings = Settings {
        width: SIDE,
        height: SIDE,
        seed: SEED,
        pattern: SamplePattern::Independent,
        ..Settings::for_scene(&scene)
    };
    row.set(&mut settings);
    settings
}

/// Whether the part of a tree below a square at this level is divided where it should be. The tree has flux 1.
fn is_refined(square: &Square, level: u32) -> bool {
    let is_first = level == 0;
    let is_near = (square.flux - FLUX_SHARE).abs() < ROUNDING;
    let should = is_first || (square.flux > FLUX_SHARE && level < LEVELS);
    let below = square.quarters.iter().flat_map(|quarters| quarters.iter());
    (is_near || square.quarters.is_some() == should) && below.clone().all(|quarter| is_refined(quarter, level + 1))
}

/// A leaf of the tree of space: its node there, and its quadtree's first and last node.
struct Leaf {
    spatial_node: usize,
    first: usize,
    last: usize,
}

/// All quadtrees of a render, laid out as in `quadtree_nodes.glsl`.
struct Forest {
    words: Vec<[u32; 4]>,
    leaves: Vec<Leaf>,
}

impl Forest {
    fn new(renderer: &Renderer, limit: usize) -> Self {
        let state: RenderState = renderer.state().expect("a state");
        let part = state.parts.iter().find(|part| part.name == "radiance nodes").expect("a part");
        let words: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(&part.bytes);
        let spatial = (2 * leaf_limit(limit)).div_ceil(4);
        let count = words[limit + leaf_limit(limit) + spatial][0] as usize + 1;
        let leaf = |[spatial_node, _, first, last]: [u32; 4]| Leaf {
            spatial_node: spatial_node as usize,
            first: first as usize,
            last: last as usize,
        };
        let leaves = words[limit..limit + count].iter().map(|&words| leaf(words)).collect();
        Self { words, leaves }
    }

    fn is_disjoint(&self, limit: usize) -> bool {
        let mut ranges: Vec<_> = self.leaves.iter().map(|leaf| leaf.first..leaf.first + leaf.last + 1).collect();
        ranges.sort_by_key(|range| range.start);
        ranges.windows(2).all(|pair| pair[0].end <= pair[1].start) && ranges.iter().all(|range| range.end <= limit)
    }

    fn is_linked(&self, limit: usize) -> bool {
        let spatial = limit + leaf_limit(limit);
        let tree_at = |node: usize| self.words[spatial + node / 4][node % 4] as usize;
        self.leaves.iter().all(|leaf| tree_at(leaf.spatial_node) == leaf.first)
    }
}

/// Twin of `leaf_limit` in GLSL.
fn leaf_limit(limit: usize) -> usize {
    limit / 8
}
