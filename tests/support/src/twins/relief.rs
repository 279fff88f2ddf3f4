//! Twin of `glsl/include/geometry/relief.glsl`.

use glam::{DMat3, DVec2, DVec3};

/// Normal of a surface whose height has the given gradient, in a frame whose z-axis is the shading normal.
pub fn bump_normal(dp_du: DVec3, dp_dv: DVec3, gradient: DVec2, geometric_normal: DVec3) -> DVec3 {
    let raised = |tangent: DVec3, slope: f64| tangent - DVec3::Z * DVec3::Z.dot(tangent) + DVec3::Z * slope;
    let n = raised(dp_du, gradient.x).cross(raised(dp_dv, gradient.y));
    if n.dot(geometric_normal) < 0.0 { -n } else { n }
}

/// Normal that a color encodes.
pub fn mapped_normal(color: DVec3) -> DVec3 {
    color * 2.0 - 1.0
}

/// Frame about the normal `n`. It is turned if `wo` is behind it.
pub fn relief_frame(n: DVec3, wo: DVec3) -> DMat3 {
    let behind = wo.z * wo.dot(n) <= 0.0;
    let n = if behind { DVec3::new(-n.x, -n.y, n.z) } else { n }.normalize();
    let s = DVec3::X.reject_from_normalized(n).normalize();
    DMat3::from_cols(s, n.cross(s), n)
}

/// Shadowing of a tilted facet (Conty Estevez et al. 2019). Both directions are in the surface's own frame.
pub fn relief_shadowing(n: DVec3, wi: DVec3) -> f64 {
    if wi.z * n.dot(wi) <= 0.0 {
        return 0.0;
    }
    let tan2 = |w: DVec3| w.truncate().length_squared() / (w.z * w.z);
    let alpha2 = (0.125 * tan2(n)).min(1.0);
    2.0 / (1.0 + (1.0 + alpha2 * tan2(wi)).sqrt())
}

/// Height of the mirror direction of `wo` over the surface, in the surface's own frame.
pub fn mirrored_height(n: DVec3, wo: DVec3) -> f64 {
    2.0 * n.dot(wo) * n.z - wo.z
}

/// Normal that is raised until the mirror direction of `wo` leaves the surface: bisection of the angle between the surface's normal and `n`.
/// `wo` is above the surface.
pub fn raised_normal(n: DVec3, wo: DVec3) -> DVec3 {
    let least = (0.9 * wo.z).min(0.01);
    if mirrored_height(n, wo) >= least {
        return n;
    }
    let along = n.reject_from_normalized(DVec3::Z).normalize();
    let at = |angle: f64| angle.cos() * DVec3::Z + angle.sin() * along;
    let (mut low, mut high) = (0.0, n.angle_between(DVec3::Z));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *if mirrored_height(at(middle), wo) >= least { &mut low } else { &mut high } = middle;
    }
    at(low)
}
