//! Metals, dielectrics, plastics, hair and the lobes of Phong and Ward, in the form of the device and in the form of their twins.

use std::sync::{Arc, Mutex};

use glam::DVec3;
use lodestar::encode::plastic_layer::{RoughLayer, fresnel_diffuse_reflectance};
use lodestar::encode::{measured, sheen};
use lodestar::generated::kernels::{
    BSDF_CONDUCTOR, BSDF_DIELECTRIC, BSDF_HAIR, BSDF_MEASURED, BSDF_PHONG, BSDF_PLASTIC, BSDF_ROUGH_CONDUCTOR,
    BSDF_ROUGH_DIELECTRIC, BSDF_ROUGH_PLASTIC, BSDF_THIN_DIELECTRIC, BSDF_WARD, MATERIAL_ENERGY_PRESERVING,
    MATERIAL_GGX, MATERIAL_NONLINEAR, MATERIAL_SMOOTH_BASE, MATERIAL_WEIGHTED_BASE, WARD_BALANCED, WARD_DUER,
    WARD_ORIGINAL,
};
use lodestar::math::microfacet::Microfacets;
use lodestar::scene::measured::Measured;

use crate::repository;
use crate::scattering_cases::DeviceBsdf;
use crate::twins::conductor::{Conductor, conductor_lobes, eval_bsdf_rough_conductor, pdf_reflection};
use crate::twins::delta::DeltaLobe;
use crate::twins::dielectric::{
    Dielectric, dielectric_lobes, eval_bsdf_rough_dielectric, pdf_bsdf_rough_dielectric, thin_dielectric_lobes,
};
use crate::twins::direction::pdf_cosine_hemisphere;
use crate::twins::film::Film;
use crate::twins::hair::{Hair, eval_bsdf_hair, pdf_bsdf_hair};
use crate::twins::measured::MeasuredSurface;
use crate::twins::phong::{Phong, eval_bsdf_phong, pdf_bsdf_phong};
use crate::twins::plastic::{Plastic, RoughSurface, eval_bsdf_plastic, pdf_bsdf_plastic, plastic_lobes};
use crate::twins::polarized_plastic::{PolarizedPlastic, eval_bsdf_polarized_plastic, pdf_bsdf_polarized_plastic};
use crate::twins::ward::{Ward, WardModel, eval_bsdf_ward, pdf_bsdf_ward};

/// Scattering function with its parameters.
#[derive(Debug, Clone)]
pub enum Substance {
    Conductor(Conductor),
    RoughConductor(Conductor, Microfacets),
    Dielectric(Dielectric),
    ThinDielectric(Dielectric),
    RoughDielectric(Dielectric, Microfacets),
    Plastic(Plastic),
    /// Rough plastic, with the address of its table.
    RoughPlastic(Plastic, u32),
    PolarizedPlastic(PolarizedPlastic),
    Phong(Phong),
    Ward(Ward),
    Hair(Hair),
    /// Measured material, with the address of its tables.
    Measured(Arc<MeasuredSurface>, u32),
}

/// Layers of the rough plastics so far, and the words of their tables and of the sheens'.
static TABLES: Mutex<Tables> = Mutex::new(Tables { sheen: None, layers: vec![], measured: vec![], words: vec![] });

struct Tables {
    sheen: Option<u32>,
    layers: Vec<(Microfacets, f64, RoughLayer, u32)>,
    measured: Vec<(&'static str, Arc<MeasuredSurface>, u32)>,
    words: Vec<u32>,
}

/// Address of the table of sheens.
pub fn sheen_table() -> u32 {
    let mut tables = TABLES.lock().expect("no test panics with it");
    let address = tables.words.len() as u32;
    if let Some(known) = tables.sheen {
        return known;
    }
    tables.words.extend(sheen::words());
    tables.sheen = Some(address);
    address
}

/// Measured material of a file in `tests/data/measured`.
pub fn measured_of(name: &'static str) -> Substance {
    let mut tables = TABLES.lock().expect("no test panics with it");
    if let Some((_, surface, address)) = tables.measured.iter().find(|known| known.0 == name) {
        return Substance::Measured(Arc::clone(surface), *address);
    }
    let bytes = std::fs::read(repository().join("tests/data/measured").join(name)).expect("the file");
    let surface = Arc::new(MeasuredSurface::new(Measured::read(&bytes).expect("a measured material")));
    let address = tables.words.len() as u32;
    tables.words.extend(measured::words(surface.tables()));
    tables.measured.push((name, Arc::clone(&surface), address));
    Substance::Measured(surface, address)
}

/// Words of all tables of rough plastics, of sheens and of measured materials so far.
pub fn table_words() -> Vec<u32> {
    TABLES.lock().expect("no test panics with it").words.clone()
}

fn layer(facets: Microfacets, eta: f64) -> (RoughLayer, u32) {
    let mut tables = TABLES.lock().expect("no test panics with it");
    if let Some((_, _, layer, address)) = tables.layers.iter().find(|known| (known.0, known.1) == (facets, eta)) {
        return (layer.clone(), *address);
    }
    let (layer, address) = (RoughLayer::new(&facets, eta), tables.words.len() as u32);
    tables.words.extend(layer.words());
    tables.layers.push((facets, eta, layer.clone(), address));
    (layer, address)
}

/// Plastic. It is rough if facets are given.
pub fn plastic(
    eta: f64,
    diffuse_reflectance: DVec3,
    specular_reflectance: DVec3,
    nonlinear: bool,
    facets: Option<Microfacets>,
) -> Substance {
    let means = [specular_reflectance, diffuse_reflectance].map(DVec3::element_sum);
    let b = Plastic {
        eta,
        diffuse_reflectance,
        specular_reflectance,
        nonlinear,
        internal_reflectance: fresnel_diffuse_reflectance(1.0 / eta),
        specular_sampling: means[0] / (means[0] + means[1]),
        rough: None,
        base_weight: None,
        base_roughness: 0.0,
        film: None,
    };
    let Some(facets) = facets else { return Substance::Plastic(b) };
    let (layer, address) = layer(facets, eta);
    let rough = Some(RoughSurface { facets, transmittance: layer.transmittance.to_vec() });
    Substance::RoughPlastic(Plastic { internal_reflectance: layer.internal_reflectance, rough, ..b }, address)
}

impl Substance {
    /// Whether light passes to the other side.
    pub fn transmits(&self) -> bool {
        matches!(self, Self::Dielectric(_) | Self::ThinDielectric(_) | Self::RoughDielectric(..) | Self::Hair(_))
    }

    /// This substance without absorption.
    pub fn white(&self) -> Self {
        let conductor = |b: &Conductor| Conductor {
            specular_reflectance: DVec3::ONE,
            eta: DVec3::ZERO,
            k: DVec3::ZERO,
            film: b.film,
        };
        let dielectric =
            |b: &Dielectric| Dielectric { specular_reflectance: DVec3::ONE, specular_transmittance: DVec3::ONE, ..*b };
        match self {
            Self::Conductor(b) => Self::Conductor(conductor(b)),
            Self::RoughConductor(b, facets) => Self::RoughConductor(conductor(b), *facets),
            Self::Dielectric(b) => Self::Dielectric(dielectric(b)),
            Self::ThinDielectric(b) => Self::ThinDielectric(dielectric(b)),
            Self::RoughDielectric(b, facets) => Self::RoughDielectric(dielectric(b), *facets),
            // A layer that takes nothing from the base reflects all light together with it.
            Self::Plastic(b) if b.base_weight.is_some() => Self::Plastic(Plastic {
                diffuse_reflectance: DVec3::ONE,
                specular_reflectance: DVec3::splat(0.5),
                base_weight: Some(0.5),
                ..b.clone()
            }),
            Self::Plastic(b) | Self::RoughPlastic(b, _) => {
                let facets = b.rough.as_ref().map(|rough| rough.facets);
                plastic(b.eta, DVec3::ONE, DVec3::ONE, b.nonlinear, facets)
            }
            Self::PolarizedPlastic(b) => Self::PolarizedPlastic(PolarizedPlastic {
                diffuse_reflectance: DVec3::ONE,
                specular_reflectance: DVec3::splat(if b.base_weight.is_some() { 0.5 } else { 1.0 }),
                base_weight: b.base_weight.map(|_| 0.5),
                ..*b
            }),
            // Both lobes together reflect all light.
            Self::Phong(b) => Self::Phong(Phong {
                diffuse_reflectance: DVec3::splat(0.5),
                specular_reflectance: DVec3::splat(0.5),
                ..*b
            }),
            Self::Ward(b) => Self::Ward(Ward {
                diffuse_reflectance: DVec3::splat(0.5),
                specular_reflectance: DVec3::splat(0.5),
                ..*b
            }),
            Self::Hair(b) => Self::Hair(Hair { sigma_a: DVec3::ZERO, ..*b }),
            // Its tables say what it absorbs.
            Self::Measured(b, address) => Self::Measured(Arc::clone(b), *address),
        }
    }

    /// Thin film over the surface.
    pub fn film(&self) -> Option<Film> {
        match self {
            Self::Conductor(b) | Self::RoughConductor(b, _) => b.film,
            Self::Dielectric(b) | Self::RoughDielectric(b, _) => b.film,
            Self::Plastic(b) => b.film,
            Self::PolarizedPlastic(b) => b.film,
            _ => None,
        }
    }

    pub fn facets(&self) -> Option<Microfacets> {
        match self {
            Self::RoughConductor(_, facets) | Self::RoughDielectric(_, facets) => Some(*facets),
            Self::RoughPlastic(b, _) => b.rough.as_ref().map(|rough| rough.facets),
            Self::PolarizedPlastic(b) => Some(b.facets),
            _ => None,
        }
    }

    /// Index of refraction that bends transmitted light, interior over exterior.
    pub fn bending(&self) -> f64 {
        match self {
            Self::Dielectric(b) | Self::RoughDielectric(b, _) => b.eta,
            _ => 1.0,
        }
    }

    /// Lobes of a single direction for light to the eye at `wo`.
    pub fn lobes(&self, wo: DVec3) -> Vec<DeltaLobe> {
        match self {
            Self::Conductor(b) => conductor_lobes(b, wo),
            Self::Dielectric(b) => dielectric_lobes(b, wo),
            Self::ThinDielectric(b) => thin_dielectric_lobes(b, wo),
            Self::Plastic(b) => plastic_lobes(b, wo),
            _ => vec![],
        }
    }

    /// Value f |cos|, without lobes of a single direction.
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        match self {
            Self::RoughConductor(b, facets) => eval_bsdf_rough_conductor(b, facets, wo, wi),
            Self::RoughDielectric(b, facets) => eval_bsdf_rough_dielectric(b, facets, wo, wi),
            Self::Plastic(b) | Self::RoughPlastic(b, _) => eval_bsdf_plastic(b, wo, wi),
            Self::PolarizedPlastic(b) => eval_bsdf_polarized_plastic(b, wo, wi),
            Self::Phong(b) => eval_bsdf_phong(b, wo, wi),
            Self::Ward(b) => eval_bsdf_ward(b, wo, wi),
            Self::Hair(b) => eval_bsdf_hair(b, wo, wi),
            Self::Measured(b, _) => b.eval(wo, wi),
            _ => DVec3::ZERO,
        }
    }

    /// Density, without lobes of a single direction.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        match self {
            Self::RoughConductor(_, facets) => pdf_reflection(facets, wo, wi),
            Self::RoughDielectric(b, facets) => pdf_bsdf_rough_dielectric(b, facets, wo, wi),
            Self::Hair(b) => pdf_bsdf_hair(b, wo, wi),
            Self::Measured(b, _) => b.pdf(wo, wi),
            _ => self.pdf_with(wo, wi, pdf_cosine_hemisphere(wi.z)),
        }
    }

    /// Density of a substance with a diffuse lobe, given the density of the lobe's sampler.
    pub fn pdf_with(&self, wo: DVec3, wi: DVec3, diffuse_density: f64) -> f64 {
        match self {
            Self::Plastic(b) | Self::RoughPlastic(b, _) => pdf_bsdf_plastic(b, wo, wi, diffuse_density),
            Self::PolarizedPlastic(b) => pdf_bsdf_polarized_plastic(b, wo, wi, diffuse_density),
            Self::Phong(b) => pdf_bsdf_phong(b, wo, wi, diffuse_density),
            Self::Ward(b) => pdf_bsdf_ward(b, wo, wi, diffuse_density),
            _ => 0.0,
        }
    }

    pub fn device(&self) -> DeviceBsdf {
        let mut device = match self {
            Self::Conductor(b) => device_conductor(BSDF_CONDUCTOR, b),
            Self::RoughConductor(b, _) => device_conductor(BSDF_ROUGH_CONDUCTOR, b),
            Self::Dielectric(b) => device_dielectric(BSDF_DIELECTRIC, b),
            Self::ThinDielectric(b) => device_dielectric(BSDF_THIN_DIELECTRIC, b),
            Self::RoughDielectric(b, _) => device_dielectric(BSDF_ROUGH_DIELECTRIC, b),
            Self::Plastic(b) => device_plastic(BSDF_PLASTIC, b, 0),
            Self::RoughPlastic(b, address) => device_plastic(BSDF_ROUGH_PLASTIC, b, *address),
            Self::PolarizedPlastic(b) => device_polarized_plastic(b),
            Self::Phong(b) => device_phong(b),
            Self::Ward(b) => device_ward(b),
            Self::Hair(b) => device_hair(b),
            Self::Measured(_, address) => device_measured(*address),
        };
        if let Some(film) = self.film() {
            device.film = [film.thickness as f32, film.eta as f32];
        }
        if let Some(facets) = self.facets() {
            device.kind_and_flags |= if facets.is_ggx { MATERIAL_GGX } else { 0 };
            device.scalars[..2].copy_from_slice(&facets.alpha.map(|alpha| alpha as f32));
        }
        device
    }
}

fn device_conductor(kind: u32, b: &Conductor) -> DeviceBsdf {
    DeviceBsdf::new(kind, [b.specular_reflectance, b.eta, b.k])
}

fn device_dielectric(kind: u32, b: &Dielectric) -> DeviceBsdf {
    let mut device = DeviceBsdf::new(kind, [b.specular_reflectance, b.specular_transmittance, DVec3::ZERO]);
    device.scalars[2] = b.eta as f32;
    device
}

fn device_plastic(kind: u32, b: &Plastic, address: u32) -> DeviceBsdf {
    let flag = if b.nonlinear { MATERIAL_NONLINEAR } else { 0 };
    let mut device = DeviceBsdf::new(kind | flag, [b.diffuse_reflectance, b.specular_reflectance, DVec3::ZERO]);
    device.scalars[2] = b.eta as f32;
    device.scalars[4..7].copy_from_slice(&[b.internal_reflectance as f32, b.specular_sampling as f32, address as f32]);
    weigh_base(&mut device, b.base_weight, b.base_roughness);
    device
}

fn device_polarized_plastic(b: &PolarizedPlastic) -> DeviceBsdf {
    let colors = [b.diffuse_reflectance, b.specular_reflectance, DVec3::ZERO];
    let mut device = DeviceBsdf::new(BSDF_ROUGH_PLASTIC | MATERIAL_SMOOTH_BASE, colors);
    device.scalars[2] = b.eta as f32;
    device.scalars[4..6].copy_from_slice(&[1.0 - 1.0 / b.eta.powi(2), b.specular_sampling()].map(|x| x as f32));
    weigh_base(&mut device, b.base_weight, b.base_roughness);
    device
}

/// Gives the base of a plastic its weight and its roughness.
fn weigh_base(device: &mut DeviceBsdf, weight: Option<f64>, roughness: f64) {
    if let Some(weight) = weight {
        let is_rough = roughness > 0.0;
        device.kind_and_flags |= MATERIAL_WEIGHTED_BASE | if is_rough { MATERIAL_ENERGY_PRESERVING } else { 0 };
        device.scalars[6..8].copy_from_slice(&[roughness as f32, weight as f32]);
    }
}

fn device_phong(b: &Phong) -> DeviceBsdf {
    let mut device = DeviceBsdf::new(BSDF_PHONG, [b.diffuse_reflectance, b.specular_reflectance, DVec3::ZERO]);
    device.scalars[0] = b.exponent as f32;
    device.scalars[5] = b.specular_probability() as f32;
    device
}

fn device_ward(b: &Ward) -> DeviceBsdf {
    let mut device = DeviceBsdf::new(BSDF_WARD, [b.diffuse_reflectance, b.specular_reflectance, DVec3::ZERO]);
    device.scalars[..2].copy_from_slice(&b.alpha.map(|alpha| alpha as f32));
    device.scalars[4] = match b.model {
        WardModel::Balanced => WARD_BALANCED,
        WardModel::Original => WARD_ORIGINAL,
        WardModel::Duer => WARD_DUER,
    };
    device.scalars[5] = b.specular_probability() as f32;
    device
}

fn device_hair(b: &Hair) -> DeviceBsdf {
    let mut device = DeviceBsdf::new(BSDF_HAIR, [b.sigma_a, DVec3::ZERO, DVec3::ZERO]);
    device.scalars[..3].copy_from_slice(&[b.longitudinal_roughness, b.azimuthal_roughness, b.eta].map(|x| x as f32));
    device.scalars[4] = b.tilt.sin() as f32;
    device
}

/// Roughness by which the guide has its share of measured materials.
pub const MEASURED_ROUGHNESS: f64 = 0.3;

fn device_measured(address: u32) -> DeviceBsdf {
    let mut device = DeviceBsdf::new(BSDF_MEASURED, [DVec3::ONE; 3]);
    let [high, low] = measured::halves(address);
    device.scalars[4..7].copy_from_slice(&[low, high, MEASURED_ROUGHNESS as f32]);
    device
}

const COLOR: DVec3 = DVec3::new(0.9, 0.5, 0.2);
const COPPER: Conductor = Conductor {
    specular_reflectance: COLOR,
    eta: DVec3::new(0.2, 0.924, 1.102),
    k: DVec3::new(3.912, 2.452, 2.142),
    film: None,
};

fn glass(eta: f64) -> Dielectric {
    Dielectric { eta, specular_reflectance: COLOR, specular_transmittance: DVec3::new(0.7, 0.8, 0.6), film: None }
}

fn smooth() -> Vec<(String, Substance)> {
    let dielectrics = [1.5, 0.7].into_iter().flat_map(|eta| {
        let thin = (format!("thin dielectric {eta}"), Substance::ThinDielectric(glass(eta)));
        [(format!("dielectric {eta}"), Substance::Dielectric(glass(eta))), thin]
    });
    let plastics = [(1.49, false), (1.9, true)].map(|(eta, nonlinear)| {
        (format!("plastic {eta}"), plastic(eta, COLOR, DVec3::new(0.6, 0.8, 1.0), nonlinear, None))
    });
    let Substance::Plastic(plain) = plastic(1.49, COLOR, DVec3::new(0.6, 0.8, 1.0), false, None) else {
        unreachable!()
    };
    let weighted =
        |base_roughness| Substance::Plastic(Plastic { base_weight: Some(0.6), base_roughness, ..plain.clone() });
    let others = [
        ("conductor".into(), Substance::Conductor(COPPER)),
        ("weighted smooth plastic".into(), weighted(0.0)),
        ("weighted smooth plastic with a rough base".into(), weighted(0.7)),
    ];
    dielectrics.chain(plastics).chain(others).collect()
}

fn rough(alpha: [f64; 2], is_ggx: bool) -> Vec<(String, Substance)> {
    let facets = Microfacets::new(alpha, is_ggx);
    let name = format!("{} {alpha:?}", if is_ggx { "GGX" } else { "Beckmann" });
    let mut all = vec![
        (format!("rough conductor, {name}"), Substance::RoughConductor(COPPER, facets)),
        (format!("rough dielectric, {name}"), Substance::RoughDielectric(glass(1.5), facets)),
    ];
    let polarized = PolarizedPlastic {
        eta: 1.49,
        diffuse_reflectance: COLOR,
        specular_reflectance: DVec3::new(0.6, 0.8, 1.0),
        facets,
        base_weight: None,
        base_roughness: 0.0,
        film: None,
    };
    all.push((format!("polarized plastic, {name}"), Substance::PolarizedPlastic(polarized)));
    let weighted = PolarizedPlastic { base_weight: Some(0.6), ..polarized };
    all.push((format!("weighted plastic, {name}"), Substance::PolarizedPlastic(weighted)));
    if alpha == [0.2; 2] {
        let rough = PolarizedPlastic { base_roughness: 0.4, ..weighted };
        all.push((format!("weighted plastic with a rough base, {name}"), Substance::PolarizedPlastic(rough)));
    }
    if alpha[0] == alpha[1] {
        let b = plastic(1.49, COLOR, DVec3::new(0.6, 0.8, 1.0), true, Some(facets));
        all.push((format!("rough plastic, {name}"), b));
        // Light enters a medium that is optically thinner.
        all.push((format!("bubble, {name}"), Substance::RoughDielectric(glass(0.75), facets)));
    }
    all
}

/// Phong with a diffuse and a specular reflectance.
pub fn phong(exponent: f64) -> Substance {
    let (diffuse_reflectance, specular_reflectance) = (DVec3::new(0.5, 0.3, 0.1), DVec3::new(0.2, 0.3, 0.4));
    Substance::Phong(Phong { exponent, diffuse_reflectance, specular_reflectance })
}

/// Ward with a diffuse and a specular reflectance.
pub fn ward(model: WardModel, alpha: [f64; 2]) -> Substance {
    let (diffuse_reflectance, specular_reflectance) = (DVec3::new(0.5, 0.3, 0.1), DVec3::new(0.2, 0.3, 0.4));
    Substance::Ward(Ward { model, alpha, diffuse_reflectance, specular_reflectance })
}

fn lobes() -> Vec<(String, Substance)> {
    let phongs = [0.0, 1.0, 30.0, 400.0].map(|exponent| (format!("phong {exponent}"), phong(exponent)));
    let wards = [[0.05; 2], [0.2; 2], [0.1, 0.4], [0.6, 0.3]].into_iter().flat_map(|alpha| {
        [WardModel::Balanced, WardModel::Original, WardModel::Duer]
            .map(|model| (format!("ward {model:?} {alpha:?}"), ward(model, alpha)))
    });
    phongs.into_iter().chain(wards).collect()
}

/// Hair of these roughnesses along and around its fibers.
pub fn hair(longitudinal_roughness: f64, azimuthal_roughness: f64) -> Substance {
    let sigma_a = DVec3::new(0.1, 0.4, 0.9);
    Substance::Hair(Hair { sigma_a, longitudinal_roughness, azimuthal_roughness, eta: 1.55, tilt: 0.05 })
}

fn hairs() -> Vec<(String, Substance)> {
    let roughnesses = [[0.15, 0.6], [0.3, 0.3], [0.8, 0.2], [1.0, 1.0]];
    roughnesses.map(|[along, around]| (format!("hair {along} {around}"), hair(along, around))).to_vec()
}

/// Films over metals, dielectrics and weighted plastics.
fn films() -> Vec<(String, Substance)> {
    let at = |thickness: f64, eta: f64| Some(Film { thickness, eta });
    let facets = Microfacets::new([0.3; 2], true);
    let plastic = PolarizedPlastic {
        eta: 1.49,
        diffuse_reflectance: COLOR,
        specular_reflectance: DVec3::new(0.6, 0.8, 1.0),
        facets,
        base_weight: Some(0.6),
        base_roughness: 0.0,
        film: at(380.0, 2.2),
    };
    let Some((_, Substance::Plastic(smooth))) =
        smooth().into_iter().find(|(name, _)| name == "weighted smooth plastic")
    else {
        unreachable!()
    };
    let substances = [
        ("copper", Substance::Conductor(Conductor { film: at(250.0, 1.7), ..COPPER })),
        ("rough copper", Substance::RoughConductor(Conductor { film: at(500.0, 1.4), ..COPPER }, facets)),
        ("glass", Substance::Dielectric(Dielectric { film: at(300.0, 1.9), ..glass(1.5) })),
        ("rough glass", Substance::RoughDielectric(Dielectric { film: at(420.0, 1.33), ..glass(1.6) }, facets)),
        ("rough bubble", Substance::RoughDielectric(Dielectric { film: at(150.0, 1.2), ..glass(0.75) }, facets)),
        ("plastic", Substance::Plastic(Plastic { film: at(600.0, 1.8), ..smooth })),
        ("rough plastic", Substance::PolarizedPlastic(plastic)),
    ];
    substances.map(|(name, b)| (format!("film over {name}"), b)).to_vec()
}

/// Substances of every kind, at roughness 0.05 to 1.
pub fn substances() -> Vec<(String, Substance)> {
    let alphas = [[0.05; 2], [0.2; 2], [0.5; 2], [1.0; 2], [0.05, 0.5], [0.8, 0.3]];
    let rough = alphas.into_iter().flat_map(|alpha| [rough(alpha, false), rough(alpha, true)]).flatten();
    let measured = ["isotropic.bsdf", "anisotropic.bsdf", "spectral.bsdf"];
    let measured = measured.map(|name| (format!("measured {name}"), measured_of(name)));
    smooth().into_iter().chain(rough).chain(lobes()).chain(hairs()).chain(measured).chain(films()).collect()
}
