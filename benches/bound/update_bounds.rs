//! Bounds for the kernels that end a step: the bytes that they request, by the layout of the grids, and the measured
//! time.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use lodestar::encode::cells::Cells;
use lodestar::encode::cosine_trees::{Node, nodes_per_tree};
use lodestar::generated::layout::{CosineIntegral, LearnedRadiance, NormalizationEntry, RadianceSum};
use lodestar::settings::Sampler;
use support::bench::digits::three_digits;
use support::bench::guide_updates::{Ground, Stepper, steppers};
use support::bench::median;
use support::bench::rates::Copies;
use support::device::Device;

/// Minimum time for which each measurement is repeated, in seconds.
const SECONDS: f64 = 0.15;
/// Direction bins along each side, as in the default settings.
const DIRECTIONS: u32 = 16;
const NORMALS: u32 = 16;

const RADIANCE: u64 = size_of::<f32>() as u64;
const LEARNED: u64 = size_of::<LearnedRadiance>() as u64;
const SUM: u64 = size_of::<RadianceSum>() as u64;
const ENTRY: u64 = size_of::<NormalizationEntry>() as u64;
const BINS: u64 = (DIRECTIONS * DIRECTIONS) as u64;

/// Kernel in one setting.
pub struct UpdateBound {
    name: String,
    kernel: &'static str,
    /// Renderer that runs the kernel.
    stepper: Rc<RefCell<Stepper>>,
    cells: u64,
    entries: u64,
    /// Bytes that a step reads and writes.
    bytes: u64,
    copies: Copies,
    turns: Vec<Turn>,
}

/// Measurement in one round, in milliseconds per step.
#[derive(Clone, Copy)]
struct Turn {
    copying: f64,
    measured: f64,
}

pub fn all(device: &Arc<Device>) -> Vec<UpdateBound> {
    let ground = Ground::new();
    let cells = ground.cells();
    let steppers = steppers(&ground).into_iter().map(|stepper| Rc::new(RefCell::new(stepper)));
    let rows = steppers.flat_map(|stepper| {
        let (title, sampler, kernels) = {
            let stepper = stepper.borrow();
            (stepper.title, stepper.sampler, stepper.kernels)
        };
        let entries = stepper.borrow().marked_entries();
        let row = |&kernel: &&'static str| {
            let bytes = bytes_of(kernel, sampler, &cells, entries);
            UpdateBound {
                name: format!("{kernel}, {title}"),
                kernel,
                stepper: Rc::clone(&stepper),
                cells: u64::from(cells.count()),
                entries,
                bytes,
                copies: Copies::new(device, bytes),
                turns: Vec::new(),
            }
        };
        kernels.iter().map(row).collect::<Vec<_>>()
    });
    rows.collect()
}

/// Bytes that a kernel requests in a step, in the order of its source. BSDF shares and marks are left out: they are a
/// few words per cell.
fn bytes_of(kernel: &str, sampler: Sampler, cells: &Cells, entries: u64) -> u64 {
    let count = u64::from(cells.count());
    let parents = u64::from(cells.all_count()) - count;
    match kernel {
        // The kernel takes the targets and learns, then applies the floor.
        "update_radiance" => count * BINS * (2 * SUM + 2 * LEARNED + LEARNED + RADIANCE),
        // The kernel writes the tree of a cell, and reads for every entry all bins with their cosines.
        "update_normalization" if sampler == Sampler::Product => {
            let tree = BINS * RADIANCE + u64::from(nodes_per_tree(DIRECTIONS)) * size_of::<Node>() as u64;
            count * tree + entries * (BINS * (RADIANCE + size_of::<f32>() as u64) + ENTRY)
        }
        "update_normalization" => entries * (BINS * (RADIANCE + size_of::<CosineIntegral>() as u64) + ENTRY),
        // The kernel reads every cell but the largest once.
        "pool_radiance" => BINS * LEARNED * (count + parents - 1 + parents),
        // The kernel reads the learned and the parent's radiance, and writes the estimate. Cells read the estimate once
        // more and write it with the floor.
        "blend_radiance" => BINS * (parents * 4 * LEARNED + count * (2 * LEARNED + 3 * RADIANCE)),
        _ => unreachable!("{kernel} has no count of bytes"),
    }
}

impl UpdateBound {
    pub fn measure(&mut self, is_counted: bool) {
        let copying = 1.0e3 * self.bytes as f64 / self.copies.rate(SECONDS);
        let measured = 1.0e3 * self.stepper.borrow_mut().seconds_per_step(self.kernel, SECONDS);
        if is_counted {
            self.turns.push(Turn { copying, measured });
        }
    }
}

pub fn print(rows: &[UpdateBound]) {
    println!("\nUpdates of {} directions and {} normals a cell, of one step\n", DIRECTIONS.pow(2), NORMALS.pow(2));
    println!("| kernel | cells | entries | bytes of a cell | copying, ms | measured, ms | share of the bound |");
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for row in rows {
        let of = |number: fn(&Turn) -> f64| median(row.turns.iter().map(number).collect());
        println!(
            "| {} | {} | {} | {} | {} | {} | {:.2} |",
            row.name,
            row.cells,
            row.entries,
            row.bytes / row.cells,
            three_digits(of(|turn| turn.copying)),
            three_digits(of(|turn| turn.measured)),
            of(|turn| turn.copying / turn.measured),
        );
    }
}
