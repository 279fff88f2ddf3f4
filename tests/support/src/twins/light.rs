//! Twin of `glsl/include/light/light_shape.glsl`, `environment.glsl` and the delta lights of `light.glsl`.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Vec3, dvec2};
use lodestar::encode::lights::{EnvironmentMap, EnvironmentTable};
use lodestar::scene::{DeltaKind, Primitive, PrimitiveShape};

use super::intersect::{Ray, crossings, turned};

/// Ratio of the squared distance of a sphere's center to its squared radius. Above it, the sphere is sampled by the
/// cone that it fills.
const CONE_FROM: f64 = 1.001;

/// Density per steradian with which a direction to `p` is drawn from `from`.
pub fn pdf_primitive(p: &Primitive, from: DVec3, direction: DVec3) -> f64 {
    let p = &turned(p, from);
    let hits = crossings(&Ray { origin: from, direction, t_max: f64::INFINITY }, p);
    let hits = hits.into_iter().filter(|hit| hit.inside >= 0.0 && hit.t > 0.0);
    let to_center = p.origin.as_dvec3() - from;
    let radius = p.edge_u.as_dvec3().length();
    let squared_sine = radius.powi(2) / to_center.length_squared();
    if p.shape == PrimitiveShape::Sphere && squared_sine < 1.0 / CONE_FROM {
        let cone = TAU * (1.0 - (1.0 - squared_sine).sqrt());
        return if hits.count() > 0 { 1.0 / cone } else { 0.0 };
    }
    let density = |t: f64| {
        let at = from + t * direction;
        let normal = match p.shape {
            PrimitiveShape::Sphere => (at - p.origin.as_dvec3()) / radius,
            _ => p.edge_u.as_dvec3().cross(p.edge_v.as_dvec3()).normalize(),
        };
        t * t / (normal.dot(direction).abs() * area(p))
    };
    hits.map(|hit| density(hit.t)).sum()
}

/// Area of a primitive.
pub fn area(p: &Primitive) -> f64 {
    let spanned = p.edge_u.as_dvec3().cross(p.edge_v.as_dvec3()).length();
    match p.shape {
        PrimitiveShape::Triangle => 0.5 * spanned,
        PrimitiveShape::Parallelogram => 4.0 * spanned,
        PrimitiveShape::Disk => PI * spanned,
        // What faces everything has the power of a sphere.
        PrimitiveShape::Sphere | PrimitiveShape::FacingDisk => 4.0 * PI * p.edge_u.as_dvec3().length_squared(),
    }
}

/// Coordinates on a map, each in [0, 1), of a direction in the map's space: the azimuth from -z towards +x, and the
/// angle from +y.
pub fn environment_coordinates(direction: DVec3) -> DVec2 {
    let azimuth = direction.x.atan2(-direction.z) / TAU;
    dvec2(azimuth.rem_euclid(1.0), direction.y.clamp(-1.0, 1.0).acos() / PI)
}

/// Radiance of a map in a direction of its space.
pub fn environment_radiance(map: &EnvironmentMap, direction: DVec3) -> DVec3 {
    let at = environment_coordinates(direction);
    let (width, height) = (map.width as f64, map.height as f64);
    let (x, y) = ((at.x * width - 0.5).rem_euclid(width), at.y * (height - 1.0));
    let y0 = (y as usize).min(map.height - 2);
    let texel = |x: usize, y: usize| map.texels[y * map.width + x % map.width].as_dvec3();
    let row = |y: usize| texel(x as usize, y).lerp(texel(x as usize + 1, y), x.fract());
    row(y0).lerp(row(y0 + 1), y - y0 as f64)
}

/// Density per steradian with which a direction of a map's space is drawn.
pub fn pdf_environment(table: &EnvironmentTable, direction: DVec3) -> f64 {
    let at = environment_coordinates(direction);
    let block = |at: f64, count: usize| ((at * count as f64) as usize).min(count - 1);
    let entry = table.entries[block(at.y, table.rows) * table.columns + block(at.x, table.columns)];
    let sine = direction.x.hypot(direction.z);
    f64::from(entry.probability) * (table.columns * table.rows) as f64 / (TAU * PI * sine)
}

/// Direction from `from` towards an emitter that no ray can hit, and the irradiance there on a surface that faces it.
pub fn delta_light(kind: &DeltaKind, from: DVec3) -> (DVec3, DVec3) {
    let arriving = |position: Vec3, intensity: Vec3| {
        let d = position.as_dvec3() - from;
        (d.normalize(), intensity.as_dvec3() / d.length_squared())
    };
    match *kind {
        DeltaKind::Point { position, intensity } => arriving(position, intensity),
        DeltaKind::Directional { direction, irradiance } => (-direction.as_dvec3(), irradiance.as_dvec3()),
        DeltaKind::Projector { position, direction, axes, irradiance } => {
            let d = from - position.as_dvec3();
            let depth = d.dot(direction.as_dvec3());
            let place = [axes.u, axes.v].map(|axis| 0.5 + d.dot(axis.as_dvec3()) / depth);
            let is_inside = depth > 0.0 && place.iter().all(|place| (0.0..=1.0).contains(place));
            // Light that falls straight on a screen at distance 1 has the irradiance, times pi. The pyramid's sections grow with
            // the squared depth, and a surface that faces the light is turned against them.
            let cosine = depth / d.length();
            let straight = if is_inside { PI / (depth * depth * cosine) } else { 0.0 };
            assert!(irradiance.texture.is_none(), "this twin knows no pictures");
            (-d.normalize(), irradiance.value.as_dvec3() * straight)
        }
        DeltaKind::PicturedSpot { .. } => panic!("this twin knows no pictures"),
        DeltaKind::Spot { position, direction, intensity, cutoff_angle, beam_width } => {
            let (wi, irradiance) = arriving(position, intensity);
            let (angle, cutoff) = ((-wi).angle_between(direction.as_dvec3()), f64::from(cutoff_angle));
            let falloff = match angle {
                angle if angle >= cutoff => 0.0,
                angle if angle <= f64::from(beam_width) => 1.0,
                angle => (cutoff - angle) / (cutoff - f64::from(beam_width)),
            };
            (wi, irradiance * falloff)
        }
    }
}
