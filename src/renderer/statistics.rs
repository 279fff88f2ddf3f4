//! Statistics of a step.

use crate::generated::kernels;

/// Numbers that kernels count. The paper's tables and figures show rates that are derived from them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Rays traced.
    pub rays: u64,
    /// Rays that left a surface.
    pub scattered_rays: u64,
    /// Rays towards sampled lights, which are not among `rays`.
    pub shadow_rays: u64,
    /// Scattered rays that met light.
    pub light_hits: u64,
    /// Directions drawn by a guided sampler.
    pub guided_samples: u64,
    /// Proposals it took to draw them.
    pub tries: u64,
    /// Guided directions below the surface.
    pub invalid_samples: u64,
    /// Samples and learning targets dropped because they were NaN or infinite.
    pub nonfinite: u64,
    /// Invocations in which a loop was cut short.
    pub overruns: u64,
    /// Shadow rays through more surfaces than the kernels follow. Their light is missing.
    #[serde(default)]
    pub cut_shadow_rays: u64,
    /// Rays through more of a medium's grid than the kernels follow. Their light is missing.
    #[serde(default)]
    pub cut_flights: u64,
}

impl Counts {
    /// Reads the numbers from a kernel's counters: the low words of all, then their high words.
    pub(super) fn from_counters(counters: &[u32]) -> Self {
        let word = |index: u32| u64::from(counters[index as usize]);
        let at = |index: u32| word(index) | word(kernels::COUNTER_COUNT + index) << 32;
        Self {
            rays: at(kernels::COUNTER_RAYS),
            scattered_rays: at(kernels::COUNTER_SCATTERED_RAYS),
            shadow_rays: at(kernels::COUNTER_SHADOW_RAYS),
            light_hits: at(kernels::COUNTER_LIGHT_HITS),
            guided_samples: at(kernels::COUNTER_GUIDED_SAMPLES),
            tries: at(kernels::COUNTER_TRIES),
            invalid_samples: at(kernels::COUNTER_INVALID_SAMPLES),
            nonfinite: at(kernels::COUNTER_NONFINITE),
            overruns: at(kernels::COUNTER_OVERRUNS),
            cut_shadow_rays: at(kernels::COUNTER_CUT_SHADOW_RAYS),
            cut_flights: at(kernels::COUNTER_CUT_FLIGHTS),
        }
    }

    /// Adds another's numbers.
    pub fn add(&mut self, other: &Self) {
        self.rays = self.rays.saturating_add(other.rays);
        self.scattered_rays = self.scattered_rays.saturating_add(other.scattered_rays);
        self.shadow_rays = self.shadow_rays.saturating_add(other.shadow_rays);
        self.light_hits = self.light_hits.saturating_add(other.light_hits);
        self.guided_samples = self.guided_samples.saturating_add(other.guided_samples);
        self.tries = self.tries.saturating_add(other.tries);
        self.invalid_samples = self.invalid_samples.saturating_add(other.invalid_samples);
        self.nonfinite = self.nonfinite.saturating_add(other.nonfinite);
        self.overruns = self.overruns.saturating_add(other.overruns);
        self.cut_shadow_rays = self.cut_shadow_rays.saturating_add(other.cut_shadow_rays);
        self.cut_flights = self.cut_flights.saturating_add(other.cut_flights);
    }

    /// Share of the scattered rays that met light (the paper's Fig. 7a).
    pub fn light_hit_rate(&self) -> f64 {
        ratio(self.light_hits, self.scattered_rays)
    }

    /// Share of the guided directions that pointed below the surface (Table 1).
    pub fn invalid_rate(&self) -> f64 {
        ratio(self.invalid_samples, self.guided_samples)
    }

    /// Proposals per guided direction.
    pub fn tries_per_sample(&self) -> f64 {
        ratio(self.tries, self.guided_samples)
    }
}

fn ratio(a: u64, b: u64) -> f64 {
    if b == 0 { 0.0 } else { a as f64 / b as f64 }
}

/// Report of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepReport {
    /// Samples per pixel that were asked for.
    pub samples: u32,
    /// Pixels that were to take them.
    pub pixels: u64,
    /// Whether all of them were taken; else the step was stopped.
    pub complete: bool,
    /// Wall time, updates of the grids included.
    pub seconds: f64,
    /// Numbers that the kernels counted.
    pub counts: Counts,
}
