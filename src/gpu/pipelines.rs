//! Pipelines that a context has built, kept for kernels with the same SPIR-V and the same constants: another render in
//! the same context then starts without compiling.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;
use xxhash_rust::xxh3::Xxh3;

use super::device::LogicalDevice;
use crate::Result;
use crate::generated::interface::KernelSource;

/// Maximum number of pipelines that a context keeps. A driver needs some megabytes for each.
const MOST_KEPT: usize = 24;

/// Compute pipeline.
pub(super) struct Pipeline {
    raw: vk::Pipeline,
    device: Arc<LogicalDevice>,
}

impl Pipeline {
    /// Takes ownership of a pipeline of this device.
    pub(super) fn new(device: Arc<LogicalDevice>, raw: vk::Pipeline) -> Self {
        Self { raw, device }
    }

    /// Handle of the pipeline, for a call during which the caller borrows this value.
    pub(super) fn raw(&self) -> vk::Pipeline {
        self.raw
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        // SAFETY: invariants 1 and 3: owned by this value alone, and no submission that used it is under way.
        unsafe { self.device.raw().destroy_pipeline(self.raw, None) }
    }
}

/// Hash of everything that a pipeline follows from: the SPIR-V, its layout, and the constants as (id, bits).
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct PipelineKey(u128);

impl PipelineKey {
    pub(super) fn new(source: &KernelSource, constants: &[(u32, u32)]) -> Self {
        let mut hash = Xxh3::new();
        let mut add = |number: u32| hash.update(&number.to_le_bytes());
        add(source.push_constant_bytes);
        add(constants.len() as u32);
        for &(id, bits) in constants {
            add(id);
            add(bits);
        }
        for set in source.sets {
            add(set.set);
            add(set.bindings.len() as u32);
            for binding in set.bindings {
                add(binding.binding);
                add(binding.kind as u32);
            }
        }
        hash.update(&source.spirv);
        Self(hash.digest128())
    }
}

/// Pipelines that were used last, the latest at the end.
#[derive(Default)]
pub(super) struct Pipelines(Mutex<VecDeque<(PipelineKey, Arc<Pipeline>)>>);

impl Pipelines {
    /// Returns the pipeline of this key, which `build` makes where it is not kept.
    pub(super) fn get_or_build(
        &self,
        key: PipelineKey,
        build: impl FnOnce() -> Result<Pipeline>,
    ) -> Result<Arc<Pipeline>> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = kept.iter().position(|(other, _)| *other == key).and_then(|at| kept.remove(at));
        let pipeline = match known {
            Some((_, pipeline)) => pipeline,
            None => Arc::new(build()?),
        };
        if kept.len() == MOST_KEPT {
            kept.pop_front();
        }
        kept.push_back((key, Arc::clone(&pipeline)));
        Ok(pipeline)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generated::kernels::{BackEnd, Registry};
    use crate::gpu::{Context, ContextOptions, Kernel};

    #[test]
    fn equal_kernels_share_a_pipeline_and_others_do_not() {
        let context = Context::new(&ContextOptions { device: None, validate: true }).expect("a device");
        let registry = Registry::built_in();
        let source = &registry.kernels(BackEnd::Storage).blend_radiance;
        let ids = source.specialization_ids;
        let build = |constants: &[(u32, u32)]| Kernel::new(&context, source, constants).expect("a kernel");
        let (a, b) = (build(&[]), build(&[]));
        assert!(a.raw() == b.raw());
        assert!(a.raw() != build(&[(ids[0], 32)]).raw(), "another constant");
        // The store forgets old pipelines. A kernel that still has one keeps it.
        let others: Vec<_> = (0..MOST_KEPT as u32).map(|bits| build(&[(ids[0], 1 + bits)]).raw()).collect();
        assert!(!others.contains(&a.raw()));
        assert!(a.raw() != build(&[]).raw(), "forgotten");
        assert!(context.validation_messages().is_empty(), "{:?}", context.validation_messages());
    }

    #[test]
    fn every_part_of_a_key_counts() {
        let registry = Registry::built_in();
        let [storage, texel] =
            [BackEnd::Storage, BackEnd::Texel].map(|back_end| registry.kernels(back_end).blend_radiance.clone());
        assert!(storage.spirv == texel.spirv && storage.sets != texel.sets, "they differ in their layouts only");
        let key = PipelineKey::new(&storage, &[(0, 1)]);
        assert!(key == PipelineKey::new(&storage, &[(0, 1)]));
        let other_spirv = KernelSource { spirv: storage.spirv[4..].to_vec().into(), ..storage.clone() };
        for other in [
            PipelineKey::new(&texel, &[(0, 1)]),
            PipelineKey::new(&other_spirv, &[(0, 1)]),
            PipelineKey::new(&storage, &[(0, 2)]),
            PipelineKey::new(&storage, &[(1, 1)]),
            PipelineKey::new(&storage, &[]),
        ] {
            assert!(key != other);
        }
    }
}
