//! A device under the validation layer, and the grids of one cell.

use std::sync::Arc;

use lodestar::cosine_integrals::cosine_integrals;
use lodestar::gpu::{Buffer, BufferKind, Context, ContextOptions, DescriptorSet, Kernel, KernelSource};
use lodestar::kernels::{Variant, test};
use lodestar::layout::NormalizationEntry;

pub const DIRECTIONS: u32 = 16;
pub const NORMALS: u32 = 16;

/// A context whose validation messages fail the test when it is dropped.
pub struct Device {
    pub context: Arc<Context>,
}

impl Device {
    pub fn new() -> Self {
        let context = Context::new(&ContextOptions { device: None, validate: true }).expect("a Vulkan device");
        Self { context }
    }

    pub fn storage(&self, name: &str, bytes: usize) -> Arc<Buffer> {
        Buffer::new(&self.context, name, bytes as u64, BufferKind::Storage).expect("a buffer")
    }

    /// Runs a test kernel over `groups` workgroups; `buffers` are its buffers in order of set and binding.
    pub fn run(&self, source: &KernelSource, variant: &Variant, buffers: &[&Arc<Buffer>], push: &[u8], groups: u32) {
        let kernel = Kernel::new(&self.context, source, &variant.entries()).expect("a pipeline");
        let mut rest = buffers;
        let sets: Vec<DescriptorSet> = source
            .sets
            .iter()
            .map(|shape| {
                let (own, others) = rest.split_at(shape.bindings.len());
                rest = others;
                DescriptorSet::new(&self.context, "test", shape, own).expect("a set")
            })
            .collect();
        let sets: Vec<_> = sets.iter().collect();
        self.context
            .submit(source.name, |recorder| recorder.dispatch(&kernel, &sets, push, [groups, 1, 1]))
            .expect("done");
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let messages = self.context.validation_messages();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "{messages:#?}");
        }
    }
}

/// The grids of a single cell that holds the given radiance, all normalizers filled by the device.
pub struct Cell {
    pub radiance: Arc<Buffer>,
    pub entries: Arc<Buffer>,
}

impl Cell {
    pub fn new(device: &Device, variant: &Variant, radiance: &[f32]) -> Self {
        let cosines = cosine_integrals(DIRECTIONS, NORMALS);
        let table = device.storage("radiance", size_of_val(radiance));
        table.upload(0, radiance).expect("uploaded");
        let entries = device.storage("entries", (NORMALS * NORMALS) as usize * size_of::<NormalizationEntry>());
        let integrals = device.storage("integrals", size_of_val(&cosines[..]));
        integrals.upload(0, &cosines).expect("uploaded");
        device.run(&test::NORMALIZE_CELL, variant, &[&table, &entries, &integrals], &[], 4);
        Self { radiance: table, entries }
    }

    pub fn entry(&self, normal_bin: u32) -> NormalizationEntry {
        self.entries.read(u64::from(normal_bin) * size_of::<NormalizationEntry>() as u64, 1).expect("read")[0]
    }
}
