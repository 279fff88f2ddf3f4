//! Proofs that no sampler is biased: what is claimed of every sampler, learner and scattering function, tested at once, and
//! a proof that the tests find what they are for: known faults, each in kernels of its own. See `docs/proofs.md`.

mod billion;
mod claims;
mod evidence;
mod renders;
mod rows;
mod subject;
mod tables;
mod tampering;

// What the other suites have, of which this one needs a part.
#[allow(dead_code)]
#[path = "../samplers/device.rs"]
mod device;
#[allow(dead_code)]
#[path = "../render/estimate.rs"]
mod estimate;
#[allow(dead_code)]
#[path = "../render/floor.rs"]
mod floor;
#[allow(dead_code)]
#[path = "../samplers/guide_cases.rs"]
mod guide_cases;
#[allow(dead_code)]
#[path = "../render/mutated.rs"]
mod mutated;
#[allow(dead_code)]
#[path = "../samplers/sampled_directions.rs"]
mod sampled_directions;
#[allow(dead_code)]
#[path = "../samplers/scattering_cases.rs"]
mod scattering_cases;
#[allow(dead_code)]
#[path = "../render/scenes.rs"]
mod scenes;
#[allow(dead_code)]
#[path = "../render/significance.rs"]
mod significance;
#[allow(dead_code)]
#[path = "../samplers/statistics.rs"]
mod statistics;
#[allow(dead_code)]
#[path = "../samplers/substances.rs"]
mod substances;
