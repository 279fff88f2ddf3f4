//! Claim: paths leave surfaces in directions drawn with the density of the twins. The weighted samples add up to the
//! light that the surface scatters, and no direction that it scatters to is left out. All families of scattering
//! functions that a guide takes part in are tested.

use std::sync::OnceLock;

use glam::{DMat3, DVec3, Vec3};
use lodestar::generated::kernels::{self, BSDF_DIFFUSE, Variant, test as sources};
use lodestar::gpu::Kernel;
use lodestar::math::microfacet::Microfacets;
use lodestar::settings::{DirectionMap, GuideSet, Sampler};
use support::device::{Cell, Device};
use support::guide_cases::{NORMALS, settings};
use support::sampled_directions::{DirectionOutput, SeenSurface, draw};
use support::scattering_cases::{Base, DeviceBsdf, Surface, surfaces};
use support::significance::two_sided;
use support::statistics::{chi_square, mean_and_error};
use support::substances::{MEASURED_ROUGHNESS, Substance, hair, phong, plastic, ward};
use support::twins::conductor::Conductor;
use support::twins::cosine::SphereGrid;
use support::twins::dielectric::Dielectric;
use support::twins::direction::basis_from_normal;
use support::twins::direction_map::direction_bin;
use support::twins::guide::Guide;
use support::twins::rough_diffuse::RoughDiffuse;
use support::twins::ward::WardModel;

use super::densities::slack;
use crate::evidence::{Evidence, Record};
use crate::rows::{Row, Scope, kind_of};
use crate::subject::Subject;
use crate::tables::tables;

const SAMPLES: usize = 1 << 16;
/// Cells of a histogram along each side, and points along each side of the map over which the twins are integrated.
const HISTOGRAM: u32 = 32;
const FINE: u32 = 352;
const SEED: u32 = 200;
/// Roughness from which a guide has its largest share of a BSDF of microfacets.
const GUIDED_ALPHA: f64 = 0.4;
/// Relative error of a density in single precision.
const TOLERANCE: f64 = 2.0e-3;

/// A family of scattering functions.
enum Family {
    Diffuse(DVec3),
    Other(Box<Surface>),
}

impl Family {
    fn name(&self) -> &str {
        match self {
            Self::Diffuse(_) => "diffuse",
            Self::Other(surface) => &surface.name,
        }
    }

    /// Part of the samples in which a guide of this set has a share, where it does not stand for a diffuse lobe.
    fn guided_part(&self, set: GuideSet) -> f64 {
        let Self::Other(surface) = self else { return 0.0 };
        let roughness = |facets: &Microfacets| facets.alpha[0].max(facets.alpha[1]) / GUIDED_ALPHA;
        match (&surface.base, set) {
            (_, GuideSet::Diffuse) => 0.0,
            (Base::Substance(Substance::RoughConductor(..)), GuideSet::Authors) => 1.0,
            (Base::Substance(Substance::RoughDielectric(..)), GuideSet::Authors) => 0.9,
            (Base::Substance(Substance::RoughConductor(_, facets)), GuideSet::All) => roughness(facets).min(1.0),
            (Base::Substance(Substance::RoughDielectric(_, facets)), GuideSet::All) => 0.5 * roughness(facets).min(1.0),
            (Base::Principled(_) | Base::PrincipledThin(_) | Base::Substance(Substance::Hair(_)), GuideSet::All) => 0.5,
            (Base::Substance(Substance::Measured(..)), GuideSet::All) => MEASURED_ROUGHNESS / GUIDED_ALPHA,
            _ => 0.0,
        }
    }

    /// Whether a guide of this set takes part in it.
    fn is_guided(&self, set: GuideSet) -> bool {
        self.guided_part(set) > 0.0 || self.has_diffuse_lobe()
    }

    fn has_diffuse_lobe(&self) -> bool {
        match self {
            Self::Diffuse(_) => true,
            Self::Other(surface) => match &surface.base {
                Base::RoughDiffuse(_) | Base::Diffuse(_) => true,
                Base::Substance(substance) => {
                    use Substance::{Hair, Measured, RoughConductor, RoughDielectric};
                    !matches!(substance, RoughConductor(..) | RoughDielectric(..) | Hair(_) | Measured(..))
                }
                _ => false,
            },
        }
    }

    fn device(&self) -> DeviceBsdf {
        match self {
            Self::Diffuse(albedo) => DeviceBsdf::new(BSDF_DIFFUSE, [*albedo, DVec3::ZERO, DVec3::ZERO]),
            Self::Other(surface) => surface.device(),
        }
    }

    /// Value f cos, without lobes of a single direction.
    fn eval(&self, wo: DVec3, wi: DVec3) -> f64 {
        let value = match self {
            Self::Diffuse(albedo) => *albedo * (wi.z.max(0.0) / std::f64::consts::PI),
            Self::Other(surface) => surface.eval(wo, wi),
        };
        value.element_sum() / 3.0
    }

    /// Whether light is scattered to directions on this side.
    fn reaches(&self, wi: DVec3) -> bool {
        wi.z > 0.0 || matches!(self, Self::Other(surface) if surface.transmits())
    }

    /// Density of a direction that light is scattered to, given the density of the guide of a set. `product` holds the density
    /// of the product sampler's descent alone, and the share of the cosine that it is mixed with over a lobe.
    fn pdf(&self, wo: DVec3, wi: DVec3, set: GuideSet, guide: f64, product: Option<(f64, f64)>) -> f64 {
        let part = self.guided_part(set);
        match self {
            Self::Other(surface) if part > 0.0 => {
                let (drawn, share) =
                    product.map_or((guide, part), |(descent, cosine)| (descent, part * (1.0 - cosine)));
                (1.0 - share) * surface.pdf(wo, wi) + share * drawn
            }
            Self::Other(surface) => match &surface.base {
                Base::Substance(substance) => substance.pdf_with(wo, wi, guide),
                // The guide stands for the diffuse lobe below a sheen.
                _ => match &surface.sheen {
                    Some(sheen) => {
                        let share = surface.sheen_probability(wo);
                        (1.0 - share) * guide + share * sheen.density(wo, wi)
                    }
                    None => guide,
                },
            },
            Self::Diffuse(_) => guide,
        }
    }
}

fn families() -> Vec<Family> {
    let color = DVec3::new(0.9, 0.5, 0.2);
    let rough = |alpha| Microfacets::new([alpha; 2], true);
    let other = |name: &str, base| Family::Other(Box::new(Surface::plain(name, base)));
    let oren_nayar =
        RoughDiffuse { reflectance: color, alpha: 0.4, fast_approximation: false, energy_preserving: false };
    let metal = Conductor { specular_reflectance: color, eta: DVec3::splat(0.9), k: DVec3::splat(2.5), film: None };
    let glass =
        Dielectric { eta: 1.5, specular_reflectance: color, specular_transmittance: DVec3::splat(0.8), film: None };
    let known = |name: &str, base: &str| {
        let surface = surfaces().into_iter().find(|surface| surface.name == base);
        Family::Other(Box::new(Surface { name: name.into(), ..surface.expect("a surface") }))
    };
    vec![
        Family::Diffuse(color),
        other("rough diffuse", Base::RoughDiffuse(oren_nayar)),
        other("plastic", Base::Substance(plastic(1.5, color, DVec3::ONE, false, None))),
        other("rough plastic", Base::Substance(plastic(1.5, color, DVec3::ONE, true, Some(rough(0.4))))),
        other("phong", Base::Substance(phong(12.0))),
        other("ward", Base::Substance(ward(WardModel::Balanced, [0.4, 0.25]))),
        other("rough conductor", Base::Substance(Substance::RoughConductor(metal, rough(0.5)))),
        other("rough dielectric", Base::Substance(Substance::RoughDielectric(glass, rough(0.5)))),
        // Surfaces that are smoother than GUIDED_ALPHA.
        other("smoother conductor", Base::Substance(Substance::RoughConductor(metal, rough(0.3)))),
        other("smoother dielectric", Base::Substance(Substance::RoughDielectric(glass, rough(0.3)))),
        other("hair", Base::Substance(hair(0.3, 0.4))),
        known("measured", "measured anisotropic.bsdf"),
        known("principled", "principled 0.5 all"),
        known("principled thin", "principled thin 0.5 all"),
        known("sheen over diffuse", "sheen 0.8 over diffuse"),
        known("sheen over metal", "sheen 0.3 over metal"),
        known("film over principled", "film over principled dielectric, all"),
    ]
}

/// The kernel with the grids of one cell.
struct Bench {
    device: Device,
    cell: Cell,
    kernel: Kernel,
    group: u32,
}

impl Bench {
    fn new(subject: &Subject, row: &Row, guide_set: GuideSet, families: &[Family]) -> Self {
        let (device, kind) = (Device::new(), kind_of(row));
        let normal_resolution = if kind.rules.sampler == Sampler::SphereInversion { 1 } else { NORMALS };
        let kinds = families.iter().map(|family| 1 << (family.device().kind_and_flags & kernels::MATERIAL_KIND_MASK));
        let variant = Variant {
            normal_resolution,
            guide_set: guide_set as u32,
            surface_features: kernels::FEATURE_SHEEN | kernels::FEATURE_FILM,
            material_kinds: kinds.fold(0, |all: u32, kind: u32| all | kind),
            workgroup_size: subject.group,
            ..kind.variant()
        };
        let cell = Cell::normalized_by(&device, &variant, &subject.kernel(&sources::NORMALIZE_CELL));
        let kernel = device.kernel(&subject.kernel(&sources::SAMPLE_DIRECTION), &variant);
        Self { device, cell, kernel, group: subject.group }
    }

    fn draw(&self, family: &Family, wo: DVec3, normal: DVec3, seed: u32) -> Vec<DirectionOutput> {
        let surface = SeenSurface { bsdf: family.device(), wo, normal };
        draw(&self.device, &self.cell, (&self.kernel, self.group), surface, (seed, SAMPLES))
    }
}

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let (angles, normals) = if scope.full { (&[50.0_f64, 80.0][..], 2) } else { (&[50.0][..], 1) };
    for row in scope.guided() {
        // The default set has all families. The short form leaves out what the others share with it.
        for guide_set in [GuideSet::All, GuideSet::Authors, GuideSet::Diffuse] {
            let is_wanted = |family: &Family| match guide_set {
                GuideSet::All => true,
                _ if scope.full => family.is_guided(guide_set),
                _ => family.guided_part(guide_set) > 0.0,
            };
            let families: Vec<_> = families().into_iter().filter(is_wanted).collect();
            if families.is_empty() {
                continue;
            }
            let bench = Bench::new(subject, &row, guide_set, &families);
            let kind = kind_of(&row);
            // The horizons of these normals lie between the points over which the twins are integrated. The normals are
            // not on centers of bins.
            for setting in [1, 3].iter().take(normals).map(|&index| &settings(kind.map)[index]) {
                let wanted = ["peaked", "freshly learned", "hot bin at the horizon", "all zero"];
                let wanted = &wanted[..if scope.full { 4 } else { 1 }];
                let all = tables(kind.map, setting.nb).into_iter();
                for (name, table) in all.filter(|(name, _)| wanted.contains(name)) {
                    bench.cell.fill(&bench.device, &table);
                    let guide = setting.guide(&table, &kind.rules, setting.entry(&table, &kind.rules));
                    for (family, angle) in
                        families.iter().flat_map(|family| angles.iter().map(move |angle| (family, angle)))
                    {
                        let (sine, cosine) = angle.to_radians().sin_cos();
                        let wo = DVec3::new(0.8 * sine, -0.6 * sine, cosine).as_vec3().normalize().as_dvec3();
                        let case = Case { family, guide_set, wo, guide: &guide, map: kind.map };
                        let name = format!(
                            "{}: {}, set {guide_set:?}, {angle} degrees, {name}, normal {}",
                            row.name,
                            family.name(),
                            setting.name
                        );
                        case.check(&bench.draw(family, wo, setting.n, SEED + subject.seed), &name, evidence);
                    }
                }
            }
        }
    }
}

struct Case<'a> {
    family: &'a Family,
    guide_set: GuideSet,
    wo: DVec3,
    guide: &'a Guide<'a>,
    map: DirectionMap,
}

fn fine(map: DirectionMap) -> &'static SphereGrid {
    static SPHERES: [OnceLock<SphereGrid>; 2] = [OnceLock::new(), OnceLock::new()];
    SPHERES[map as usize].get_or_init(|| SphereGrid::new(map, FINE))
}

impl Case<'_> {
    fn local(&self, w: DVec3) -> DVec3 {
        let frame: DMat3 = basis_from_normal(self.guide.n);
        frame.transpose() * w
    }

    fn pdf(&self, w: DVec3) -> f64 {
        let is_product = self.guide.rules.sampler == Sampler::Product;
        let product = is_product.then(|| (self.guide.descent(w), self.guide.cosine_share()));
        self.family.pdf(self.wo, self.local(w), self.guide_set, self.guide.pdf(w), product)
    }

    fn check(&self, drawn: &[DirectionOutput], name: &str, evidence: &mut Evidence) {
        let count = drawn.len() as f64;
        let reached = |w: DVec3| self.family.reaches(self.local(w));
        let mut observed = vec![0; (HISTOGRAM * HISTOGRAM) as usize];
        let spread = || drawn.iter().filter(|d| d.pdf > 0.0).map(|d| (unit(d.wi), d)).filter(|(w, _)| reached(*w));
        spread().for_each(|(w, _)| observed[direction_bin(self.map, w, HISTOGRAM) as usize] += 1);
        let masses = fine(self.map).integrals(HISTOGRAM, |w| if reached(w) { self.pdf(w) } else { 0.0 });
        let mut expected: Vec<f64> = masses.iter().map(|mass| mass * count).collect();
        // The last cell counts single directions and lost samples.
        observed.push(drawn.len() as u64 - observed.iter().sum::<u64>());
        expected.push((count - expected.iter().sum::<f64>()).max(0.0));
        evidence.test(format!("chi-square, {name}"), chi_square(&observed, &expected), || {
            Record::Histogram(observed.clone(), expected.clone())
        });
        self.check_densities(drawn, name, evidence);
        let light: f64 = fine(self.map).integrals(1, |w| self.family.eval(self.wo, self.local(w)))[0];
        let weight = |d: &DirectionOutput| {
            if d.pdf > 0.0 { d.weight.iter().map(|&w| f64::from(w)).sum::<f64>() / 3.0 } else { 0.0 }
        };
        let (mean, error) = mean_and_error(drawn.iter().map(weight));
        // The light is a sum over points, and the value jumps at the horizon.
        let p = two_sided((mean - light) / error.hypot(1.0e-3 * light));
        evidence.test(format!("light, {name}: {mean:.5} +- {error:.5}, not {light:.5}"), p, || Record::Nothing);
    }

    fn check_densities(&self, drawn: &[DirectionOutput], name: &str, evidence: &mut Evidence) {
        let is_off = |w: DVec3, pdf: f32| {
            let twin = self.pdf(w);
            (f64::from(pdf) - twin).abs() > TOLERANCE * twin + slack(self.guide, w)
        };
        let (mut wrong, mut apart, mut unsupported) = (0, 0, 0);
        for d in drawn {
            let (wi, given) = (unit(d.wi), unit(d.given));
            // Only directions away from the horizon count: next to it, rounding decides the side.
            let is_clear = |w: DVec3| self.local(w).z.abs() > 1.0e-4 && w.dot(self.guide.nb).abs() > 1.0e-4;
            if d.pdf > 0.0 && self.family.reaches(self.local(wi)) && is_clear(wi) {
                wrong += usize::from(is_off(wi, d.pdf));
                apart += usize::from((d.pdf - d.pdf_of_wi).abs() > TOLERANCE as f32 * d.pdf);
            }
            if self.family.reaches(self.local(given)) && is_clear(given) {
                wrong += usize::from(is_off(given, d.pdf_of_given));
                unsupported += usize::from(Vec3::from(d.value_of_given).max_element() > 0.0 && d.pdf_of_given <= 0.0);
            }
        }
        // Few samples may be wrong: at borders of bins, rounding decides the bin.
        let few = drawn.len() / 2000;
        evidence.hold(format!("density, {name}"), wrong <= few, || format!("{wrong} differ from the twin's"));
        evidence
            .hold(format!("density of samples, {name}"), apart <= few, || format!("{apart} are not their direction's"));
        evidence
            .hold(format!("support, {name}"), unsupported == 0, || format!("{unsupported} directions have density 0"));
    }
}

fn unit(w: [f32; 3]) -> DVec3 {
    Vec3::from(w).as_dvec3().normalize()
}
