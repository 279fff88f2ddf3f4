//! Geometry for acceleration structures, which devices with ray queries traverse by themselves.
//!
//! The device proposes elements that a ray meets, and the kernel's own test of the primitive decides. So an element only has to cover
//! its primitive, with a margin for rounding. A triangle becomes a triangle whose edges lie outside the primitive's by the margin, in
//! its plane; a parallelogram becomes two. Spheres, disks and triangles that are narrower than the margin become boxes.

use std::collections::HashSet;

use glam::{DVec3, Vec3};

use crate::encode::bvh::Bvh;
use crate::generated::constants;
use crate::generated::layout::PrimitiveRecord;

/// Margin as a share of a primitive's reach. Tests of triangles move the corners to the ray's origin first (Woop, Benthin and Wald
/// 2013), and so err by some 2^-23 of the distance. So the margin covers rays from eight times the reach.
pub const MARGIN: f64 = 1.0 / (1 << 20) as f64;

/// Elements of an acceleration structure in three parts, and the primitive of each.
#[derive(Debug, Default)]
pub struct QueryGeometry {
    /// Corners of triangles that rays meet from both sides.
    pub opaque: Vec<[[f32; 3]; 3]>,
    /// Corners of triangles that rays meet from the front only.
    pub front_only: Vec<[[f32; 3]; 3]>,
    /// Lower and upper corners of boxes.
    pub boxes: Vec<[[f32; 3]; 2]>,
    /// Index of the first element of each part, in the order of the fields above, then the primitive of each element.
    pub elements: Vec<u32>,
}

impl QueryGeometry {
    /// Elements for the primitives of a hierarchy, seen from `eye`. `margin` is a share of a primitive's reach, usually [`MARGIN`].
    pub fn new(bvh: &Bvh, eye: Vec3, margin: f64) -> Self {
        let usual = usual_distance(bvh, eye.as_dvec3());
        let mut places: [Vec<u32>; 3] = Default::default();
        let mut geometry = Self::default();
        let mut known = HashSet::new();
        for ((index, record), attributes) in (0..).zip(&bvh.primitives).zip(&bvh.attributes) {
            // The hierarchy has several boxes for some triangles, and a record for each.
            if !known.insert((bytemuck::bytes_of(record), bytemuck::bytes_of(attributes))) {
                continue;
            }
            let margin = margin * reach(record, eye.as_dvec3()).max(usual);
            let front_only = record.flags & constants::PRIMITIVE_FRONT_ONLY != 0;
            for triangle in triangles(record).into_iter().flatten() {
                let (part, list) = match front_only {
                    false => (0, &mut geometry.opaque),
                    true => (1, &mut geometry.front_only),
                };
                match grown(triangle, margin) {
                    Some(corners) => {
                        list.push(corners);
                        places[part].push(index);
                    }
                    None => {
                        geometry.boxes.push(box_around(&triangle, margin));
                        places[2].push(index);
                    }
                }
            }
            if let Some(corners) = round_shape(record) {
                geometry.boxes.push(box_around(&corners, margin));
                places[2].push(index);
            }
        }
        let mut first = places.len() as u32;
        for part in &places {
            geometry.elements.push(first);
            first += part.len() as u32;
        }
        geometry.elements.extend(places.iter().flatten());
        geometry
    }

    /// Estimate of the bytes that the structure takes, with what building it takes. Drivers need 60 to 200 bytes for a triangle.
    pub fn estimated_bytes(bvh: &Bvh) -> u64 {
        300 * bvh.primitives.len() as u64
    }
}

fn shape(record: &PrimitiveRecord) -> u32 {
    record.flags & constants::PRIMITIVE_SHAPE_MASK
}

fn vectors(record: &PrimitiveRecord) -> [DVec3; 3] {
    [record.origin, record.edge_u, record.edge_v].map(|vector| Vec3::from(vector).as_dvec3())
}

/// Median of the distances of primitives from `eye`. A huge ground or sky does not change it much.
fn usual_distance(bvh: &Bvh, eye: DVec3) -> f64 {
    let mut distances: Vec<f64> = bvh.primitives.iter().map(|record| (vectors(record)[0] - eye).length()).collect();
    let middle = distances.len() / 2;
    if distances.is_empty() { 0.0 } else { *distances.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Largest coordinate of a primitive, relative to the world's origin and to `eye`. Rounding errs in proportion to both.
fn reach(record: &PrimitiveRecord, eye: DVec3) -> f64 {
    let [origin, u, v] = vectors(record);
    let extent = u.abs().max_element() + v.abs().max_element();
    origin.abs().max_element().max((origin - eye).length()) + extent
}

/// The triangles that a flat shape with straight edges consists of.
fn triangles(record: &PrimitiveRecord) -> [Option<[DVec3; 3]>; 2] {
    let [origin, u, v] = vectors(record);
    match shape(record) {
        constants::SHAPE_TRIANGLE => [Some([origin, origin + u, origin + v]), None],
        constants::SHAPE_PARALLELOGRAM => {
            let [a, b, c, d] = [origin - u - v, origin + u - v, origin + u + v, origin - u + v];
            [Some([a, b, c]), Some([a, c, d])]
        }
        _ => [None, None],
    }
}

/// Two opposite corners of the box of a sphere or disk; `None` for other shapes.
fn round_shape(record: &PrimitiveRecord) -> Option<[DVec3; 2]> {
    let [center, u, v] = vectors(record);
    let half = match shape(record) {
        constants::SHAPE_SPHERE => DVec3::splat(f64::from(record.edge_tolerance)),
        constants::SHAPE_DISK => (u * u + v * v).map(f64::sqrt),
        _ => return None,
    };
    Some([center - half, center + half])
}

/// Triangle whose edges lie outside those of `corners` by `margin`, in the same plane; `None` where it is narrower than the margin,
/// so that it would become much longer.
fn grown(corners: [DVec3; 3], margin: f64) -> Option<[[f32; 3]; 3]> {
    let [a, b, c] = corners;
    let lengths = [(c - b).length(), (a - c).length(), (b - a).length()];
    let perimeter: f64 = lengths.iter().sum();
    let radius = (b - a).cross(c - a).length() / perimeter;
    // A point has no such circle, and its radius is no number.
    if radius.is_nan() || radius <= margin {
        return None;
    }
    let center = (a * lengths[0] + b * lengths[1] + c * lengths[2]) / perimeter;
    let grow = 1.0 + margin / radius;
    Some(corners.map(|corner| (center + (corner - center) * grow).as_vec3().to_array()))
}

fn box_around(points: &[DVec3], margin: f64) -> [[f32; 3]; 2] {
    let low = points.iter().fold(DVec3::INFINITY, |low, &point| low.min(point));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |high, &point| high.max(point));
    [low - margin, high + margin].map(|corner| corner.as_vec3().to_array())
}
