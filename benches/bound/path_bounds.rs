//! Bounds for rays of `trace` with the sampler `bsdf`, including shading: geometry, operations and measured time.

use std::rc::Rc;
use std::sync::Arc;

use lodestar::generated::kernels::TEXEL_BUFFERS;
use lodestar::gpu::Context;
use lodestar::renderer::{Renderer, variant_for};
use lodestar::settings::{Sampler, Settings};
use support::bench::digits::three_digits;
use support::bench::subjects::Subject;
use support::bench::{median, renderer, run_for, settings};

use crate::Limits;
use crate::operations::Operations;
use crate::ray_bounds::RayBound;

const SIZE: [u32; 2] = [256, 256];
/// Minimum time for which each measurement is repeated, in seconds.
const SECONDS: f64 = 0.3;
const FIRST_STEPS: u32 = 2;

/// Renderer, with the counts of its rays.
pub struct PathBound {
    scene: String,
    settings: Settings,
    renderer: Renderer,
    rays_per_path: f64,
    bytes: f64,
    operations: f64,
    /// Operations of the traversal, a part of all operations.
    traversal_operations: f64,
    turns: Vec<Turn>,
}

/// Measurement in one round, in nanoseconds per ray.
#[derive(Clone, Copy)]
struct Turn {
    computing: f64,
    measured: f64,
}

/// Bounds for the scenes whose rays are in `rays`. Rays after the first bounce are assumed to be like those of the
/// first bounce.
pub fn all(context: &Arc<Context>, subjects: &[Rc<Subject>], rays: &[RayBound]) -> Vec<PathBound> {
    let row = |subject: &Rc<Subject>| {
        let of_kind = |kind: &str| rays.iter().find(|row| row.scene == subject.name && row.kind == kind);
        let (primary, bounce) = (of_kind("primary")?, of_kind("bounce")?);
        let settings = settings(&subject.scene, SIZE, Sampler::Bsdf);
        let mut renderer = renderer(context, &subject.scene, &settings, FIRST_STEPS);
        let (spp, _, counts) = run_for(&mut renderer, SECONDS, &settings);
        let rays_per_path = counts.rays as f64 / (f64::from(spp) * f64::from(SIZE[0] * SIZE[1]));
        let mean = |of: &dyn Fn(&RayBound) -> f64| (of(primary) + (rays_per_path - 1.0) * of(bounce)) / rays_per_path;
        let variant = variant_for(&settings, &subject.scene, &subject.bvh);
        let operations = Operations::of(&TEXEL_BUFFERS.trace, &variant);
        let traversal_operations =
            mean(&|row: &RayBound| operations.per_node * row.nodes + operations.per_primitive * row.primitives);
        Some(PathBound {
            scene: subject.name.clone(),
            settings,
            renderer,
            rays_per_path,
            bytes: mean(&RayBound::bytes),
            operations: traversal_operations + operations.rest,
            traversal_operations,
            turns: Vec::new(),
        })
    };
    subjects.iter().filter_map(row).collect()
}

impl PathBound {
    pub fn measure(&mut self, limits: &Limits, is_counted: bool) {
        let computing = 1.0e9 * self.operations / limits.arithmetic.rate(SECONDS / 3.0);
        let (_, seconds, counts) = run_for(&mut self.renderer, SECONDS, &self.settings);
        if is_counted {
            self.turns.push(Turn { computing, measured: 1.0e9 * seconds / counts.rays as f64 });
        }
    }
}

pub fn print(rows: &[PathBound]) {
    println!("\n`trace`, `bsdf`, no emitter sampling, of one ray with what is shaded at its end\n");
    println!(
        "| scene | rays of a path | bytes of geometry | operations | of the traversal | computing, ns | measured, ns \
         | share of the bound |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|");
    for row in rows {
        let of = |number: fn(&Turn) -> f64| median(row.turns.iter().map(number).collect());
        println!(
            "| {} | {:.1} | {:.0} | {:.0} | {:.0} | {} | {} | {:.2} |",
            row.scene,
            row.rays_per_path,
            row.bytes,
            row.operations,
            row.traversal_operations,
            three_digits(of(|turn| turn.computing)),
            three_digits(of(|turn| turn.measured)),
            of(|turn| turn.computing / turn.measured),
        );
    }
}
