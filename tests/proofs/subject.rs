//! What is put to the proof: the kernels as they are shipped, or a change to them or to their settings.

use lodestar::generated::kernels::test;
use lodestar::gpu::KernelSource;
use lodestar::settings::Settings;
use support::device::GROUP;
use support::guide_cases::GuideKernels;
use support::mutated;

/// A change to settings.
pub type Change = fn(&mut Settings);

/// Kernels and how they are run.
#[derive(Clone)]
pub struct Subject {
    /// What is changed.
    pub name: &'static str,
    /// A mutation of `tests/tampered`.
    pub mutation: Option<&'static str>,
    /// What renders are made with.
    pub change: Change,
    /// Added to every seed.
    pub seed: u32,
    /// Invocations of a workgroup, in the kernels of single functions.
    pub group: u32,
}

/// The renderer as it is.
pub const SHIPPED: Subject = Subject { name: "shipped", mutation: None, change: |_| {}, seed: 0, group: GROUP };

impl Subject {
    /// With a mutation of the kernels.
    pub const fn mutated(name: &'static str) -> Self {
        Self { name, mutation: Some(name), ..SHIPPED }
    }

    /// With other settings.
    pub const fn changed(name: &'static str, change: Change) -> Self {
        Self { name, change, ..SHIPPED }
    }

    /// The kernel that is run in place of a built-in one.
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

    /// Settings of a render, given those of a claim.
    pub fn settings(&self, mut settings: Settings) -> Settings {
        settings.seed += self.seed;
        (self.change)(&mut settings);
        settings
    }
}
