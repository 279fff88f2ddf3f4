//! Surfaces of every kind, in the form of the device and in the form of their twins.

use std::f64::consts::PI;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use lodestar::generated::kernels::{
    BSDF_CONDUCTOR, BSDF_DIFFUSE, BSDF_PRINCIPLED, BSDF_PRINCIPLED_THIN, BSDF_ROUGH_DIFFUSE, FEATURE_BECKMANN,
    FEATURE_COATING, FEATURE_ENERGY_PRESERVING, FEATURE_FILM, FEATURE_SHEEN, FEATURE_SMOOTH_BASE,
    FEATURE_WEIGHTED_BASE, MATERIAL_COATED, MATERIAL_ENERGY_PRESERVING, MATERIAL_FAST_APPROXIMATION, MATERIAL_GGX,
    MATERIAL_SHEEN, Variant,
};

use crate::substances::{Substance, sheen_table, substances};
use crate::twins::coating::{Coating, coating_probability, eval_coating, pdf_coating};
use crate::twins::direction::pdf_cosine_hemisphere;
use crate::twins::film::Film;
use crate::twins::principled::{Principled, eval_bsdf_principled, pdf_bsdf_principled};
use crate::twins::principled_thin::{PrincipledThin, eval_bsdf_principled_thin, pdf_bsdf_principled_thin};
use crate::twins::rough_diffuse::{RoughDiffuse, eval_bsdf_rough_diffuse};
use crate::twins::sheen::Sheen;

/// Parameters on the device: `Bsdf` of `glsl/include/bsdf/parameters.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
pub struct DeviceBsdf {
    pub kind_and_flags: u32,
    colors: [[f32; 3]; 3],
    pub scalars: [f32; 12],
    optical_thickness: [f32; 3],
    coating_eta: f32,
    coating_specular: [f32; 3],
    sheen_reflectance: [f32; 3],
    sheen_roughness: f32,
    sheen_table: f32,
    /// The kernel finds the lobe.
    sheen_lobe: [f32; 9],
    /// Thickness and index of refraction.
    pub film: [f32; 2],
}

impl DeviceBsdf {
    pub fn new(kind_and_flags: u32, colors: [DVec3; 3]) -> Self {
        Self { kind_and_flags, colors: colors.map(floats), ..Self::default() }
    }
}

/// Scattering function of a surface, below the coating or the sheen if there is one.
#[derive(Debug, Clone)]
pub enum Base {
    Diffuse(DVec3),
    RoughDiffuse(RoughDiffuse),
    Principled(Principled),
    PrincipledThin(PrincipledThin),
    Substance(Substance),
    Mirror,
}

#[derive(Debug, Clone)]
pub struct Surface {
    pub name: String,
    pub base: Base,
    pub coating: Option<Coating>,
    pub sheen: Option<Sheen>,
}

/// Constants of a pipeline for all of these surfaces.
pub fn variant() -> Variant {
    let surface_features = FEATURE_COATING
        | FEATURE_SHEEN
        | FEATURE_FILM
        | FEATURE_BECKMANN
        | FEATURE_SMOOTH_BASE
        | FEATURE_WEIGHTED_BASE
        | FEATURE_ENERGY_PRESERVING;
    Variant { material_kinds: u32::MAX, surface_features, ..Variant::default() }
}

fn floats(v: DVec3) -> [f32; 3] {
    v.as_vec3().into()
}

impl Surface {
    /// Surface without a coating and a sheen.
    pub fn plain(name: impl Into<String>, base: Base) -> Self {
        Self { name: name.into(), base, coating: None, sheen: None }
    }

    /// Probability of the sheen's own lobe for light to the eye at `wo`.
    pub fn sheen_probability(&self, wo: DVec3) -> f64 {
        let below = if let Base::Diffuse(reflectance) = self.base { reflectance.max_element() } else { 1.0 };
        self.sheen.filter(|_| wo.z > 0.0).map_or(0.0, |sheen| sheen.probability(wo.z, below))
    }

    /// Whether light passes to the other side.
    pub fn transmits(&self) -> bool {
        match &self.base {
            Base::Principled(b) => b.spec_trans > 0.0,
            Base::PrincipledThin(_) => true,
            Base::Substance(b) => b.transmits(),
            _ => false,
        }
    }

    /// This surface without absorption.
    pub fn white(&self) -> Self {
        let mut white = self.clone();
        match &mut white.base {
            Base::Diffuse(reflectance) => *reflectance = DVec3::ONE,
            Base::RoughDiffuse(b) => b.reflectance = DVec3::ONE,
            Base::Principled(b) => b.base_color = DVec3::ONE,
            Base::PrincipledThin(b) => b.base_color = DVec3::ONE,
            Base::Substance(b) => *b = b.white(),
            Base::Mirror => {}
        }
        if let Some(c) = &mut white.coating {
            (c.optical_thickness, c.specular_reflectance) = (DVec3::ZERO, DVec3::ONE);
        }
        if let Some(sheen) = &mut white.sheen {
            sheen.reflectance = DVec3::ONE;
        }
        white
    }

    /// Allowed relative error of a value on the device: rounding of a facet's normal over its roughness.
    pub fn tolerance(&self) -> f64 {
        match &self.base {
            Base::Principled(b) if b.roughness < 0.1 => 5.0e-3,
            Base::PrincipledThin(b) if b.roughness < 0.1 => 5.0e-3,
            _ => 2.0e-3,
        }
    }

    pub fn device(&self) -> DeviceBsdf {
        let mut bsdf = match &self.base {
            Base::Diffuse(reflectance) => DeviceBsdf::new(BSDF_DIFFUSE, [*reflectance, DVec3::ZERO, DVec3::ZERO]),
            Base::RoughDiffuse(b) => device_rough_diffuse(b),
            Base::Principled(b) => device_principled(b),
            Base::PrincipledThin(b) => device_principled_thin(b),
            Base::Substance(b) => b.device(),
            Base::Mirror => DeviceBsdf {
                kind_and_flags: BSDF_CONDUCTOR,
                colors: [[1.0; 3], [0.0; 3], [0.0; 3]],
                ..DeviceBsdf::default()
            },
        };
        if let Some(c) = &self.coating {
            bsdf.kind_and_flags |= MATERIAL_COATED;
            bsdf.optical_thickness = floats(c.optical_thickness);
            bsdf.coating_eta = c.eta as f32;
            bsdf.coating_specular = floats(c.specular_reflectance);
        }
        if let Some(sheen) = &self.sheen {
            bsdf.kind_and_flags |= MATERIAL_SHEEN;
            bsdf.sheen_reflectance = floats(sheen.reflectance);
            bsdf.sheen_roughness = sheen.roughness as f32;
            bsdf.sheen_table = sheen_table() as f32;
        }
        bsdf
    }

    /// Value f |cos|, without lobes of a single direction.
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        match (&self.coating, &self.sheen) {
            (Some(c), _) => eval_coating(c, wo, wi, |wo, wi| self.base.eval(wo, wi)),
            (None, Some(sheen)) if wo.z > 0.0 => sheen.eval(wo, wi, self.base.eval(wo, wi)),
            _ => self.base.eval(wo, wi),
        }
    }

    /// Density, without lobes of a single direction.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        match (&self.coating, &self.sheen) {
            (Some(c), _) => pdf_coating(c, wo, wi, |wo, wi| self.base.pdf(wo, wi)),
            (None, Some(sheen)) if wo.z > 0.0 => {
                let share = self.sheen_probability(wo);
                (1.0 - share) * self.base.pdf(wo, wi) + share * sheen.density(wo, wi)
            }
            _ => self.base.pdf(wo, wi),
        }
    }

    /// Probability that a sample takes a lobe of a single direction.
    pub fn delta(&self, wo: DVec3) -> f64 {
        let layer = self.coating.map_or(0.0, |c| coating_probability(&c, wo));
        match &self.base {
            Base::Mirror => 1.0 - self.sheen_probability(wo),
            Base::Substance(b) => {
                let lobes = b.lobes(wo).iter().map(|lobe| lobe.probability).sum::<f64>();
                (1.0 - self.sheen_probability(wo)) * lobes
            }
            _ => layer,
        }
    }

    /// Index of refraction that bends transmitted light, interior over exterior.
    pub fn eta(&self) -> f64 {
        match &self.base {
            Base::Principled(b) => b.eta,
            Base::Substance(b) => b.bending(),
            _ => 1.0,
        }
    }
}

impl Base {
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        match self {
            Self::Diffuse(reflectance) if wo.z > 0.0 => *reflectance * (wi.z.max(0.0) / PI),
            Self::Diffuse(_) => DVec3::ZERO,
            Self::RoughDiffuse(b) => eval_bsdf_rough_diffuse(b, wo, wi),
            Self::Principled(b) => eval_bsdf_principled(b, wo, wi),
            Self::PrincipledThin(b) => eval_bsdf_principled_thin(b, wo, wi),
            Self::Substance(b) => b.eval(wo, wi),
            Self::Mirror => DVec3::ZERO,
        }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        match self {
            Self::RoughDiffuse(_) | Self::Diffuse(_) if wo.z > 0.0 => pdf_cosine_hemisphere(wi.z),
            Self::Principled(b) => pdf_bsdf_principled(b, wo, wi),
            Self::PrincipledThin(b) => pdf_bsdf_principled_thin(b, wo, wi),
            Self::Substance(b) => b.pdf(wo, wi),
            _ => 0.0,
        }
    }
}

fn device_rough_diffuse(b: &RoughDiffuse) -> DeviceBsdf {
    let fast = if b.fast_approximation { MATERIAL_FAST_APPROXIMATION } else { 0 };
    let flags = fast | if b.energy_preserving { MATERIAL_ENERGY_PRESERVING } else { 0 };
    let mut device = DeviceBsdf { kind_and_flags: BSDF_ROUGH_DIFFUSE | flags, ..DeviceBsdf::default() };
    device.colors[0] = floats(b.reflectance);
    device.scalars[0] = b.alpha as f32;
    device
}

fn device_principled(b: &Principled) -> DeviceBsdf {
    let scalars = [
        b.roughness,
        b.anisotropic,
        b.eta,
        1.0,
        b.metallic,
        b.spec_trans,
        b.spec_tint,
        b.sheen,
        b.sheen_tint,
        b.flatness,
        b.clearcoat,
        b.clearcoat_gloss,
    ];
    DeviceBsdf {
        kind_and_flags: BSDF_PRINCIPLED | MATERIAL_GGX,
        colors: [floats(b.base_color), [0.0; 3], [0.0; 3]],
        scalars: scalars.map(|x| x as f32),
        film: b.film.map_or([0.0; 2], |film| [film.thickness as f32, film.eta as f32]),
        ..DeviceBsdf::default()
    }
}

fn device_principled_thin(b: &PrincipledThin) -> DeviceBsdf {
    let scalars = [
        b.roughness,
        b.anisotropic,
        b.eta,
        1.0,
        0.5 * b.diff_trans,
        b.spec_trans,
        b.spec_tint,
        b.sheen,
        b.sheen_tint,
        b.flatness,
        0.0,
        0.0,
    ];
    DeviceBsdf {
        kind_and_flags: BSDF_PRINCIPLED_THIN | MATERIAL_GGX,
        colors: [floats(b.base_color), [0.0; 3], [0.0; 3]],
        scalars: scalars.map(|x| x as f32),
        ..DeviceBsdf::default()
    }
}

fn rough_diffuse(alpha: f64, fast_approximation: bool) -> (String, Base) {
    let b =
        RoughDiffuse { reflectance: DVec3::new(0.9, 0.5, 0.1), alpha, fast_approximation, energy_preserving: false };
    (format!("rough diffuse {alpha} {fast_approximation}"), Base::RoughDiffuse(b))
}

fn energy_preserving(alpha: f64) -> (String, Base) {
    let reflectance = DVec3::new(0.9, 0.5, 0.1);
    let b = RoughDiffuse { reflectance, alpha, fast_approximation: false, energy_preserving: true };
    (format!("energy-preserving diffuse {alpha}"), Base::RoughDiffuse(b))
}

/// Principled surface: a dielectric over a diffuse base.
const PRINCIPLED: Principled = Principled {
    base_color: DVec3::new(0.8, 0.5, 0.3),
    eta: 1.5,
    roughness: 0.5,
    anisotropic: 0.0,
    metallic: 0.0,
    spec_trans: 0.0,
    spec_tint: 0.0,
    sheen: 0.0,
    sheen_tint: 0.0,
    flatness: 0.0,
    clearcoat: 0.0,
    clearcoat_gloss: 0.0,
    film: None,
};

/// Principled surfaces at a roughness: a metal, a glass, and one with all lobes at once.
fn principled(roughness: f64) -> [(String, Base); 3] {
    let metal = Principled { roughness, metallic: 1.0, anisotropic: 0.7, ..PRINCIPLED };
    let glass = Principled { roughness, spec_trans: 1.0, eta: 1.4, ..PRINCIPLED };
    let all = Principled {
        roughness,
        anisotropic: 0.4,
        metallic: 0.3,
        spec_trans: 0.2,
        spec_tint: 0.6,
        sheen: 0.8,
        sheen_tint: 0.5,
        flatness: 0.4,
        clearcoat: 1.0,
        clearcoat_gloss: 0.3,
        ..PRINCIPLED
    };
    [(metal, "metal"), (glass, "glass"), (all, "all")]
        .map(|(b, name)| (format!("principled {roughness} {name}"), Base::Principled(b)))
}

/// Principled surfaces under films: a metal, a glass, a dielectric, and one with all lobes at once.
fn principled_films() -> [(String, Base); 4] {
    let film = |thickness: f64, eta: f64| Some(Film { thickness, eta });
    let metal = Principled { roughness: 0.4, metallic: 1.0, anisotropic: 0.5, film: film(280.0, 1.5), ..PRINCIPLED };
    let glass = Principled { roughness: 0.5, spec_trans: 1.0, eta: 1.4, film: film(500.0, 1.9), ..PRINCIPLED };
    // A quarter of a wave, which reflects seven times as much as the dielectric alone.
    let dielectric = Principled { film: film(62.0, 2.2), ..PRINCIPLED };
    let all =
        Principled { metallic: 0.3, spec_trans: 0.2, clearcoat: 1.0, sheen: 0.8, film: film(400.0, 2.3), ..PRINCIPLED };
    [(metal, "metal"), (glass, "glass"), (dielectric, "dielectric, all"), (all, "all")]
        .map(|(b, name)| (format!("film over principled {name}"), Base::Principled(b)))
}

/// Thin principled sheets at a roughness: one that is specular, one that is diffuse, and one with all lobes at once.
fn principled_thin(roughness: f64) -> [(String, Base); 3] {
    let plain = PrincipledThin {
        base_color: PRINCIPLED.base_color,
        eta: 1.4,
        roughness,
        anisotropic: 0.0,
        spec_trans: 1.0,
        spec_tint: 0.0,
        sheen: 0.0,
        sheen_tint: 0.0,
        flatness: 0.0,
        diff_trans: 0.0,
    };
    let diffuse = PrincipledThin { spec_trans: 0.0, diff_trans: 1.2, ..plain };
    let all = PrincipledThin {
        anisotropic: 0.6,
        spec_trans: 0.4,
        spec_tint: 0.5,
        sheen: 0.7,
        sheen_tint: 0.3,
        flatness: 0.6,
        diff_trans: 0.8,
        ..plain
    };
    [(plain, "specular"), (diffuse, "diffuse, all"), (all, "all")]
        .map(|(b, name)| (format!("principled thin {roughness} {name}"), Base::PrincipledThin(b)))
}

fn coated((name, base): (String, Base), eta: f64) -> Surface {
    let coating =
        Coating { eta, optical_thickness: DVec3::new(0.1, 0.3, 0.6), specular_reflectance: DVec3::splat(0.9) };
    Surface { name: format!("coated {name}"), base, coating: Some(coating), sheen: None }
}

/// Sheens over nothing, over a diffuse surface, over facets, over single directions, and over glass.
fn sheens() -> Vec<Surface> {
    let color = DVec3::new(0.3, 0.6, 0.2);
    let substance = |name: &str| {
        let (_, found) = substances().into_iter().find(|(known, _)| known == name).expect("a substance");
        Base::Substance(found)
    };
    let over = |name: &str, base, roughness: f64, reflectance| {
        let sheen = Some(Sheen { reflectance, roughness });
        Surface { sheen, ..Surface::plain(format!("sheen {roughness} over {name}"), base) }
    };
    vec![
        over("nothing", Base::Diffuse(DVec3::ZERO), 0.2, DVec3::ONE),
        over("nothing", Base::Diffuse(DVec3::ZERO), 1.0, DVec3::ONE),
        over("diffuse", Base::Diffuse(color), 0.45, DVec3::new(0.5, 0.9, 0.7)),
        over("diffuse", Base::Diffuse(color), 0.8, DVec3::ONE),
        over("rough diffuse", energy_preserving(0.5).1, 0.6, DVec3::splat(0.5)),
        over("metal", substance("rough conductor, GGX [0.5, 0.5]"), 0.3, DVec3::new(0.9, 0.6, 0.7)),
        over("mirror", Base::Mirror, 0.7, DVec3::new(0.9, 0.6, 0.7)),
        over("plastic", substance("weighted smooth plastic"), 0.5, DVec3::ONE),
        over("glass", substance("rough dielectric, GGX [0.5, 0.5]"), 0.5, DVec3::new(0.9, 0.6, 0.7)),
    ]
}

pub fn surfaces() -> Vec<Surface> {
    let rough = [(0.05, false), (0.3, false), (1.0, false), (0.5, true)];
    let uncoated = rough.map(|(alpha, fast)| rough_diffuse(alpha, fast)).into_iter();
    let uncoated = uncoated.chain([0.0, 0.3, 1.0].map(energy_preserving));
    let uncoated = uncoated.chain([0.05, 0.25, 0.5, 1.0].into_iter().flat_map(principled));
    let uncoated = uncoated.chain([0.05, 0.5, 1.0].into_iter().flat_map(principled_thin));
    let uncoated = uncoated.chain(principled_films());
    let [metal, ..] = principled(0.5);
    let coated =
        [coated(rough_diffuse(0.4, false), 1.5), coated(("mirror".into(), Base::Mirror), 1.3), coated(metal, 1.7)];
    let substances = substances().into_iter().map(|(name, b)| (name, Base::Substance(b)));
    let plain = uncoated.chain(substances).map(|(name, base)| Surface::plain(name, base));
    plain.chain(coated).chain(sheens()).collect()
}
