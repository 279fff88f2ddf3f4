//! Summary of a scene, as `lodestar info` tells it.

use super::bsdf::{Material, MaterialKind, SurfaceMaterial};
use super::emitter::EnvironmentKind;
use super::texel_pages::word_count;
use super::texture::{Pattern, Textured};
use super::{Primitive, PrimitiveShape, Scene};
use crate::generated::constants::{KINDS_WITH_DIFFUSE_LOBE, KINDS_WITH_GUIDED_PART, MATERIAL_KIND_MASK};
use crate::generated::layout::{AttributeRecord, KeyRecord, PrimitiveRecord};

/// Contents of a scene in short.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Summary {
    /// Name of the scene.
    pub name: String,
    /// Width of the film in pixels.
    pub width: u32,
    /// Height of the film in pixels.
    pub height: u32,
    /// Names of the cameras of the file in their order; `None` for one without a name.
    pub cameras: Vec<Option<String>>,
    /// Samples per pixel that the file asks for.
    pub sample_count: Option<u32>,
    /// Longest path in edges that the file asks for; -1 is unlimited.
    pub max_depth: Option<i32>,
    /// Number of triangles that are stored, copies of instances included.
    pub triangles: usize,
    /// Number of instances that are not copied.
    pub instances: usize,
    /// Number of primitives that rays can hit: those of each instance count.
    pub shown_primitives: u64,
    /// Bytes of the primitives and instances on a device, without their hierarchy.
    pub geometry_bytes: u64,
    /// Number of parallelograms; a cube has six.
    pub parallelograms: usize,
    /// Number of disks, those included that face what they light.
    pub disks: usize,
    /// Number of spheres.
    pub spheres: usize,
    /// Materials, parts of blends included.
    pub materials: Vec<MaterialSummary>,
    /// Lights.
    pub lights: LightSummary,
    /// Textures.
    pub textures: Vec<TextureSummary>,
    /// Images.
    pub images: Vec<ImageSummary>,
    /// Bytes of the images on a device.
    pub image_bytes: u64,
    /// Sentences about what was read but is not rendered exactly.
    pub warnings: Vec<String>,
}

/// Material of a scene.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct MaterialSummary {
    /// The material's `id`, or its plugin and line.
    pub name: String,
    /// Kind of scattering, or of choice between other materials.
    pub kind: &'static str,
    /// Which part a guide samples.
    pub guided: Guided,
}

/// Parts of a scattering function that a guide samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Guided {
    /// The diffuse lobe.
    DiffuseLobe,
    /// A share of all directions, with samplers that guide whole functions.
    Whole,
    /// The parts of a choice say it themselves.
    Parts,
    /// No part: all its directions are single ones, or lie below a coating, or nothing scatters.
    Nothing,
}

/// Lights of a scene.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct LightSummary {
    /// Number of primitives that emit.
    pub area: usize,
    /// Number of `point` emitters.
    pub point: usize,
    /// Number of `spot` emitters.
    pub spot: usize,
    /// Number of `projector` emitters.
    pub projector: usize,
    /// Number of `directional` emitters.
    pub directional: usize,
    /// Plugin of the environment.
    pub environment: Option<&'static str>,
}

/// Texture of a scene.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct TextureSummary {
    /// The texture's `id`, or its plugin and line.
    pub name: String,
    /// Name of the image; none for a checkerboard.
    pub image: Option<String>,
}

/// Image of a scene.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct ImageSummary {
    /// Name as the scene writes it.
    pub name: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Bytes on a device.
    pub bytes: u64,
}

/// Summarizes a scene.
pub fn summarize(scene: &Scene) -> Summary {
    let of_groups = scene.groups.iter().flat_map(|group| &group.primitives);
    let stored = scene.primitives.iter().chain(of_groups);
    let count = |shape| stored.clone().filter(|primitive| primitive.shape == shape).count();
    let record_bytes = size_of::<PrimitiveRecord>() + size_of::<AttributeRecord>();
    let deformations = scene.groups.iter().flat_map(|group| &group.deformations).chain(&scene.deformations);
    let key_bytes = deformations.map(|deformation| deformation.keys.len()).sum::<usize>() * size_of::<KeyRecord>();
    let bytes = |image| 4 * word_count(image);
    Summary {
        name: scene.name.clone(),
        width: scene.film.width,
        height: scene.film.height,
        cameras: scene.cameras.clone(),
        sample_count: scene.sample_count,
        max_depth: scene.integrator.max_depth,
        triangles: count(PrimitiveShape::Triangle),
        instances: scene.instances.len(),
        shown_primitives: scene.shown_primitives(),
        geometry_bytes: ((scene.stored_primitives() + scene.instances.len()) * record_bytes + key_bytes) as u64,
        parallelograms: count(PrimitiveShape::Parallelogram),
        disks: [PrimitiveShape::Disk, PrimitiveShape::FacingDisk].map(count).iter().sum(),
        spheres: count(PrimitiveShape::Sphere),
        materials: scene.materials.iter().map(material).collect(),
        lights: lights(scene),
        textures: scene
            .textures
            .iter()
            .map(|texture| TextureSummary {
                name: texture.name.clone(),
                image: match texture.pattern {
                    Pattern::Bitmap { image, .. } => Some(scene.images[image as usize].name.clone()),
                    Pattern::Checkerboard { .. } | Pattern::Program(_) => None,
                },
            })
            .collect(),
        images: scene
            .images
            .iter()
            .map(|image| ImageSummary {
                name: image.name.clone(),
                width: image.width,
                height: image.height,
                bytes: bytes(image),
            })
            .collect(),
        image_bytes: scene.images.iter().map(bytes).sum(),
        warnings: scene.warnings.clone(),
    }
}

fn lights(scene: &Scene) -> LightSummary {
    let lamps = |primitives: &[Primitive]| primitives.iter().filter(|primitive| primitive.emitter.is_some()).count();
    let of_groups: Vec<usize> = scene.groups.iter().map(|group| lamps(&group.primitives)).collect();
    let of_instances = scene.instances.iter().map(|instance| of_groups[instance.group as usize]);
    let count = |plugin| scene.delta_emitters.iter().filter(|emitter| emitter.kind.plugin() == plugin).count();
    LightSummary {
        area: lamps(&scene.primitives) + of_instances.sum::<usize>(),
        point: count("point"),
        spot: count("spot"),
        projector: count("projector"),
        directional: count("directional"),
        environment: scene.environment.map(|environment| match environment.kind {
            EnvironmentKind::Constant { .. } => "constant",
            EnvironmentKind::Map { .. } => "envmap",
        }),
    }
}

fn material(material: &Material) -> MaterialSummary {
    let (kind, guided) = match &material.kind {
        MaterialKind::Blend { .. } => ("blendbsdf", Guided::Parts),
        MaterialKind::Sides { .. } => ("twosided", Guided::Parts),
        MaterialKind::Surface(surface) => (surface.bsdf.plugin(), guided(surface)),
    };
    MaterialSummary { name: material.name.clone(), kind, guided }
}

/// Part of a surface that a guide samples. The kind's functions in `glsl/include/bsdf` tell it.
fn guided(surface: &SurfaceMaterial) -> Guided {
    let kind = 1 << (surface.bsdf.kind_and_flags() & MATERIAL_KIND_MASK);
    if surface.coating.is_some() || surface.opacity == Textured::constant(0.0) {
        Guided::Nothing
    } else if KINDS_WITH_GUIDED_PART & kind != 0 {
        Guided::Whole
    } else if KINDS_WITH_DIFFUSE_LOBE & kind != 0 {
        Guided::DiffuseLobe
    } else {
        Guided::Nothing
    }
}
