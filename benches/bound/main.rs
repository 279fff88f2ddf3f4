//! Bounds on the speed of rays and updates. The bench counts what they read and compute, and measures how fast the
//! device does either. It prints which share of the kernels' time this explains.
//!
//! `cargo bench --bench bound [-- --rounds N]` measures the project's own scenes, and the shared scenes if
//! `LODESTAR_SCENES` names their folder. `LODESTAR_DEVICE` chooses the device.
//!
//! A bound is the longer of two times: the operations at the rate of `glsl/test/arithmetic.comp`, and the bytes at the
//! rate of `glsl/test/gather.comp` in the nearest cache. For updates, the bytes count at the rate of
//! `glsl/test/copy.comp`. The bound assumes that nothing waits for anything and that lanes never idle.
//!
//! The table also has the time that the bytes would take if every node came from a random place of the whole hierarchy.
//! This time is no bound, because neighboring rays read the same nodes. Lanes idle while others of their subgroup still
//! have nodes to visit; the bench counts how many lanes are busy.

mod operations;
mod path_bounds;
mod ray_bounds;
mod update_bounds;

use std::sync::Arc;

use support::bench::rates::{Arithmetic, Fetches};
use support::device::Device;

const ROUNDS: usize = 5;

/// Rates that the device can reach.
pub struct Limits {
    pub arithmetic: Arithmetic,
    pub fetches: Fetches,
}

fn main() {
    let mut arguments = std::env::args().skip_while(|argument| argument != "--rounds").skip(1);
    let rounds = arguments.next().map_or(ROUNDS, |text| text.parse().expect("--rounds takes a number"));
    let device = Arc::new(Device { context: support::bench::context() });
    let limits = Limits { arithmetic: Arithmetic::new(&device), fetches: Fetches::new(&device) };
    let subjects = support::bench::subjects::all();
    let mut rays = ray_bounds::all(&device, &subjects);
    let mut paths = path_bounds::all(&device.context, &subjects, &rays);
    let mut updates = update_bounds::all(&device);
    for round in 0..=rounds {
        // The first round warms up.
        let counts = round > 0;
        rays.iter_mut().for_each(|row| row.measure(&limits, counts));
        paths.iter_mut().for_each(|row| row.measure(&limits, counts));
        updates.iter_mut().for_each(|row| row.measure(counts));
        eprintln!("round {round} of {rounds}");
    }
    println!("\nmedians of {rounds} rounds");
    ray_bounds::print(&rays);
    path_bounds::print(&paths);
    update_bounds::print(&updates);
}
