//! Samples of a scene's lights, drawn on the device.

use std::path::Path;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use lodestar::encode::bvh::Bvh;
use lodestar::encode::cosine_trees::{Node, nodes_per_tree};
use lodestar::encode::lights::{Lights, group_tree};
use lodestar::generated::kernels::{FEATURE_CONES, Variant, test};
use lodestar::generated::layout::SceneConstants;
use lodestar::gpu::BufferKind;
use lodestar::scene::{AreaEmitter, LoadOptions, Primitive, Scene, Textured, load};
use support::device::{Device, GROUP};

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct LightInput {
    pub from: [f32; 3],
    pub direction: [f32; 3],
}

/// Light that a ray hits: its radiance and density.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Met {
    pub radiance: [f32; 3],
    pub pdf: f32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct LightOutput {
    pub wi: [f32; 3],
    pub target: [f32; 3],
    pub radiance: [f32; 3],
    pub pdf: f32,
    pub infinite: u32,
    pub delta: u32,
    pub along_wi: Met,
    pub along_direction: Met,
}

impl LightOutput {
    pub fn wi(&self) -> DVec3 {
        d3(self.wi)
    }
}

pub fn d3(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

/// Scene with a sensor and nothing else.
pub fn empty_scene() -> Scene {
    parse("<scene version=\"3.0.0\"><sensor type=\"perspective\"/></scene>")
}

/// Scene parsed from text. The files of `tests/data/emitters` lie beside it.
pub fn parse(xml: &str) -> Scene {
    let folder = tempfile::tempdir().expect("a folder");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/emitters/map.exr");
    std::fs::copy(data, folder.path().join("map.exr")).expect("a copy");
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, xml).expect("written");
    let scene = load(&path, &LoadOptions::default()).expect("a scene");
    // Some tests add their lights later.
    let is_expected = |warning: &String| warning.contains("the scene has no light");
    assert!(scene.warnings.iter().all(is_expected), "{:?}", scene.warnings);
    scene
}

/// Scene of emitting primitives, each with its radiance.
pub fn emitting(primitives: &[(Primitive, f32)]) -> Scene {
    let mut scene = empty_scene();
    for &(primitive, radiance) in primitives {
        let emitter = Some(scene.emitters.len() as u32);
        scene.primitives.push(Primitive { emitter, ..primitive });
        scene.emitters.push(AreaEmitter::new(Textured::constant(Vec3::splat(radiance))));
    }
    scene
}

/// One sample for each input, with lights drawn in proportion to their power.
pub fn draw(scene: &Scene, inputs: &[LightInput], seed: u32) -> Vec<LightOutput> {
    draw_selected(scene, inputs, seed, None)
}

/// Function from the power of each group of lights to the weights of the groups.
pub type Weights = fn(&[f32]) -> Vec<f32>;

/// One sample for each input. With a `selection`, the cell draws groups of lights by these weights; they begin with those that
/// it gets: the power of each group.
pub fn draw_selected(scene: &Scene, inputs: &[LightInput], seed: u32, selection: Option<Weights>) -> Vec<LightOutput> {
    assert!((inputs.len() as u32).is_multiple_of(GROUP));
    let device = Device::new();
    let bvh = Bvh::of_scene(scene);
    let lights = Lights::new(scene, &bvh, selection.is_some());
    let buffer = |name: &str, bytes: &[u8], kind| {
        let buffer = device.buffer(name, bytes.len(), kind);
        buffer.upload(0, bytes).expect("uploaded");
        buffer
    };
    let mut constants = SceneConstants::zeroed();
    lights.write_constants(&mut constants);
    constants.cell_count = 1;
    // The group tree follows the cell's tree of radiance.
    let mut trees = vec![Node::default(); nodes_per_tree(Variant::default().direction_resolution) as usize];
    trees.extend(selection.map(|weights| group_tree(&weights(&lights.group_powers()))).unwrap_or_default());
    let trees = buffer("trees", bytemuck::cast_slice(&trees), BufferKind::TexelUint);
    let constants = buffer("scene", bytemuck::bytes_of(&constants), BufferKind::Uniform);
    let emitters = buffer("emitters", bytemuck::cast_slice(&lights.texels()), BufferKind::TexelUint);
    let nodes = buffer("nodes", bytemuck::cast_slice(&bvh.nodes), BufferKind::TexelUint);
    let records = buffer("primitives", bytemuck::cast_slice(&bvh.primitives), BufferKind::TexelUint);
    let attributes = buffer("attributes", bytemuck::cast_slice(&bvh.attributes), BufferKind::TexelUint);
    let input = device.uploaded("inputs", inputs);
    let output = device.storage("outputs", size_of::<LightOutput>() * inputs.len());
    let variant = Variant {
        has_spheres: bvh.has_spheres(),
        has_facing_disks: bvh.has_facing_disks(),
        surface_features: if scene.emitters.iter().any(|e| e.cone.is_some()) { FEATURE_CONES } else { 0 },
        has_front_only: bvh.has_front_only(),
        stack_size: bvh.depth,
        nee: true,
        light_kinds: lights.kinds(),
        environment: lights.environment_kind(),
        light_groups: lights.group_count(),
        light_patches: lights.patches_per_side(),
        ..Variant::default()
    };
    let named = [
        ("Scene", &constants),
        ("emitters", &emitters),
        ("LightInputs", &input),
        ("LightOutputs", &output),
        ("radiance_node_texels", &trees),
        ("bvh_nodes", &nodes),
        ("bvh_primitives", &records),
        ("bvh_attributes", &attributes),
    ];
    let push = bytemuck::bytes_of(&seed);
    device.dispatch_renderers(&test::LIGHT, &variant, &named, push, inputs.len() as u32 / GROUP);
    output.read(0, inputs.len()).expect("read")
}

/// Samples of lights seen from one point.
pub fn draw_from(scene: &Scene, from: DVec3, count: usize, seed: u32) -> Vec<LightOutput> {
    draw(scene, &vec![LightInput { from: from.as_vec3().into(), direction: [0.0, 0.0, 1.0] }; count], seed)
}
