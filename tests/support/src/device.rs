//! Device under the validation layer, and the grids of a single cell.

use std::sync::{Arc, Mutex, PoisonError};

use bytemuck::{Pod, Zeroable};
use lodestar::encode::cosine_integrals::cosine_integrals;
use lodestar::encode::cosine_trees::{Node, cosine_trees, nodes_per_tree};
use lodestar::generated::kernels::{MAP_CYLINDRICAL, SAMPLER_PRODUCT, Variant, test};
use lodestar::generated::layout::{NormalizationEntry, SceneConstants};
use lodestar::gpu::{
    BindingKind, Buffer, BufferKind, Context, ContextOptions, DescriptorSet, Kernel, KernelSource, SetShape, Submission,
};
use lodestar::settings::DirectionMap;

/// Invocations per workgroup, unless a test sets another number.
pub const GROUP: u32 = 64;

/// Contexts that no test uses now. The validation layer of Debian 12 looks its devices up without a lock while another thread makes or
/// destroys one, which may crash. So tests hand their devices on, and few are made.
static IDLE: Mutex<Vec<Arc<Context>>> = Mutex::new(Vec::new());

/// Context whose validation messages fail the test when it is dropped.
pub struct Device {
    pub context: Arc<Context>,
}

impl Device {
    /// The first device that the loader lists and the renderer can use.
    pub fn new() -> Self {
        let idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let new = || Context::new(&ContextOptions { device: None, validate: true }).expect("a Vulkan device");
        Self { context: idle.unwrap_or_else(new) }
    }

    pub fn buffer(&self, name: &str, bytes: usize, kind: BufferKind) -> Arc<Buffer> {
        Buffer::new(&self.context, name, bytes as u64, kind).expect("a buffer")
    }

    pub fn storage(&self, name: &str, bytes: usize) -> Arc<Buffer> {
        self.buffer(name, bytes, BufferKind::Storage)
    }

    pub fn uploaded<T: Pod>(&self, name: &str, values: &[T]) -> Arc<Buffer> {
        let buffer = self.storage(name, size_of_val(values));
        buffer.upload(0, values).expect("uploaded");
        buffer
    }

    /// Whether a texel buffer has room for `bytes` bytes, in texels of `texel_bytes` each. Prints a line if not,
    /// because the test is then skipped.
    pub fn has_room(&self, name: &str, bytes: usize, texel_bytes: u64) -> bool {
        let device = self.context.device();
        let has_room = bytes as u64 <= device.limits.max_texel_elements * texel_bytes;
        if !has_room {
            println!("{name}: skipped, for {} has no room for {bytes} bytes in a texel buffer", device.name);
        }
        has_room
    }

    /// Whether the device has ray queries. Prints a line if not, because the test is then skipped.
    pub fn has_ray_queries(&self, name: &str) -> bool {
        let device = self.context.device();
        if !device.limits.has_ray_queries {
            println!("{name}: skipped, for {} has no ray queries", device.name);
        }
        device.limits.has_ray_queries
    }

    pub fn kernel(&self, source: &KernelSource, variant: &Variant) -> Kernel {
        Kernel::new(&self.context, source, &variant.entries()).expect("a pipeline")
    }

    /// Dispatches a kernel. `buffers` lists its buffers in order of set and binding.
    pub fn dispatch(&self, kernel: &Kernel, buffers: &[&Arc<Buffer>], push: &[u8], groups: u32) -> Submission {
        let mut rest = buffers;
        let sets = kernel.source().sets.iter().map(|shape| {
            let (own, others) = rest.split_at(shape.bindings.len());
            rest = others;
            DescriptorSet::new(&self.context, "test", shape, own).expect("a set")
        });
        let sets: Vec<DescriptorSet> = sets.collect();
        let sets: Vec<_> = sets.iter().collect();
        let name = kernel.name();
        self.context.submit(name, |recorder| recorder.dispatch(kernel, &sets, push, [groups, 1, 1])).expect("done")
    }

    /// Dispatches a kernel. `named` holds buffers by the names of their bindings; bindings without one get a buffer that nothing reads.
    pub fn dispatch_named(&self, kernel: &Kernel, named: &[(&str, &Arc<Buffer>)], push: &[u8], groups: u32) {
        let set = |shape: &'static SetShape| {
            let buffers = shape.bindings.iter().map(|binding| {
                let own = named.iter().find(|(name, _)| *name == binding.name);
                own.map_or_else(|| self.buffer("unused", 1024, kind(binding.kind)), |(_, buffer)| Arc::clone(buffer))
            });
            let buffers: Vec<_> = buffers.collect();
            DescriptorSet::new(&self.context, "test", shape, &buffers.iter().collect::<Vec<_>>()).expect("a set")
        };
        let sets: Vec<_> = kernel.source().sets.iter().map(set).collect();
        let sets: Vec<_> = sets.iter().collect();
        let name = kernel.name();
        self.context.submit(name, |recorder| recorder.dispatch(kernel, &sets, push, [groups, 1, 1])).expect("done");
    }

    /// Builds a kernel of the renderer and dispatches it like [`Device::dispatch_named`].
    pub fn dispatch_renderers(
        &self,
        source: &KernelSource,
        variant: &Variant,
        named: &[(&str, &Arc<Buffer>)],
        push: &[u8],
        groups: u32,
    ) {
        self.dispatch_named(&self.kernel(source, variant), named, push, groups);
    }

    /// Outputs of a kernel for all inputs. The kernel has one input buffer and one output buffer.
    pub fn map<I: Pod, O: Pod>(&self, source: &KernelSource, variant: &Variant, inputs: &[I]) -> Vec<O> {
        self.map_with(source, variant, inputs, &[])
    }

    /// Outputs of a kernel for all inputs. The kernel reads more buffers besides its inputs.
    pub fn map_with<I: Pod, O: Pod>(
        &self,
        source: &KernelSource,
        variant: &Variant,
        inputs: &[I],
        more: &[&Arc<Buffer>],
    ) -> Vec<O> {
        let groups = inputs.len().div_ceil(GROUP as usize);
        let padded = groups * GROUP as usize;
        let input = self.storage("inputs", padded * size_of::<I>());
        input.upload(0, inputs).expect("uploaded");
        let output = self.storage("outputs", padded * size_of::<O>());
        let buffers: Vec<_> = [&input, &output].into_iter().chain(more.iter().copied()).collect();
        self.dispatch(&self.kernel(source, variant), &buffers, &[], groups as u32);
        output.read(0, inputs.len()).expect("read")
    }
}

fn kind(binding: BindingKind) -> BufferKind {
    match binding {
        BindingKind::StorageBuffer => BufferKind::Storage,
        BindingKind::UniformBuffer => BufferKind::Uniform,
        BindingKind::TexelBufferFloat => BufferKind::TexelFloat,
        BindingKind::TexelBufferUint => BufferKind::TexelUint,
        BindingKind::AccelerationStructure => BufferKind::AccelerationStructure,
    }
}

impl Default for Device {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let messages = self.context.validation_messages();
        if messages.is_empty() && Arc::strong_count(&self.context) == 1 {
            IDLE.lock().unwrap_or_else(PoisonError::into_inner).push(Arc::clone(&self.context));
        }
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "{messages:#?}");
        }
    }
}

/// Grids of a single cell.
pub struct Cell {
    pub radiance: Arc<Buffer>,
    pub bin_ends: Arc<Buffer>,
    pub nodes: Arc<Buffer>,
    pub entries: Arc<Buffer>,
    pub integrals: Arc<Buffer>,
    pub cosine_nodes: Arc<Buffer>,
    scene: Arc<Buffer>,
    normalize: Kernel,
    normals: u32,
    bins: u32,
}

/// Number of words per learned share: `glsl/include/guide/samplers/bsdf_share.glsl`.
const SHARE_WORDS: u32 = 4;

impl Cell {
    /// Cell without content.
    pub fn new(device: &Device, variant: &Variant) -> Self {
        Self::normalized_by(device, variant, &test::NORMALIZE_CELL)
    }

    /// Cell without content, whose normalizers another kernel fills.
    pub fn normalized_by(device: &Device, variant: &Variant, normalize: &KernelSource) -> Self {
        let map = if variant.map == MAP_CYLINDRICAL { DirectionMap::Cylindrical } else { DirectionMap::EqualArea };
        let (directions, normals) = (variant.direction_resolution, variant.normal_resolution);
        let entries = (normals * normals) as usize * size_of::<NormalizationEntry>();
        let integrals = cosine_integrals(map, directions, normals);
        let is_product = variant.sampler == SAMPLER_PRODUCT;
        let trees = if is_product { cosine_trees(&integrals, directions, normals) } else { vec![Node::default()] };
        let scene = device.buffer("scene", size_of::<SceneConstants>(), BufferKind::Uniform);
        scene.upload(0, &[SceneConstants { cell_count: 1, ..SceneConstants::zeroed() }]).expect("uploaded");
        Self {
            scene,
            // The shares lie behind the bins.
            radiance: device
                .storage("radiance", (directions * directions + 2 * SHARE_WORDS) as usize * size_of::<f32>()),
            bin_ends: device.storage("bin ends", (directions * directions) as usize * size_of::<u32>()),
            nodes: device.storage("nodes", nodes_per_tree(directions) as usize * size_of::<Node>()),
            entries: device.storage("entries", entries),
            integrals: device.uploaded("integrals", &integrals),
            cosine_nodes: device.uploaded("cosine nodes", &trees),
            normalize: device.kernel(normalize, variant),
            normals,
            bins: directions * directions,
        }
    }

    /// Sets the cell's learned shares: of diffuse lobes, and of scattering functions that are guided as a whole.
    /// Variants read them if `learns_share` is true.
    pub fn set_shares(&self, [of_lobes, of_wholes]: [f32; 2]) {
        let words = [of_lobes, 0.0, 0.0, 0.0, of_wholes, 0.0, 0.0, 0.0];
        self.radiance.upload(u64::from(self.bins) * size_of::<f32>() as u64, &words).expect("uploaded");
    }

    /// Buffers of the cell by the names of their bindings, and `out` by the name of its own.
    pub fn named<'a>(&'a self, out: (&'a str, &'a Arc<Buffer>)) -> [(&'a str, &'a Arc<Buffer>); 9] {
        [
            out,
            ("Scene", &self.scene),
            ("RadianceTable", &self.radiance),
            ("BinEnds", &self.bin_ends),
            ("RadianceNodes", &self.nodes),
            ("NormalizationTable", &self.entries),
            ("CosineIntegrals", &self.integrals),
            ("CosineNodes", &self.cosine_nodes),
            ("cosine_nodes", &self.cosine_nodes),
        ]
    }

    /// Sets the cell's radiance and has the device fill all normalizers.
    pub fn fill(&self, device: &Device, radiance: &[f32]) {
        self.radiance.upload(0, radiance).expect("uploaded");
        let buffers = [&self.radiance, &self.bin_ends, &self.nodes, &self.entries, &self.integrals];
        device.dispatch(&self.normalize, &buffers, &[], 4);
    }

    pub fn entries(&self) -> Vec<NormalizationEntry> {
        self.entries.read(0, (self.normals * self.normals) as usize).expect("read")
    }

    pub fn set_entry(&self, normal_bin: u32, entry: NormalizationEntry) {
        let offset = u64::from(normal_bin) * size_of::<NormalizationEntry>() as u64;
        self.entries.upload(offset, &[entry]).expect("uploaded");
    }
}
