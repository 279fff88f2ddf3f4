//! Materials as the kernels read them (`glsl/include/bsdf/material.glsl` and `bsdf/parameters.glsl`).

use glam::Vec3;

use super::{media, volumes};
use crate::generated::constants;
use crate::generated::layout::MaterialRecord;
use crate::scene::bsdf::{Bsdf, Material, MaterialKind, Relief, SurfaceMaterial};
use crate::scene::parameter::Value;
use crate::scene::{Scene, Textured};

/// Record of a material.
pub(crate) fn record(material: &Material) -> MaterialRecord {
    let mut record = match &material.kind {
        MaterialKind::Surface(surface) => surface_record(surface),
        MaterialKind::Sides { front, back } => {
            choice(constants::MATERIAL_SIDES, [*front, *back], Textured::constant(0.0))
        }
        MaterialKind::Blend { weight, materials } => choice(constants::MATERIAL_BLEND, *materials, *weight),
    };
    if let Some(boundary) = &material.boundary {
        record.kind_and_flags |= constants::MATERIAL_BOUNDARY;
        record.media = media::word(boundary);
    }
    record
}

/// Bits `1 << kind` of all kinds of material in the scene, and of phase functions.
pub(crate) fn kinds(scene: &Scene) -> u32 {
    let phase = if scene.media.all.is_empty() { 0 } else { 1 << constants::BSDF_PHASE };
    scene
        .materials
        .iter()
        .fold(phase, |bits, material| bits | 1 << (record(material).kind_and_flags & constants::MATERIAL_KIND_MASK))
}

/// Records of all materials of a scene, and then of its media. The record of a choice knows what its parts let through.
pub(crate) fn records(scene: &Scene) -> Vec<MaterialRecord> {
    let materials = &scene.materials;
    let mut records: Vec<_> = materials.iter().map(record).collect();
    // Each round reaches one level of nesting more.
    for _ in 0..constants::MAX_CHOICES {
        for (at, material) in materials.iter().enumerate() {
            let parts = match &material.kind {
                MaterialKind::Surface(_) => continue,
                MaterialKind::Sides { front, back } => [*front, *back],
                MaterialKind::Blend { materials, .. } => *materials,
            };
            let flags = parts.iter().fold(0, |flags, &part| flags | records[part as usize].kind_and_flags);
            records[at].kind_and_flags |= flags & (constants::MATERIAL_HOLES | constants::MATERIAL_LETS_THROUGH);
        }
    }
    let volumes = volumes::numbers(&scene.media);
    records.extend(scene.media.all.iter().zip(volumes).map(|(medium, volumes)| media::record(medium, volumes)));
    records
}

/// `FEATURE_*` bits of the features that the scene uses.
pub(crate) fn features(scene: &Scene) -> u32 {
    let surfaces = scene.materials.iter().filter_map(|material| match &material.kind {
        MaterialKind::Surface(surface) => Some(surface),
        _ => None,
    });
    let mut features = surfaces.fold(0, |bits, surface| bits | surface_features(surface));
    if scene.materials.iter().any(|material| record(material).links[0][0] != constants::NONE) {
        features |= constants::FEATURE_TEXTURES;
    }
    let pictures = scene.delta_emitters.iter().map(|emitter| emitter.kind.texture());
    if scene.emitters.iter().map(|emitter| emitter.radiance.texture).chain(pictures).any(|texture| texture.is_some()) {
        features |= constants::FEATURE_TEXTURED_EMITTERS;
    }
    features |= if scene.emitters.iter().any(|emitter| emitter.cone.is_some()) { constants::FEATURE_CONES } else { 0 };
    let media = &scene.media.all;
    features |= if media.iter().any(|medium| medium.volumes.is_some()) { constants::FEATURE_VOLUMES } else { 0 };
    features |= if media.iter().any(|medium| medium.emission != Vec3::ZERO) { constants::FEATURE_GLOW } else { 0 };
    features
}

/// Bits `1 << parameter` of all parameters that a texture multiplies, and the largest number of textures of one
/// material.
pub(crate) fn textured_parameters(scene: &Scene) -> (u32, u32) {
    let links = scene.materials.iter().map(|material| record(material).links.concat());
    links.fold((0, 0), |(bits, most), links| {
        let links: Vec<u32> = links.into_iter().filter(|&link| link != constants::NONE).collect();
        (
            links.iter().fold(bits, |bits, link| bits | 1 << (link >> constants::LINK_PARAMETER_SHIFT)),
            most.max(links.len() as u32),
        )
    })
}

fn surface_features(surface: &SurfaceMaterial) -> u32 {
    let opacity = surface.opacity != Textured::constant(1.0);
    let relief = match surface.relief {
        Some(Relief::Bump { .. }) => constants::FEATURE_BUMP | constants::FEATURE_TANGENTS,
        Some(Relief::NormalMap { .. }) => constants::FEATURE_NORMAL_MAP | constants::FEATURE_TANGENTS,
        None => 0,
    };
    let flags = surface_record(surface).kind_and_flags;
    let has_facets = constants::KINDS_WITH_FACETS >> (flags & constants::MATERIAL_KIND_MASK) & 1 != 0;
    let bit = |used: bool, feature: u32| if used { feature } else { 0 };
    bit(opacity, constants::FEATURE_OPACITY)
        | relief
        | bit(surface.relief_outside, constants::FEATURE_RELIEF_OUTSIDE)
        | bit(flags & constants::MATERIAL_UNSCALED != 0, constants::FEATURE_UNSCALED)
        | bit(flags & constants::MATERIAL_RELIEF_UNSHADOWED != 0, constants::FEATURE_RELIEF_UNSHADOWED)
        | bit(flags & constants::MATERIAL_RELIEF_RAISED != 0, constants::FEATURE_RELIEF_RAISED)
        | bit(surface.coating.is_some(), constants::FEATURE_COATING)
        | bit(surface.bsdf.is_anisotropic(), constants::FEATURE_TANGENTS)
        | bit(has_facets && flags & constants::MATERIAL_GGX == 0, constants::FEATURE_BECKMANN)
        | bit(flags & constants::MATERIAL_SMOOTH_BASE != 0, constants::FEATURE_SMOOTH_BASE)
        | bit(flags & constants::MATERIAL_WEIGHTED_BASE != 0, constants::FEATURE_WEIGHTED_BASE)
        | bit(flags & constants::MATERIAL_ENERGY_PRESERVING != 0, constants::FEATURE_ENERGY_PRESERVING)
        | bit(surface.sheen.is_some(), constants::FEATURE_SHEEN)
        | bit(surface.film.is_some(), constants::FEATURE_FILM)
}

/// Record that starts empty and takes parameters one by one.
struct Writer {
    record: MaterialRecord,
    link_count: usize,
}

impl Writer {
    fn new(kind: u32) -> Self {
        let record = MaterialRecord {
            kind_and_flags: kind,
            material1_or_relief: constants::NONE,
            links: [[constants::NONE; 4]; 2],
            ..bytemuck::Zeroable::zeroed()
        };
        Self { record, link_count: 0 }
    }

    fn flag(&mut self, flag: u32, set: bool) {
        self.record.kind_and_flags |= if set { flag } else { 0 };
    }

    fn color(&mut self, parameter: u32, color: &Textured<Vec3>) {
        let [red, green, blue] = color.value.into();
        self.record.colors[(parameter - constants::PARAMETER_COLOR0) as usize][..3]
            .copy_from_slice(&[red, green, blue]);
        self.link(parameter, color.texture);
    }

    fn scalar(&mut self, parameter: u32, scalar: &Textured<f32>) {
        *scalar_mut(&mut self.record, parameter) = scalar.value;
        self.link(parameter, scalar.texture);
    }

    /// Links a parameter to a texture. The loader refuses materials with more textures than there are links.
    fn link(&mut self, parameter: u32, texture: Option<u32>) {
        if let Some(texture) = texture {
            self.record.links[self.link_count / 4][self.link_count % 4] =
                parameter << constants::LINK_PARAMETER_SHIFT | texture;
            self.link_count += 1;
        }
    }
}

/// Scalar parameter of a record.
pub(crate) fn scalar_mut(record: &mut MaterialRecord, parameter: u32) -> &mut f32 {
    let index = (parameter - constants::PARAMETER_SCALAR0) as usize;
    &mut record.scalars[index / 4][index % 4]
}

fn choice(kind: u32, materials: [u32; 2], weight: Textured<f32>) -> MaterialRecord {
    let mut writer = Writer::new(kind);
    writer.record.material0 = materials[0];
    writer.record.material1_or_relief = materials[1];
    writer.scalar(constants::MIXTURE_SECOND_SHARE, &weight);
    writer.record
}

fn surface_record(surface: &SurfaceMaterial) -> MaterialRecord {
    let mut writer = Writer::new(surface.bsdf.kind_and_flags());
    writer.flag(constants::MATERIAL_TWO_SIDED, surface.two_sided);
    writer.flag(constants::MATERIAL_RELIEF_OUTSIDE, surface.relief_outside);
    writer.flag(constants::MATERIAL_RELIEF_UNSHADOWED, !surface.relief_rules.shadows);
    writer.flag(constants::MATERIAL_RELIEF_RAISED, surface.relief_rules.raises);
    writer.flag(constants::MATERIAL_UNSCALED, !surface.scales_radiance);
    writer.scalar(constants::MIXTURE_OPACITY, &surface.opacity);
    let has_holes = surface.opacity != Textured::constant(1.0);
    writer.flag(constants::MATERIAL_HOLES, has_holes);
    writer.flag(constants::MATERIAL_LETS_THROUGH, has_holes || matches!(surface.bsdf, Bsdf::ThinDielectric { .. }));
    let is_plain = !has_holes && surface.coating.is_none() && surface.sheen.is_none() && surface.film.is_none();
    writer.flag(constants::MATERIAL_REFRACTS, is_plain && matches!(surface.bsdf, Bsdf::Dielectric { .. }));
    surface.bsdf.clone().visit(&mut |parameter, value| match value {
        Value::Color(color) => writer.color(parameter, color),
        Value::Scalar(scalar) => writer.scalar(parameter, scalar),
        Value::Triple(triple) => writer.color(parameter, &Textured::constant(triple)),
        Value::Number(number) => writer.scalar(parameter, &Textured::constant(number)),
        Value::Flag(set) => writer.flag(parameter, set),
    });
    match surface.relief {
        Some(Relief::Bump { texture, scale }) => {
            writer.flag(constants::MATERIAL_BUMP, true);
            (writer.record.material1_or_relief, writer.record.relief_scale) = (texture, scale);
        }
        Some(Relief::NormalMap { texture }) => {
            writer.flag(constants::MATERIAL_NORMAL_MAP, true);
            writer.record.material1_or_relief = texture;
        }
        None => {}
    }
    if let Some(coating) = &surface.coating {
        writer.flag(constants::MATERIAL_COATED, true);
        writer.record.optical_thickness = coating.optical_thickness.into();
        writer.record.coating_eta = coating.eta;
        writer.record.coating_specular = coating.specular_reflectance.into();
    }
    if let Some(sheen) = surface.sheen.as_deref() {
        writer.flag(constants::MATERIAL_SHEEN, true);
        writer.record.optical_thickness = sheen.reflectance.value.into();
        writer.link(constants::PARAMETER_SHEEN_REFLECTANCE, sheen.reflectance.texture);
        writer.record.coating_eta = sheen.roughness.value;
        writer.link(constants::PARAMETER_SHEEN_ROUGHNESS, sheen.roughness.texture);
    }
    if let Some(film) = surface.film {
        writer.record.colors[0][3] = film.thickness.value;
        writer.link(constants::PARAMETER_FILM_THICKNESS, film.thickness.texture);
        writer.record.colors[1][3] = film.eta;
    }
    writer.record
}
