//! Where the time goes: what rays and updates read and compute, counted; how fast the device does either, measured; and
//! which share of the time that follows the kernels take.
//!
//! `cargo bench --bench bound [-- --rounds N]`: the project's own scenes, and the shared ones where `LODESTAR_SCENES`
//! names their folder. `LODESTAR_DEVICE` chooses the device.
//!
//! A bound is the longer of two times: of the operations at the rate of `glsl/test/arithmetic.comp`, and of the bytes
//! at that of `glsl/test/gather.comp` in the nearest cache (of updates: at that of `glsl/test/copy.comp`). It supposes
//! that nothing waits for anything and that lanes never idle. Beside it stands what the bytes would take if every node
//! came from a random place of the whole hierarchy: no bound, for neighbors' rays read the same nodes. Lanes are idle
//! while others of their subgroup still have nodes to visit; how many are busy is counted.

mod operations;
mod path_bounds;
mod ray_bounds;
mod update_bounds;

use std::sync::Arc;

use support::bench::rates::{Arithmetic, Fetches};
use support::device::Device;

const ROUNDS: usize = 5;

/// What the device can do.
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
        // The first warms up.
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
