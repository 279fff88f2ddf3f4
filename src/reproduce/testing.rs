//! Made-up records for tests.

use super::methods::Method;
use super::record::{Conditions, Memory, Record, StepRecord};
use crate::image::metrics::Metrics;
use crate::renderer::Counts;

/// Record of 16 samples per pixel in one second and two steps. The error at the end is `mae`; after the first step it
/// is twice that.
pub fn record(scene: &str, method: &Method, mae: f64) -> Record {
    let step = |spp, mae| StepRecord { spp, seconds: f64::from(spp) / 16.0, light_hit_rate: 0.1, mae: Some(mae) };
    Record {
        conditions: Conditions {
            version: "1".into(),
            device: "a device".into(),
            scene_hash: "a".into(),
            reference_hash: "b".into(),
            budget: 1.0,
            settings: serde_json::Value::Null,
        },
        scene: scene.into(),
        method: method.name(),
        width: 8,
        height: 4,
        spp: 16,
        seconds: 1.0,
        errors: Metrics { mae_ldr: mae, mae, mse: mae, relmse: mae, relmse_trim: mae, mean_ratio: 1.0 },
        counts: Counts::default(),
        memory: Memory { guide_bytes: 1 << 20, path_bytes: 0 },
        steps: vec![step(8, 2.0 * mae), step(16, mae)],
    }
}
