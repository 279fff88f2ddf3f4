//! Geometry for acceleration structures, which devices with ray queries traverse by themselves.
//!
//! The device proposes elements that a ray meets, and the kernel's own test of the primitive decides whether the ray hits it, and where.
//! An element has to cover its primitive, with a margin for rounding in the device. The device's own distance to an element decides
//! only which of two opaque triangles is nearer.
//!
//! - A triangle becomes a triangle in its plane whose edges lie outside the primitive's by the margin. A parallelogram becomes two.
//! - Spheres and disks become boxes, and so do triangles that are narrower than the margin.
//! - Flat shapes that are huge beside the scene become boxes, too. The device would round the distance to them too coarsely.

use glam::{DVec3, Vec3};

use crate::encode::bvh::Bvh;
use crate::generated::constants;
use crate::generated::layout::PrimitiveRecord;

/// Margin as a share of the reach of rays. Tests of triangles move the corners to the ray's origin first (Woop, Benthin and Wald
/// 2013), and so err by some 2^-23 of the distance. The margin covers rays that come from up to eight times the reach.
pub const MARGIN: f64 = 1.0 / (1 << 20) as f64;
/// Most of the reach, as a multiple of the median distance of primitives from the camera. A ground or sky that is larger does not
/// swell the elements of a small scene within it.
const MOST_REACH: f64 = 1000.0;
/// Longest edge of a triangle for the device, as a multiple of the median distance.
const LONGEST_EDGE: f64 = 8.0;

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
    /// Length of the rays for which the margin is chosen.
    pub reach: f64,
}

impl QueryGeometry {
    /// Elements for the primitives of a hierarchy, seen from `eye`. `margin` is a share of the reach, usually [`MARGIN`].
    pub fn new(bvh: &Bvh, eye: Vec3, margin: f64) -> Self {
        let usual = usual_distance(bvh, eye.as_dvec3());
        let (low, high) = (bvh.bounds.0.min(eye).as_dvec3(), bvh.bounds.1.max(eye).as_dvec3());
        let reach = (high - low).length().min(MOST_REACH * usual);
        let mut places: [Vec<u32>; 3] = Default::default();
        let mut geometry = Self { reach, ..Self::default() };
        geometry.opaque.reserve(bvh.primitives.len());
        places[0].reserve(bvh.primitives.len());
        // The hierarchy has several boxes for some triangles, and a record for each.
        let mut is_known = vec![false; bvh.sources.iter().max().map_or(0, |&last| last as usize + 1)];
        for ((index, record), &source) in (0..).zip(&bvh.primitives).zip(&bvh.sources) {
            if std::mem::replace(&mut is_known[source as usize], true) {
                continue;
            }
            // Coordinates are rounded, too, where a primitive lies far from the origin.
            let margin = margin * reach.max(largest_coordinate(record));
            let is_huge = record.flags & constants::PRIMITIVE_LARGE != 0
                || f64::from(record.edge_tolerance) > LONGEST_EDGE * usual;
            let front_only = record.flags & constants::PRIMITIVE_FRONT_ONLY != 0;
            for triangle in triangles(record).into_iter().flatten() {
                let (part, list) = match front_only {
                    false => (0, &mut geometry.opaque),
                    true => (1, &mut geometry.front_only),
                };
                match grown(triangle, margin).filter(|_| !is_huge) {
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

    /// Number of elements that a hierarchy needs at most: two for a parallelogram, one for another primitive.
    pub fn most_elements(bvh: &Bvh) -> u64 {
        bvh.primitives.iter().map(|record| 1 + u64::from(shape(record) == constants::SHAPE_PARALLELOGRAM)).sum()
    }

    /// Estimate of the bytes that the structure takes, with what building it takes. On lavapipe of Mesa 25.0.7 they are 150 for each
    /// triangle of the paper's kitchen (`peak_bytes` of `--stats`); other drivers may take more.
    pub fn estimated_bytes(bvh: &Bvh) -> u64 {
        300 * Self::most_elements(bvh)
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

/// Largest coordinate of a primitive's corners, or a little more.
fn largest_coordinate(record: &PrimitiveRecord) -> f64 {
    let [origin, u, v] = vectors(record);
    origin.abs().max_element() + u.abs().max_element() + v.abs().max_element()
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
    // The radius of the inscribed circle. It is NaN where the triangle is a point.
    let radius = (b - a).cross(c - a).length() / perimeter;
    if radius.is_nan() || radius <= margin {
        return None;
    }
    let center = (a * lengths[0] + b * lengths[1] + c * lengths[2]) / perimeter;
    let grow = 1.0 + margin / radius;
    Some(corners.map(|corner| finite(center + (corner - center) * grow)))
}

fn box_around(points: &[DVec3], margin: f64) -> [[f32; 3]; 2] {
    let low = points.iter().fold(DVec3::INFINITY, |low, &point| low.min(point));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |high, &point| high.max(point));
    [low - margin, high + margin].map(finite)
}

/// The vector in single precision. Coordinates beyond its range become the largest ones.
fn finite(v: DVec3) -> [f32; 3] {
    let most = DVec3::splat(f64::from(f32::MAX));
    v.clamp(-most, most).as_vec3().to_array()
}
