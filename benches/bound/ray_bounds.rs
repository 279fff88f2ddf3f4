//! Bounds for rays of the traversal alone: what they read and compute, and the measured time.

use std::rc::Rc;
use std::sync::Arc;

use lodestar::generated::kernels::test;
use support::bench::digits::three_digits;
use support::bench::median;
use support::bench::rates::{NODE_BYTES, mean_seconds, seconds_of};
use support::bench::rays::{Batch, Counts, KINDS, Ray, Tracer, make, picture, variant_of};
use support::bench::subjects::Subject;
use support::device::Device;

use crate::Limits;
use crate::operations::Operations;

/// Minimum time for which each measurement is repeated, in seconds.
const SECONDS: f64 = 0.1;
/// Number of nodes that fit into the nearest cache.
const NEAR_NODES: u32 = 128;
/// Odd stride that gives rays other neighbors.
const STRIDE: usize = 40_503;
const PRIMITIVE_BYTES: f64 = 48.0;

/// Rays of one kind in one scene.
pub struct RayBound {
    pub scene: String,
    pub kind: &'static str,
    /// Mean number of nodes per ray.
    pub nodes: f64,
    pub primitives: f64,
    pub operations: f64,
    /// Busy lanes as a share of a subgroup's lanes, while any of them visits a node.
    busy_lanes: f64,
    tracer: Rc<Tracer>,
    batch: Batch,
    node_count: u32,
    turns: Vec<Turn>,
}

/// Measurement in one round, in nanoseconds per ray.
#[derive(Clone, Copy)]
struct Turn {
    computing: f64,
    fetching: f64,
    fetching_at_random: f64,
    measured: f64,
}

pub fn all(device: &Arc<Device>, subjects: &[Rc<Subject>]) -> Vec<RayBound> {
    let fitting = subjects.iter().filter(|subject| Tracer::fits(device, &subject.bvh));
    fitting.flat_map(|subject| of_scene(device, subject)).collect()
}

fn of_scene(device: &Arc<Device>, subject: &Subject) -> Vec<RayBound> {
    let bvh = &subject.bvh;
    let tracer = Rc::new(Tracer::new(device, bvh, &test::TRAVERSE));
    let counter = Tracer::new(device, bvh, &test::TRAVERSE_COUNTS);
    let operations = Operations::of(&test::TRAVERSE, &variant_of(bvh));
    let Operations { per_node, per_primitive, rest } = operations;
    println!(
        "{}: operations of a node {per_node}, of a primitive {per_primitive}, of a ray besides {rest}",
        subject.name
    );
    let lanes = device.context.device().limits.subgroup_size.max(1) as usize;
    let kinds = make(device, &subject.scene, bvh, picture(device)).into_iter().zip(KINDS);
    let row = |(rays, (kind, _)): (Vec<Ray>, (&'static str, bool))| {
        let counts = counts_of(device, &counter, &rays);
        let batch = Batch::new(device, rays);
        let mean = |of: fn(&Counts) -> u32| {
            counts.iter().map(|counts| f64::from(of(counts))).sum::<f64>() / counts.len() as f64
        };
        let (nodes, primitives) = (mean(|counts| counts.nodes), mean(|counts| counts.primitives));
        RayBound {
            scene: subject.name.clone(),
            kind,
            nodes,
            primitives,
            operations: per_node * nodes + per_primitive * primitives + rest,
            busy_lanes: busy_lanes(&counts, lanes),
            tracer: Rc::clone(&tracer),
            batch,
            node_count: bvh.nodes.len() as u32,
            turns: Vec::new(),
        }
    };
    kinds.filter(|(rays, _)| !rays.is_empty()).map(row).collect()
}

/// Counts of what each ray fetches. Checks that they are the same when rays have other neighbors.
fn counts_of(device: &Device, counter: &Tracer, rays: &[Ray]) -> Vec<Counts> {
    let counts: Vec<Counts> = counter.outputs(&Batch::new(device, rays.to_vec()));
    assert!(counts.iter().all(|counts| counts.overrun == 0), "a ray was not followed to its end");
    // The number of rays is a power of two and the stride is odd, so this visits every ray.
    let other = |place: usize| place * STRIDE % rays.len();
    let strewn = (0..rays.len()).map(|place| rays[other(place)]).collect();
    let others: Vec<Counts> = counter.outputs(&Batch::new(device, strewn));
    let is_same = |(place, count): (usize, &Counts)| *count == counts[other(place)];
    assert!(others.iter().enumerate().all(is_same), "a ray's counts depend on its neighbors");
    counts
}

/// Share of busy lanes: visited nodes divided by the node visits of a subgroup until its last lane is done.
fn busy_lanes(counts: &[Counts], lanes: usize) -> f64 {
    let visited: u64 = counts.iter().map(|counts| u64::from(counts.nodes)).sum();
    let most = |group: &[Counts]| group.iter().map(|counts| u64::from(counts.nodes)).max().unwrap_or(0);
    let held: u64 = counts.chunks(lanes).map(|group| group.len() as u64 * most(group)).sum();
    visited as f64 / held as f64
}

impl RayBound {
    /// Bytes of geometry per ray.
    pub fn bytes(&self) -> f64 {
        f64::from(NODE_BYTES) * self.nodes + PRIMITIVE_BYTES * self.primitives
    }

    pub fn nodes_buffer(&self) -> &Arc<lodestar::gpu::Buffer> {
        self.tracer.nodes()
    }

    /// Bytes per second from the nearest cache.
    pub fn near_rate(&self, limits: &Limits) -> f64 {
        limits.fetches.rate(self.nodes_buffer(), NEAR_NODES.min(self.node_count), SECONDS)
    }

    pub fn measure(&mut self, limits: &Limits, counts: bool) {
        let count = self.batch.rays.len() as f64;
        let random = limits.fetches.rate(self.nodes_buffer(), self.node_count, SECONDS);
        let turn = Turn {
            computing: 1.0e9 * self.operations / limits.arithmetic.rate(SECONDS),
            fetching: 1.0e9 * self.bytes() / self.near_rate(limits),
            fetching_at_random: 1.0e9 * self.bytes() / random,
            measured: 1.0e9 * mean_seconds(SECONDS, || seconds_of(self.tracer.trace(&self.batch))) / count,
        };
        if counts {
            self.turns.push(turn);
        }
    }
}

pub fn print(rows: &[RayBound]) {
    println!("\nTraversal alone (`glsl/test/traverse.comp`), of one ray; ns are of the whole device\n");
    println!(
        "| scene | ray | nodes | primitives | bytes | operations | computing, ns | fetching, ns | at random, ns \
         | measured, ns | share of the bound | lanes busy |"
    );
    println!("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for row in rows {
        let of = |number: fn(&Turn) -> f64| median(row.turns.iter().map(number).collect());
        println!(
            "| {} | {} | {:.1} | {:.1} | {:.0} | {:.0} | {} | {} | {} | {} | {:.2} | {:.2} |",
            row.scene,
            row.kind,
            row.nodes,
            row.primitives,
            row.bytes(),
            row.operations,
            three_digits(of(|turn| turn.computing)),
            three_digits(of(|turn| turn.fetching)),
            three_digits(of(|turn| turn.fetching_at_random)),
            three_digits(of(|turn| turn.measured)),
            of(|turn| turn.computing.max(turn.fetching) / turn.measured),
            row.busy_lanes,
        );
    }
}
