//! Baseline of everything that determines the speed of a render, in one table: rays, samplers, updates, loading,
//! hierarchies and whole renders. The stored baseline stands beside the new values, and Mitsuba 3 too where Python has
//! it.
//!
//! `cargo bench --bench baseline [-- WORD... --rounds N --store]` measures the quantities whose names contain one of
//! the words, or all quantities. `--store` writes the baseline with which later runs on this device are compared,
//! `benches/baselines/DEVICE.json`. The project's own scenes are always measured. The shared scenes are measured if
//! `LODESTAR_SCENES` names their folder. `LODESTAR_DEVICE` chooses the device. Mitsuba needs `DRJIT_LIBLLVM_PATH`.
//!
//! Every number is the median over rounds. In each round every quantity is measured once. Right before each
//! measurement, a fixed piece of work is timed, on the device or on the processor's threads, depending on where the
//! quantity runs. The corrected ratio compares speeds relative to this work. A machine that is slower on the day is
//! thus not mistaken for a slower build.

mod calibration;
mod hierarchies;
mod machine;
mod mitsuba;
mod quantity;
mod render_times;
mod rounds;
mod samplers;
mod store;
mod table;
mod traced_rays;
mod updates;

use std::sync::Arc;

use calibration::Calibration;
use machine::Machine;
use mitsuba::Mitsuba;
use quantity::Quantity;
use store::Baseline;
use support::device::Device;

const ROUNDS: usize = 5;

/// Options of the command line.
struct Options {
    words: Vec<String>,
    rounds: usize,
    store: bool,
}

impl Options {
    fn from_command_line() -> Self {
        let mut options = Self { words: Vec::new(), rounds: ROUNDS, store: false };
        let mut arguments = std::env::args().skip(1);
        while let Some(argument) = arguments.next() {
            match argument.as_str() {
                "--store" => options.store = true,
                "--rounds" => {
                    options.rounds = arguments.next().and_then(|n| n.parse().ok()).expect("--rounds takes a number");
                }
                // Cargo itself adds `--bench`.
                "--bench" => {}
                _ => options.words.push(argument),
            }
        }
        assert!(options.rounds > 0, "--rounds takes a number above 0");
        assert!(!options.store || options.words.is_empty(), "only a baseline of all quantities is stored");
        options
    }

    fn asks_for(&self, quantity: &Quantity) -> bool {
        self.words.is_empty() || self.words.iter().any(|word| quantity.name.contains(word.as_str()))
    }
}

fn main() {
    let options = Options::from_command_line();
    let context = support::bench::context();
    let machine = Machine::here(context.device());
    machine.print();
    let load = machine::load();
    machine.warn_of_load(load);
    let device = Arc::new(Device { context });
    let folder = tempfile::tempdir().expect("a folder");
    let mut quantities = all(&device, folder.path());
    quantities.retain(|quantity| options.asks_for(quantity));
    let mut mitsuba = Mitsuba::start(device.context.device());
    let calibration = Calibration::new(&device);
    let measured = rounds::measure(&mut quantities, &calibration, &mut mitsuba, options.rounds);
    let now = Baseline::new(machine, load, options.rounds, &measured);
    let stored = Baseline::of_machine(&now.machine);
    table::print(&now, stored.as_ref(), &mitsuba);
    if options.store {
        println!("\nstored: {}", now.write().display());
    }
}

/// All quantities, in the order of the table.
fn all(device: &Arc<Device>, folder: &std::path::Path) -> Vec<Quantity> {
    let subjects = support::bench::subjects::all();
    let mut quantities = traced_rays::quantities(device, &subjects, folder);
    quantities.extend(samplers::quantities(device));
    quantities.extend(updates::quantities());
    quantities.extend(hierarchies::quantities(&subjects));
    quantities.extend(render_times::quantities(&device.context, &subjects));
    quantities
}
