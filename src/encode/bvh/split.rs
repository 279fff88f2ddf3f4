//! Boxes for building the hierarchy: one per primitive, but several for a triangle that fills its box badly, so that
//! fewer rays enter the box without a hit (early split clipping: Ernst and Greiner 2007).

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::splits::split_aabbs_preset;
use obvhs::triangle::Triangle;
use rayon::prelude::*;

use crate::scene::deformation::{Deformation, deformation_of};
use crate::scene::{Primitive, PrimitiveShape};

/// Least area of a box to be split, as a multiple of the mean area: `split_aabbs_preset` ignores smaller ones.
const SMALLEST_SPLIT: f32 = 3.0;

/// Boxes, and the index of the primitive that each holds wholly or in part. The first boxes are the primitives' own in
/// their order, as the builder expects.
pub(super) struct Boxes {
    pub boxes: Vec<Aabb>,
    pub primitives: Vec<u32>,
}

impl Boxes {
    /// Boxes of all primitives, then those of instances. Each reaches beyond its content by the share `margin` of its content's largest
    /// coordinate.
    pub fn new(primitives: &[Primitive], deformations: &[Deformation], instances: Vec<Aabb>, margin: f32) -> Self {
        let mut boxes: Vec<Aabb> = primitives.par_iter().map(box_of).collect();
        for (index, (min, max)) in deformations.iter().flat_map(Deformation::boxes) {
            let own = &mut boxes[index as usize];
            *own = own.union(&Aabb::new(min.into(), max.into()));
        }
        boxes.extend(instances);
        let mut all = Self { primitives: (0..boxes.len() as u32).collect(), boxes };
        let margins: Vec<f32> = all.boxes.par_iter().map(|aabb| margin * largest_coordinate(aabb)).collect();
        all.split(primitives, deformations, &margins);
        let of_primitives = all.primitives.par_iter().map(|&primitive| margins[primitive as usize]);
        all.boxes.par_iter_mut().zip(of_primitives).for_each(|(aabb, margin)| *aabb = padded(*aabb, margin));
        all
    }

    fn split(&mut self, primitives: &[Primitive], deformations: &[Deformation], margins: &[f32]) {
        let areas = || self.boxes.iter().map(Aabb::half_area);
        let mean = (areas().map(f64::from).sum::<f64>() / self.boxes.len() as f64) as f32;
        let largest = areas().fold(0.0, f32::max);
        let is_split = |&i: &u32| {
            self.boxes[i as usize].half_area() > SMALLEST_SPLIT * mean
                && can_be_split(&primitives[i as usize])
                && deformation_of(deformations, i).is_none()
        };
        let split: Vec<u32> = (0..primitives.len() as u32).filter(is_split).collect();
        let triangles: Vec<Triangle> = split.iter().map(|&i| triangle(&primitives[i as usize])).collect();
        let mut parts: Vec<Aabb> = split.iter().map(|&i| self.boxes[i as usize]).collect();
        let mut triangle_of_part: Vec<u32> = (0..split.len() as u32).collect();
        split_aabbs_preset(&mut parts, &mut triangle_of_part, &triangles, mean, largest);

        // The cuts are rounded, so parts are padded to overlap.
        let margin_of = |part: &u32| margins[split[*part as usize] as usize];
        let mut parts = parts.into_iter().zip(triangle_of_part.iter().map(margin_of));
        let mut parts = parts.by_ref().map(|(part, margin)| padded(ordered(part), margin));
        for (&primitive, part) in split.iter().zip(parts.by_ref()) {
            self.boxes[primitive as usize] = part;
        }
        self.boxes.extend(parts);
        self.primitives.extend(triangle_of_part[split.len()..].iter().map(|&part| split[part as usize]));
    }
}

/// Whether a primitive may be split: only a triangle, because other shapes fill their boxes, and no emitter, because a
/// light is one primitive.
fn can_be_split(p: &Primitive) -> bool {
    p.shape == PrimitiveShape::Triangle && p.emitter.is_none()
}

fn triangle(p: &Primitive) -> Triangle {
    let [v0, v1, v2] = [p.origin, p.origin + p.edge_u, p.origin + p.edge_v].map(Vec3A::from);
    Triangle { v0, v1, v2 }
}

fn box_of(primitive: &Primitive) -> Aabb {
    let (min, max) = primitive.bounds();
    Aabb::new(min.into(), max.into())
}

fn largest_coordinate(aabb: &Aabb) -> f32 {
    aabb.min.abs().max(aabb.max.abs()).max_element()
}

fn padded(aabb: Aabb, margin: f32) -> Aabb {
    Aabb::new(aabb.min - margin, aabb.max + margin)
}

/// Box whose corners are in order, which rounding may have exchanged.
fn ordered(aabb: Aabb) -> Aabb {
    Aabb::new(aabb.min.min(aabb.max), aabb.min.max(aabb.max))
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, vec3};

    use super::*;
    use crate::encode::bvh::BOX_MARGIN;

    const MARGIN: f32 = 1.0e-5;

    fn primitive(shape: PrimitiveShape, emitter: Option<u32>, size: f32) -> Primitive {
        Primitive {
            shape,
            origin: Vec3::ZERO,
            edge_u: size * vec3(1.0, 0.9, 0.8),
            edge_v: size * vec3(0.97, 0.93, 0.8),
            normals: None,
            uvs: Default::default(),
            flip_normal: false,
            front_only: false,
            unseen: false,
            material: 0,
            emitter,
        }
    }

    /// A slender triangle along the diagonal of its box, between many small triangles.
    fn among_small_ones(large: Primitive) -> Vec<Primitive> {
        let small = primitive(PrimitiveShape::Triangle, None, 0.01);
        (0..100).map(|i| if i == 50 { large } else { small }).collect()
    }

    fn parts(boxes: &Boxes, primitive: u32) -> Vec<Aabb> {
        let parts = boxes.boxes.iter().zip(&boxes.primitives);
        parts.filter(|(_, of)| **of == primitive).map(|(part, _)| *part).collect()
    }

    fn holds(part: &Aabb, point: Vec3A) -> bool {
        part.min.cmple(point).all() && point.cmple(part.max).all()
    }

    #[test]
    fn parts_of_a_slender_triangle_hold_it_and_are_smaller() {
        let primitives = among_small_ones(primitive(PrimitiveShape::Triangle, None, 1.0));
        let boxes = Boxes::new(&primitives, &[], Vec::new(), MARGIN);
        assert!((0..100).all(|i| boxes.primitives[i as usize] == i));
        let parts = parts(&boxes, 50);
        assert!(parts.len() > 4, "{} parts", parts.len());
        assert_eq!(boxes.boxes.len(), 99 + parts.len());
        let area: f32 = parts.iter().map(Aabb::half_area).sum();
        assert!(area < 0.5 * box_of(&primitives[50]).half_area(), "{area}");
        let Triangle { v0, v1, v2 } = triangle(&primitives[50]);
        for i in 0..=100_u8 {
            for j in 0..=100 - i {
                let point = v0 + (v1 - v0) * (f32::from(i) / 100.0) + (v2 - v0) * (f32::from(j) / 100.0);
                assert!(parts.iter().any(|part| holds(part, point)), "{point} is in none");
            }
        }
    }

    #[test]
    fn lights_and_what_fills_its_box_stay_whole() {
        let flat = Primitive { edge_u: Vec3::X, edge_v: Vec3::Y, ..primitive(PrimitiveShape::Triangle, None, 1.0) };
        let light = primitive(PrimitiveShape::Triangle, Some(0), 1.0);
        let disk = primitive(PrimitiveShape::Disk, None, 1.0);
        for large in [flat, light, disk] {
            let boxes = Boxes::new(&among_small_ones(large), &[], Vec::new(), MARGIN);
            assert_eq!(boxes.primitives, (0..100).collect::<Vec<u32>>());
            let (padded, (min, max)) = (boxes.boxes[50], large.bounds());
            assert!(holds(&padded, min.into()) && holds(&padded, max.into()));
        }
    }

    /// Tests triangles far from the origin too, where coordinates are rounded.
    #[test]
    fn parts_of_any_slender_triangle_hold_it() {
        let mut state = 1_u32;
        let mut coordinate = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut split_count = 0;
        for round in 0..20_000_u16 {
            let [edge_u, apart] = [(); 2].map(|()| vec3(coordinate(), coordinate(), coordinate()));
            let edge_v = edge_u + 0.2 * apart;
            let origin = f32::from(round) * vec3(1.0, -0.3, 0.01);
            let large = Primitive { origin, edge_u, edge_v, ..primitive(PrimitiveShape::Triangle, None, 1.0) };
            let grown = Boxes::new(&among_small_ones(large), &[], Vec::new(), BOX_MARGIN);
            split_count += usize::from(grown.boxes.len() > 100);
            let point = origin + 0.5 * (coordinate() + 1.0) * edge_u.lerp(edge_v, 0.5 * (coordinate() + 1.0));
            assert!(parts(&grown, 50).iter().any(|part| holds(part, point.into())), "{large:?} at {point}");
        }
        assert!(split_count > 1000, "{split_count}");
    }
}
