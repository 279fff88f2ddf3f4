//! Subject of a proof: the shipped renderer, or a change to its kernels, to its settings, or to the sums that devices share.

use lodestar::fleet::sums::{self, AddSums};
use lodestar::generated::kernels::test;
use lodestar::gpu::KernelSource;
use lodestar::settings::Settings;
use support::device::GROUP;
use support::guide_cases::GuideKernels;
use support::mutated;

/// Function that changes settings.
pub type Change = fn(&mut Settings);

/// Kernels and the way in which they are run.
#[derive(Clone)]
pub struct Subject {
    /// Name of the change.
    pub name: &'static str,
    /// Name of a mutation of `tests/tampered`.
    pub mutation: Option<&'static str>,
    /// Change to the settings of renders.
    pub change: Change,
    /// Offset of every seed.
    pub seed: u32,
    /// Invocations per workgroup, in the kernels of single functions.
    pub group: u32,
    /// Function that adds a second device's sums of learning targets to the first one's.
    pub add_sums: AddSums,
}

/// The renderer as it is shipped.
pub const SHIPPED: Subject =
    Subject { name: "shipped", mutation: None, change: |_| {}, seed: 0, group: GROUP, add_sums: sums::add };

impl Subject {
    /// Subject with a mutation of the kernels.
    pub const fn mutated(name: &'static str) -> Self {
        Self { name, mutation: Some(name), ..SHIPPED }
    }

    /// Subject with other settings.
    pub const fn changed(name: &'static str, change: Change) -> Self {
        Self { name, change, ..SHIPPED }
    }

    /// Subject whose devices add up their sums in another way.
    pub const fn adding(name: &'static str, add_sums: AddSums) -> Self {
        Self { name, add_sums, ..SHIPPED }
    }

    /// Kernel that runs in place of a built-in one.
    pub fn kernel(&self, built_in: &KernelSource) -> KernelSource {
        self.mutation.map_or_else(|| built_in.clone(), |mutation| mutated::kernel(built_in, mutation))
    }

    pub fn guide_kernels(&self) -> GuideKernels {
        GuideKernels {
            normalize: self.kernel(&test::NORMALIZE_CELL),
            draw: self.kernel(&test::GUIDED_DIRECTION),
            density: self.kernel(&test::GUIDED_DENSITY),
            group: self.group,
        }
    }

    /// Settings of a render, made from the settings of a claim.
    pub fn settings(&self, mut settings: Settings) -> Settings {
        settings.seed += self.seed;
        (self.change)(&mut settings);
        settings
    }
}
