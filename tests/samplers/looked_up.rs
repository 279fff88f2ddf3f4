//! Textures looked up by the kernel `textures`.

use bytemuck::{Pod, Zeroable};
use lodestar::encode::textures::PackedTextures;
use lodestar::generated::kernels::{Variant, test};
use lodestar::gpu::BufferKind;
use lodestar::scene::texture::{Image, Texture};
use support::device::{Device, GROUP};

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct TextureInput {
    pub index: u32,
    pub uv: [f32; 2],
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub shading_normal: [f32; 3],
    pub incoming: [f32; 3],
    pub dp_du: [f32; 3],
    pub dp_dv: [f32; 3],
}

impl TextureInput {
    pub fn new(index: u32, uv: [f32; 2]) -> Self {
        Self { index, uv, ..Zeroable::zeroed() }
    }
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct TextureOutput {
    pub color: [f32; 4],
    pub gradient: [f32; 2],
}

/// Answers of the kernel. Its variant contains only the features that the textures need.
pub fn look_up(textures: &[Texture], images: &[Image], inputs: &[TextureInput]) -> Vec<TextureOutput> {
    look_up_after(textures, images, inputs, Vec::new())
}

pub fn look_up_after(
    textures: &[Texture],
    images: &[Image],
    inputs: &[TextureInput],
    tables: Vec<u32>,
) -> Vec<TextureOutput> {
    let device = Device::new();
    let packed = PackedTextures::new(textures, images, &[], tables).0;
    let pages = packed.words.pages();
    let variant = Variant {
        texture_kinds: packed.kinds,
        program_operations: packed.operations as u32,
        program_later_operations: (packed.operations >> 32) as u32,
        texel_pages: pages.len() as u32,
        ..Variant::default()
    };
    let buffer = |name: &str, bytes: &[u8], kind| {
        let buffer = device.buffer(name, bytes.len(), kind);
        buffer.upload(0, bytes).expect("uploaded");
        buffer
    };
    let groups = inputs.len().div_ceil(GROUP as usize);
    let input = device.storage("inputs", groups * GROUP as usize * size_of::<TextureInput>());
    input.upload(0, inputs).expect("uploaded");
    let output = device.storage("outputs", groups * GROUP as usize * size_of::<TextureOutput>());
    let records = buffer("textures", bytemuck::cast_slice(&packed.records), BufferKind::TexelUint);
    let word_buffers: Vec<_> =
        pages.iter().map(|page| buffer("words", bytemuck::cast_slice(page), BufferKind::TexelUint1)).collect();
    let names = ["texel_words", "texel_words1", "texel_words2", "texel_words3"];
    let mut named = vec![("TextureInputs", &input), ("TextureOutputs", &output), ("textures", &records)];
    named.extend(names.into_iter().zip(&word_buffers));
    device.dispatch_renderers(&test::TEXTURES, &variant, &named, &[], groups as u32);
    output.read(0, inputs.len()).expect("read")
}
