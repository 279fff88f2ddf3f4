//! Everything that decides how fast a render is, in one table beside what it was: rays, samplers, updates, loading and
//! hierarchies, whole renders, and beside Mitsuba 3 where Python has it.
//!
//! `cargo bench --bench baseline [-- WORD... --rounds N --store]`: the quantities whose names hold one of the words, or
//! all. `--store` writes the baseline that later runs on such a device are compared with,
//! `benches/baselines/DEVICE.json`. The project's own scenes are always measured, the shared ones as well where
//! `LODESTAR_SCENES` names their folder; `LODESTAR_DEVICE` chooses the device, `DRJIT_LIBLLVM_PATH` serves Mitsuba.
//!
//! Every number is the median of rounds, in each of which every quantity has its turn. Right before each, a fixed piece
//! of work is timed: on the device for what runs there, else on the processor's threads. The corrected ratio is that of
//! speeds relative to this work, so that a machine that is slower on the day does not pass for a slower build.

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

/// What the command line asks for.
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
                // Cargo adds this one itself.
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
