//! Twin of `glsl/include/bsdf/principled.glsl`.

use std::f64::consts::PI;

use glam::DVec3;
use lodestar::math::fresnel::fresnel_dielectric;
use lodestar::math::microfacet::Microfacets;

use super::film::{Film, filmed, metal_index};
use super::microfacet::{exact_g1, microfacet_density};

/// Parameters, named as in Mitsuba.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(missing_docs)]
pub struct Principled {
    pub base_color: DVec3,
    pub eta: f64,
    pub roughness: f64,
    pub anisotropic: f64,
    pub metallic: f64,
    pub spec_trans: f64,
    pub spec_tint: f64,
    pub sheen: f64,
    pub sheen_tint: f64,
    pub flatness: f64,
    pub clearcoat: f64,
    pub clearcoat_gloss: f64,
    pub film: Option<Film>,
}

impl Principled {
    fn diffuse_share(&self) -> f64 {
        (1.0 - self.metallic) * (1.0 - self.spec_trans)
    }

    fn transmitting_share(&self) -> f64 {
        (1.0 - self.metallic) * self.spec_trans
    }

    fn facets(&self) -> Microfacets {
        let aspect = (1.0 - 0.9 * self.anisotropic).sqrt();
        let along = [self.roughness.powi(2) / aspect, self.roughness.powi(2) * aspect];
        Microfacets { alpha: along.map(|alpha| alpha.max(0.001)), is_ggx: true }
    }

    fn clearcoat_alpha(&self) -> f64 {
        0.1 + (0.001 - 0.1) * self.clearcoat_gloss
    }

    pub(super) fn tint(&self) -> DVec3 {
        let luminance = self.base_color.dot(DVec3::new(0.212671, 0.715160, 0.072169));
        if luminance > 0.0 { self.base_color / luminance } else { DVec3::ONE }
    }
}

/// Quantities of a pair of directions that value and density share.
struct Pair {
    /// Normal of the facets between them, on the surface's upper side.
    m: DVec3,
    /// Index of refraction beyond over that in front.
    eta: f64,
    /// Reflectance of the facets of a dielectric, without a film, and by which lobes are drawn.
    plain: f64,
    fresnel: DVec3,
    drawn: f64,
    /// Whether each direction sees the facets from its own side.
    compatible: bool,
    /// Masking G1(wo) G1(wi).
    masking: f64,
    /// Density D(m) of the facets' normals.
    density: f64,
    /// Density G1(wo) D(m) |wo.m| / |cos wo| of visible normals.
    visible: f64,
}

fn pair(b: &Principled, wo: DVec3, wi: DVec3) -> Pair {
    let facets = b.facets();
    let eta = if wo.z > 0.0 { b.eta } else { 1.0 / b.eta };
    let half = if wo.z * wi.z > 0.0 { wo + wi } else { wo + eta * wi };
    let m = half.normalize() * half.z.signum();
    let density = microfacet_density(&facets, m);
    let plain = fresnel_dielectric(wo.dot(m), b.eta).reflectance;
    let (fresnel, drawn) = filmed(b.film, wo.dot(m), b.eta).unwrap_or((DVec3::splat(plain), plain));
    let [masking_o, masking_i] = [wo, wi].map(|w| exact_g1(&facets, w));
    Pair {
        m,
        eta,
        plain,
        fresnel,
        drawn,
        compatible: wo.dot(m) * wo.z > 0.0 && wi.dot(m) * wi.z > 0.0,
        masking: masking_o * masking_i,
        density,
        visible: masking_o * density * (wo.dot(m) / wo.z).abs(),
    }
}

fn schlick(c: f64) -> f64 {
    (1.0 - c).clamp(0.0, 1.0).powi(5)
}

/// Reflectance by Schlick, with the angle on the side of the lower index.
pub(super) fn schlick_between(head_on: DVec3, c: f64, eta: f64) -> DVec3 {
    let interface = fresnel_dielectric(c, eta);
    let weight = schlick(if interface.eta > 1.0 { c.abs() } else { interface.cos_t });
    head_on + (DVec3::ONE - head_on) * weight
}

fn clearcoat_density(b: &Principled, m: DVec3) -> f64 {
    let a2 = b.clearcoat_alpha().powi(2);
    (a2 - 1.0) / (PI * a2.ln() * (1.0 + (a2 - 1.0) * m.z * m.z))
}

fn eval_clearcoat(b: &Principled, wo: DVec3, wi: DVec3, m: DVec3) -> f64 {
    let masking = |w: DVec3| exact_g1(&Microfacets { alpha: [0.25; 2], is_ggx: true }, w);
    let fresnel = schlick_between(DVec3::splat(0.04), wo.dot(m), b.eta).x;
    0.25 * b.clearcoat * fresnel * clearcoat_density(b, m) * masking(wo) * masking(wi) * wi.z.abs()
}

fn facet_fresnel(b: &Principled, wo: DVec3, p: &Pair) -> DVec3 {
    if wo.z < 0.0 {
        return b.transmitting_share() * p.fresnel;
    }
    let c = wo.dot(p.m);
    if let Some(film) = b.film {
        let [eta, k] = metal_index(b.base_color);
        return b.metallic * film.reflectance(c, eta, k) + (1.0 - b.metallic) * p.fresnel;
    }
    let head_on = ((p.eta - 1.0) / (p.eta + 1.0)).powi(2);
    let tinted = schlick_between(b.tint() * head_on, c, b.eta);
    let dielectric = (1.0 - b.spec_tint) * p.fresnel + b.spec_tint * tinted;
    b.metallic * schlick_between(b.base_color, c, b.eta) + (1.0 - b.metallic) * dielectric
}

/// Diffuse light, of which a film leaves a part, and sheen: f cos.
pub(super) fn diffuse(b: &Principled, wo: DVec3, wi: DVec3, m: DVec3, left: f64) -> DVec3 {
    let [f_o, f_i] = [schlick(wo.z), schlick(wi.z)];
    let retro = 2.0 * b.roughness * m.dot(wi).powi(2);
    let surface = (1.0 - f_o / 2.0) * (1.0 - f_i / 2.0) + retro * (f_o + f_i + f_o * f_i * (retro - 1.0));
    let fss90 = retro / 2.0;
    let fss = (1.0 + (fss90 - 1.0) * f_o) * (1.0 + (fss90 - 1.0) * f_i);
    let below = 1.25 * (fss * (1.0 / (wo.z + wi.z) - 0.5) + 0.5);
    let blended = surface + (below - surface) * b.flatness;
    let tint = DVec3::ONE + (b.tint() - DVec3::ONE) * b.sheen_tint;
    let sheen = b.sheen * (1.0 - b.metallic) * schlick(m.dot(wi).abs()) * tint;
    (b.base_color * (left * b.diffuse_share() * blended / PI) + sheen) * wi.z
}

/// Whether any light leaves towards `wo`.
fn is_visible(b: &Principled, wo: DVec3) -> bool {
    wo.z > 0.0 || (wo.z < 0.0 && b.transmitting_share() > 0.0)
}

/// Solid angle of normals per solid angle of transmitted directions.
fn refraction_jacobian(wo: DVec3, wi: DVec3, p: &Pair) -> f64 {
    let sum = wo.dot(p.m) + p.eta * wi.dot(p.m);
    (p.eta * p.eta * wi.dot(p.m)).abs() / (sum * sum)
}

/// Value f |cos|. Transmitted radiance is scaled by the squared ratio of the indices.
pub fn eval_bsdf_principled(b: &Principled, wo: DVec3, wi: DVec3) -> DVec3 {
    let p = pair(b, wo, wi);
    if !is_visible(b, wo) || wi.z == 0.0 {
        return DVec3::ZERO;
    }
    if wo.z * wi.z < 0.0 {
        let facets = p.density * p.masking * (wo.dot(p.m) / wo.z).abs();
        let transmitted = facets * refraction_jacobian(wo, wi, &p) / (p.eta * p.eta);
        let share = if p.compatible { b.transmitting_share() } else { 0.0 };
        return b.base_color.map(f64::sqrt) * (1.0 - p.fresnel) * (share * transmitted);
    }
    let mut value = DVec3::ZERO;
    if p.compatible && b.eta != 1.0 {
        value += facet_fresnel(b, wo, &p) * p.density * p.masking / (4.0 * wo.z.abs());
    }
    if wo.z > 0.0 {
        let left = b.film.map_or(1.0, |_| ((1.0 - p.fresnel.max_element()) / (1.0 - p.plain).max(1.0e-6)).min(1.0));
        value += diffuse(b, wo, wi, p.m, left);
        value += if p.compatible { eval_clearcoat(b, wo, wi, p.m) } else { 0.0 };
    }
    value
}

/// Density of `wi`.
pub fn pdf_bsdf_principled(b: &Principled, wo: DVec3, wi: DVec3) -> f64 {
    let p = pair(b, wo, wi);
    if !is_visible(b, wo) || wi.z == 0.0 {
        return 0.0;
    }
    let front = wo.z > 0.0;
    let shares = if front { [b.diffuse_share(), 0.25 * b.clearcoat] } else { [0.0; 2] };
    let through = if front { b.transmitting_share() } else { 1.0 } * (1.0 - p.drawn);
    let total = shares[0] + shares[1] + 1.0;
    if wo.z * wi.z < 0.0 {
        let density = through * p.visible * refraction_jacobian(wo, wi, &p) / total;
        return if p.compatible { density } else { 0.0 };
    }
    let reflected = (1.0 - through) * p.visible + shares[1] * clearcoat_density(b, p.m) * p.m.z;
    let facets = if p.compatible { reflected / (4.0 * wi.dot(p.m).abs()) } else { 0.0 };
    (shares[0] * wi.z.max(0.0) / PI + facets) / total
}
