//! Materials as the kernels read them (`glsl/include/bsdf/material.glsl` and `bsdf/parameters.glsl`).

use glam::Vec3;

use crate::generated::constants;
use crate::generated::layout::MaterialRecord;
use crate::scene::bsdf::{
    Bsdf, Distribution, Material, MaterialKind, Microfacets, Relief, SurfaceMaterial, WardVariant,
};
use crate::scene::{Scene, Textured};

const OPACITY: usize = 3;

/// Record of a material.
pub(crate) fn record(material: &Material) -> MaterialRecord {
    match &material.kind {
        MaterialKind::Surface(surface) => surface_record(surface),
        MaterialKind::Sides { front, back } => {
            choice(constants::MATERIAL_SIDES, [*front, *back], Textured::constant(0.0))
        }
        MaterialKind::Blend { weight, materials } => choice(constants::MATERIAL_BLEND, *materials, *weight),
    }
}

/// Bits `1 << kind` of all kinds of material in the scene.
pub(crate) fn kinds(scene: &Scene) -> u32 {
    scene
        .materials
        .iter()
        .fold(0, |bits, material| bits | 1 << (record(material).kind_and_flags & constants::MATERIAL_KIND_MASK))
}

/// Records of all materials of a scene. The record of a choice knows what its parts let through.
pub(crate) fn records(materials: &[Material]) -> Vec<MaterialRecord> {
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
    let bit = |used: bool, feature: u32| if used { feature } else { 0 };
    bit(opacity, constants::FEATURE_OPACITY)
        | relief
        | bit(surface.relief_outside, constants::FEATURE_RELIEF_OUTSIDE)
        | bit(surface.coating.is_some(), constants::FEATURE_COATING)
        | bit(is_anisotropic(&surface.bsdf), constants::FEATURE_TANGENTS)
        | bit(has_beckmann_facets(&surface.bsdf), constants::FEATURE_BECKMANN)
        | bit(matches!(surface.bsdf, Bsdf::PolarizedPlastic { .. }), constants::FEATURE_SMOOTH_BASE)
}

fn has_beckmann_facets(bsdf: &Bsdf) -> bool {
    let distribution = match bsdf {
        Bsdf::RoughConductor { microfacets, .. }
        | Bsdf::RoughDielectric { microfacets, .. }
        | Bsdf::PolarizedPlastic { microfacets, .. } => microfacets.distribution,
        Bsdf::RoughPlastic { distribution, .. } => *distribution,
        _ => Distribution::Ggx,
    };
    distribution == Distribution::Beckmann
}

fn is_anisotropic(bsdf: &Bsdf) -> bool {
    match bsdf {
        Bsdf::RoughConductor { microfacets, .. }
        | Bsdf::RoughDielectric { microfacets, .. }
        | Bsdf::PolarizedPlastic { microfacets, .. } => microfacets.alpha_u != microfacets.alpha_v,
        Bsdf::Ward { alpha_u, alpha_v, .. } => alpha_u != alpha_v,
        Bsdf::Principled(principled) => principled.anisotropic != Textured::constant(0.0),
        Bsdf::PrincipledThin(principled) => principled.anisotropic != Textured::constant(0.0),
        _ => false,
    }
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

    fn color(&mut self, index: usize, color: &Textured<Vec3>) {
        self.record.colors[index] = color.value.extend(0.0).into();
        self.link(index as u32, color.texture);
    }

    fn scalar(&mut self, index: usize, scalar: &Textured<f32>) {
        self.record.scalars[index / 4][index % 4] = scalar.value;
        self.link(constants::PARAMETER_SCALAR0 + index as u32, scalar.texture);
    }

    fn number(&mut self, index: usize, value: f32) {
        self.scalar(index, &Textured::constant(value));
    }

    /// Links a parameter to a texture. The loader refuses materials with more textures than there are links.
    fn link(&mut self, parameter: u32, texture: Option<u32>) {
        if let Some(texture) = texture {
            self.record.links[self.link_count / 4][self.link_count % 4] =
                parameter << constants::LINK_PARAMETER_SHIFT | texture;
            self.link_count += 1;
        }
    }

    fn microfacets(&mut self, microfacets: &Microfacets) {
        self.flag(constants::MATERIAL_GGX, microfacets.distribution == Distribution::Ggx);
        self.scalar(0, &microfacets.alpha_u);
        self.scalar(1, &microfacets.alpha_v);
    }
}

fn choice(kind: u32, materials: [u32; 2], weight: Textured<f32>) -> MaterialRecord {
    let mut writer = Writer::new(kind);
    writer.record.material0 = materials[0];
    writer.record.material1_or_relief = materials[1];
    writer.scalar(0, &weight);
    writer.record
}

fn surface_record(surface: &SurfaceMaterial) -> MaterialRecord {
    let mut writer = Writer::new(kind(&surface.bsdf));
    writer.flag(constants::MATERIAL_TWO_SIDED, surface.two_sided);
    writer.flag(constants::MATERIAL_RELIEF_OUTSIDE, surface.relief_outside);
    writer.scalar(OPACITY, &surface.opacity);
    let has_holes = surface.opacity != Textured::constant(1.0);
    writer.flag(constants::MATERIAL_HOLES, has_holes);
    writer.flag(constants::MATERIAL_LETS_THROUGH, has_holes || matches!(surface.bsdf, Bsdf::ThinDielectric { .. }));
    write_bsdf(&mut writer, &surface.bsdf);
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
    if let Some(coating) = surface.coating {
        writer.flag(constants::MATERIAL_COATED, true);
        writer.record.optical_thickness = coating.optical_thickness.into();
        writer.record.coating_eta = coating.eta;
        writer.record.coating_specular = coating.specular_reflectance.into();
    }
    writer.record
}

fn kind(bsdf: &Bsdf) -> u32 {
    match bsdf {
        Bsdf::Diffuse { .. } => constants::BSDF_DIFFUSE,
        Bsdf::RoughDiffuse { .. } => constants::BSDF_ROUGH_DIFFUSE,
        Bsdf::Dielectric { .. } => constants::BSDF_DIELECTRIC,
        Bsdf::ThinDielectric { .. } => constants::BSDF_THIN_DIELECTRIC,
        Bsdf::RoughDielectric { .. } => constants::BSDF_ROUGH_DIELECTRIC,
        Bsdf::Conductor { .. } => constants::BSDF_CONDUCTOR,
        Bsdf::RoughConductor { .. } => constants::BSDF_ROUGH_CONDUCTOR,
        Bsdf::Plastic { .. } => constants::BSDF_PLASTIC,
        Bsdf::RoughPlastic { .. } | Bsdf::PolarizedPlastic { .. } => constants::BSDF_ROUGH_PLASTIC,
        Bsdf::Principled(_) => constants::BSDF_PRINCIPLED,
        Bsdf::PrincipledThin(_) => constants::BSDF_PRINCIPLED_THIN,
        Bsdf::Phong { .. } => constants::BSDF_PHONG,
        Bsdf::Ward { .. } => constants::BSDF_WARD,
    }
}

fn write_bsdf(writer: &mut Writer, bsdf: &Bsdf) {
    match bsdf {
        Bsdf::Diffuse { reflectance } => writer.color(0, reflectance),
        Bsdf::RoughDiffuse { reflectance, alpha, fast_approximation } => {
            writer.flag(constants::MATERIAL_FAST_APPROXIMATION, *fast_approximation);
            writer.color(0, reflectance);
            writer.scalar(0, alpha);
        }
        Bsdf::Dielectric { eta, specular_reflectance, specular_transmittance }
        | Bsdf::ThinDielectric { eta, specular_reflectance, specular_transmittance } => {
            write_dielectric(writer, *eta, specular_reflectance, specular_transmittance);
        }
        Bsdf::RoughDielectric { microfacets, eta, specular_reflectance, specular_transmittance } => {
            writer.microfacets(microfacets);
            write_dielectric(writer, *eta, specular_reflectance, specular_transmittance);
        }
        Bsdf::Conductor { eta, k, specular_reflectance } => write_conductor(writer, *eta, *k, specular_reflectance),
        Bsdf::RoughConductor { microfacets, eta, k, specular_reflectance } => {
            writer.microfacets(microfacets);
            write_conductor(writer, *eta, *k, specular_reflectance);
        }
        Bsdf::Plastic { eta, diffuse_reflectance, specular_reflectance, nonlinear } => {
            write_plastic(writer, *eta, diffuse_reflectance, specular_reflectance, *nonlinear);
        }
        Bsdf::RoughPlastic { distribution, alpha, eta, diffuse_reflectance, specular_reflectance, nonlinear } => {
            writer.flag(constants::MATERIAL_GGX, *distribution == Distribution::Ggx);
            writer.number(0, *alpha);
            writer.number(1, *alpha);
            write_plastic(writer, *eta, diffuse_reflectance, specular_reflectance, *nonlinear);
        }
        Bsdf::PolarizedPlastic { microfacets, eta, diffuse_reflectance, specular_reflectance } => {
            writer.microfacets(microfacets);
            writer.flag(constants::MATERIAL_SMOOTH_BASE, true);
            write_plastic(writer, *eta, diffuse_reflectance, specular_reflectance, false);
        }
        Bsdf::Phong { exponent, diffuse_reflectance, specular_reflectance } => {
            writer.scalar(0, exponent);
            writer.color(0, diffuse_reflectance);
            writer.color(1, specular_reflectance);
        }
        Bsdf::Ward { variant, alpha_u, alpha_v, diffuse_reflectance, specular_reflectance } => {
            writer.scalar(0, alpha_u);
            writer.scalar(1, alpha_v);
            writer.number(4, ward_model(*variant));
            writer.color(0, diffuse_reflectance);
            writer.color(1, specular_reflectance);
        }
        Bsdf::PrincipledThin(principled) => {
            writer.flag(constants::MATERIAL_GGX, true);
            writer.color(0, &principled.base_color);
            writer.scalar(0, &principled.roughness);
            writer.scalar(1, &principled.anisotropic);
            writer.number(2, principled.eta);
            writer.scalar(4, &principled.crossing);
            writer.scalar(5, &principled.spec_trans);
            writer.scalar(6, &principled.spec_tint);
            writer.scalar(7, &principled.sheen);
            writer.scalar(8, &principled.sheen_tint);
            writer.scalar(9, &principled.flatness);
        }
        Bsdf::Principled(principled) => {
            writer.flag(constants::MATERIAL_GGX, true);
            writer.color(0, &principled.base_color);
            writer.scalar(0, &principled.roughness);
            writer.scalar(1, &principled.anisotropic);
            writer.number(2, principled.eta);
            writer.scalar(4, &principled.metallic);
            writer.scalar(5, &principled.spec_trans);
            writer.scalar(6, &principled.spec_tint);
            writer.scalar(7, &principled.sheen);
            writer.scalar(8, &principled.sheen_tint);
            writer.scalar(9, &principled.flatness);
            writer.scalar(10, &principled.clearcoat);
            writer.scalar(11, &principled.clearcoat_gloss);
        }
    }
}

fn ward_model(variant: WardVariant) -> f32 {
    match variant {
        WardVariant::Balanced => constants::WARD_BALANCED,
        WardVariant::Ward => constants::WARD_ORIGINAL,
        WardVariant::Duer => constants::WARD_DUER,
    }
}

fn write_dielectric(writer: &mut Writer, eta: f32, reflectance: &Textured<Vec3>, transmittance: &Textured<Vec3>) {
    writer.color(0, reflectance);
    writer.color(1, transmittance);
    writer.number(2, eta);
}

fn write_conductor(writer: &mut Writer, eta: Vec3, k: Vec3, reflectance: &Textured<Vec3>) {
    writer.color(0, reflectance);
    writer.color(1, &Textured::constant(eta));
    writer.color(2, &Textured::constant(k));
}

fn write_plastic(writer: &mut Writer, eta: f32, diffuse: &Textured<Vec3>, specular: &Textured<Vec3>, nonlinear: bool) {
    writer.flag(constants::MATERIAL_NONLINEAR, nonlinear);
    writer.color(0, diffuse);
    writer.color(1, specular);
    writer.number(2, eta);
}
