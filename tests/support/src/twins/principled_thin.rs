//! Twin of `glsl/include/bsdf/principled_thin.glsl`.

use std::f64::consts::PI;

use glam::DVec3;
use lodestar::math::fresnel::fresnel_dielectric;
use lodestar::math::microfacet::Microfacets;

use super::microfacet::{exact_g1, microfacet_density};
use super::principled::{Principled, diffuse, schlick_between};

/// Parameters, named as in Mitsuba.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(missing_docs)]
pub struct PrincipledThin {
    pub base_color: DVec3,
    pub eta: f64,
    pub roughness: f64,
    pub anisotropic: f64,
    pub spec_trans: f64,
    pub spec_tint: f64,
    pub sheen: f64,
    pub sheen_tint: f64,
    pub flatness: f64,
    pub diff_trans: f64,
}

impl PrincipledThin {
    /// Facets that reflect light, or those that let it cross.
    fn facets(&self, crosses: bool) -> Microfacets {
        let roughness = if crosses { (0.65 * self.eta - 0.35) * self.roughness } else { self.roughness };
        let aspect = (1.0 - 0.9 * self.anisotropic).sqrt();
        let along = [roughness.powi(2) / aspect, roughness.powi(2) * aspect];
        Microfacets { alpha: along.map(|alpha| alpha.max(0.001)), is_ggx: true }
    }

    /// Principled surface with the same diffuse reflection.
    fn thick(&self) -> Principled {
        Principled {
            base_color: self.base_color,
            eta: self.eta,
            roughness: self.roughness,
            anisotropic: self.anisotropic,
            metallic: 0.5 * self.diff_trans,
            spec_trans: self.spec_trans,
            spec_tint: self.spec_tint,
            sheen: self.sheen * (1.0 - self.spec_trans),
            sheen_tint: self.sheen_tint,
            flatness: self.flatness,
            clearcoat: 0.0,
            clearcoat_gloss: 0.0,
            film: None,
        }
    }

    /// Share of the diffuse light that is reflected, and of that which crosses.
    fn diffuse_shares(&self) -> [f64; 2] {
        let crossing = 0.5 * self.diff_trans;
        [1.0 - crossing, crossing].map(|share| share * (1.0 - self.spec_trans))
    }
}

/// Two directions, seen from the side of the first; the second is mirrored to that side where light crosses.
struct Pair {
    wo: DVec3,
    wi: DVec3,
    m: DVec3,
    crosses: bool,
    /// Whether crossing light leaves on the far side of the facets.
    valid: bool,
}

fn pair(wo: DVec3, wi: DVec3) -> Pair {
    let side = wo.z.signum();
    let (wo, there) = (wo * side, wi * side);
    let wi = there.with_z(there.z.abs());
    let m = (wo + wi).normalize();
    let crosses = there.z < 0.0;
    Pair { wo, wi, m, crosses, valid: !crosses || there.dot(m) < 0.0 }
}

/// Value f |cos|.
pub fn eval_bsdf_principled_thin(b: &PrincipledThin, wo: DVec3, wi: DVec3) -> DVec3 {
    if wo.z == 0.0 || wi.z == 0.0 {
        return DVec3::ZERO;
    }
    let Pair { wo, wi, m, crosses, valid } = pair(wo, wi);
    let facets = b.facets(crosses);
    let masking = exact_g1(&facets, wo) * exact_g1(&facets, wi);
    let light = if valid { b.spec_trans * microfacet_density(&facets, m) * masking / (4.0 * wo.z) } else { 0.0 };
    let fresnel = fresnel_dielectric(wo.dot(m), b.eta).reflectance;
    if crosses {
        return b.base_color * (light * (1.0 - fresnel) + b.diffuse_shares()[1] * wi.z / PI);
    }
    let head_on = b.thick().tint() * ((b.eta - 1.0) / (b.eta + 1.0)).powi(2);
    let tinted = schlick_between(head_on, wo.dot(m), b.eta);
    let reflectance = (1.0 - b.spec_tint) * fresnel + b.spec_tint * tinted;
    reflectance * light + diffuse(&b.thick(), wo, wi, m, 1.0)
}

/// Density of `wi`.
pub fn pdf_bsdf_principled_thin(b: &PrincipledThin, wo: DVec3, wi: DVec3) -> f64 {
    if wo.z == 0.0 || wi.z == 0.0 {
        return 0.0;
    }
    let Pair { wo, wi, m, crosses, valid } = pair(wo, wi);
    let facets = b.facets(crosses);
    let visible = exact_g1(&facets, wo) * microfacet_density(&facets, m) / (4.0 * wo.z);
    let specular = if valid { 0.5 * b.spec_trans * visible } else { 0.0 };
    specular + b.diffuse_shares()[usize::from(crosses)] * wi.z / PI
}
