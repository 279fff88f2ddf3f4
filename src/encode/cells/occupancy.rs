//! Places of a grid that hold surfaces.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, UVec3, Vec3};
use rayon::prelude::*;

use super::grid::Grid;
use crate::encode::bvh::instances::{is_instance, motion_of, part_of, placed, shown};
use crate::encode::bvh::{Bvh, is_deforming};
use crate::generated::constants;
use crate::generated::layout::{AttributeRecord, PrimitiveRecord};

/// Margin around a place, in places: more than the rounding of a point moves it.
const MARGIN: f32 = 1.0e-3;
/// Most primitives of instances that are placed one by one. Where there are more, the boxes of a group's parts are placed.
const MOST_PLACED: u64 = 1 << 22;
/// Steps of a motion's segment whose boxes are placed.
const MOTION_STEPS: u32 = 16;

/// Whether a surface may touch each place. Every place that a surface does touch is marked.
pub fn occupied_places(bvh: &Bvh, grid: &Grid) -> Vec<bool> {
    let occupied: Vec<_> = (0..grid.place_count()).map(|_| AtomicBool::new(false)).collect();
    let occupy = |place| {
        let occupied: &AtomicBool = &occupied[grid.index(place)];
        // Many small primitives share a place, and a core that only reads does not take the memory from the others.
        if !occupied.load(Ordering::Relaxed) {
            occupied.store(true, Ordering::Relaxed);
        }
    };
    let of_world = bvh.world_len();
    let (records, attributes) = (&bvh.primitives[..of_world], &bvh.attributes[..of_world]);
    let instances = records.par_iter().filter(|record| bvh.has_instances() && is_instance(record));
    let is_exact = instances.map(|record| part_of(&bvh.parts, record).primitives.len() as u64).sum::<u64>()
        <= MOST_PLACED
        && !has_deforming_parts(bvh);
    records.par_iter().zip(attributes).for_each(|(record, attributes)| match is_instance(record) {
        true => for_touched_by_instance(bvh, grid, record, attributes, is_exact, occupy),
        false if is_deforming(record) => {
            let vertices = bvh.deforming_vertices(record).flatten();
            let empty = [Vec3::INFINITY, Vec3::NEG_INFINITY];
            for_places_of_box(grid, vertices.fold(empty, |[min, max], v| [min.min(v), max.max(v)]), occupy);
        }
        false => for_touched(grid, record, occupy),
    });
    occupied.into_iter().map(AtomicBool::into_inner).collect()
}

/// Whether some triangle deforms that instances show. The boxes of its part hold it at all times.
fn has_deforming_parts(bvh: &Bvh) -> bool {
    bvh.deforms() && bvh.primitives[bvh.world_len()..].iter().any(is_deforming)
}

/// Calls `touch` with every place that the primitive may touch.
fn for_touched(grid: &Grid, primitive: &PrimitiveRecord, mut touch: impl FnMut(UVec3)) {
    let shape = Shape::new(grid, primitive);
    let (min, max) = shape.bounds();
    let (from, to) = (grid.clamped(min - MARGIN), grid.clamped(max + MARGIN));
    if from == to {
        return touch(from);
    }
    Grid::places(from, to).filter(|&place| shape.touches(place)).for_each(&mut touch);
}

/// Calls `touch` with every place that a box touches.
fn for_places_of_box(grid: &Grid, corners: [Vec3; 2], touch: impl FnMut(UVec3)) {
    let [min, max] = corners.map(|corner| grid.coordinates(corner));
    Grid::places(grid.clamped(min - MARGIN), grid.clamped(max + MARGIN)).for_each(touch);
}

/// Calls `touch` with every place that an instance may touch: by its primitives where `is_exact`, else by the boxes that hold them.
fn for_touched_by_instance(
    bvh: &Bvh,
    grid: &Grid,
    record: &PrimitiveRecord,
    placement: &AttributeRecord,
    is_exact: bool,
    touch: impl Fn(UVec3) + Copy,
) {
    let part = part_of(&bvh.parts, record);
    let touch_box = |(min, max): (DVec3, DVec3)| for_places_of_box(grid, [min, max].map(|c| c.as_vec3()), touch);
    if let Some(motion) = motion_of(record).and_then(|first| bvh.motions.at(first)) {
        return part.boxes.iter().flat_map(|&of_group| motion.swept(of_group, MOTION_STEPS)).for_each(touch_box);
    }
    if is_exact {
        let primitives = part.primitives.start as usize..part.primitives.end as usize;
        return bvh.primitives[primitives].iter().for_each(|own| for_touched(grid, &shown(own, placement), touch));
    }
    let instance = placed(placement);
    part.boxes.iter().map(|&of_group| instance.place_box(of_group)).for_each(touch_box);
}

/// Primitive in the grid's coordinates, where places are unit cubes.
enum Shape {
    /// Bounds, a point, and the edges.
    Flat { min: Vec3, max: Vec3, origin: Vec3, edges: [Vec3; 2] },
    /// Center and half axes, and whether surfaces may lie within.
    Ellipsoid { center: Vec3, radii: Vec3, is_full: bool },
}

impl Shape {
    #[inline]
    fn new(grid: &Grid, p: &PrimitiveRecord) -> Self {
        let origin = grid.coordinates(p.origin.into());
        let (u, v) = (Vec3::from(p.edge_u) * grid.per_unit, Vec3::from(p.edge_v) * grid.per_unit);
        let corners = match p.flags & constants::PRIMITIVE_SHAPE_MASK {
            constants::SHAPE_SPHERE => {
                let is_full = p.flags & constants::PRIMITIVE_FACING != 0;
                return Self::Ellipsoid { center: origin, radii: p.edge_tolerance * grid.per_unit, is_full };
            }
            constants::SHAPE_TRIANGLE => [origin, origin + u, origin + v, origin],
            _ => [origin - u - v, origin - u + v, origin + u - v, origin + u + v],
        };
        let [a, b, c, d] = corners;
        let (min, max) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
        Self::Flat { min, max, origin, edges: [u, v] }
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        match *self {
            Self::Flat { min, max, .. } => (min, max),
            Self::Ellipsoid { center, radii, .. } => (center - radii, center + radii),
        }
    }

    /// Whether the shape may touch a place within its bounds. Outermost places also take surfaces beyond the grid.
    fn touches(&self, place: UVec3) -> bool {
        let half = Vec3::splat(0.5 + MARGIN);
        let middle = place.as_vec3() + 0.5;
        match *self {
            Self::Flat { origin, edges: [u, v], .. } => {
                let normal = u.cross(v).normalize_or_zero();
                normal.dot(middle - origin).abs() <= normal.abs().dot(half) + MARGIN
            }
            Self::Ellipsoid { center, radii, is_full } => {
                let away = (middle - center).abs();
                let [nearest, farthest] = [(away - half).max(Vec3::ZERO), away + half];
                (nearest / radii).length_squared() <= 1.0 && (is_full || (farthest / radii).length_squared() >= 1.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Primitive, PrimitiveShape};
    use glam::{Vec2, vec3};

    fn bvh(shape: PrimitiveShape, edges: [Vec3; 2]) -> Bvh {
        let [edge_u, edge_v] = edges;
        let primitive = Primitive {
            shape,
            origin: vec3(0.1, -0.2, 0.3),
            edge_u,
            edge_v,
            normals: None,
            uvs: [Vec2::ZERO; 3],
            flip_normal: false,
            front_only: false,
            unseen: false,
            material: 0,
            emitter: None,
        };
        Bvh::build(&[primitive])
    }

    /// Point of a primitive from two numbers in [0, 1], which cover all of it.
    fn point(shape: PrimitiveShape, [u, v]: [Vec3; 2], [a, b]: [f32; 2]) -> Vec3 {
        let origin = vec3(0.1, -0.2, 0.3);
        let turn = std::f32::consts::TAU * b;
        match shape {
            PrimitiveShape::Triangle if a + b > 1.0 => origin + (1.0 - a) * u + (1.0 - b) * v,
            PrimitiveShape::Triangle => origin + a * u + b * v,
            PrimitiveShape::Parallelogram => origin + (2.0 * a - 1.0) * u + (2.0 * b - 1.0) * v,
            PrimitiveShape::Disk => origin + a * (turn.cos() * u + turn.sin() * v),
            PrimitiveShape::Sphere | PrimitiveShape::FacingDisk => {
                let height = 2.0 * a - 1.0;
                let around = (1.0 - height * height).max(0.0).sqrt();
                origin + u.length() * vec3(around * turn.cos(), around * turn.sin(), height)
            }
        }
    }

    #[test]
    fn every_place_of_a_surface_is_occupied_and_few_others() {
        for shape in
            [PrimitiveShape::Triangle, PrimitiveShape::Parallelogram, PrimitiveShape::Disk, PrimitiveShape::Sphere]
        {
            let edges = [vec3(3.0, 0.5, -0.7), vec3(0.2, 1.4, 0.9)];
            let bvh = bvh(shape, edges);
            let grid = Grid::new(&bvh, UVec3::new(9, 16, 7));
            let occupied = occupied_places(&bvh, &grid);
            let mut touched = vec![false; occupied.len()];
            for i in 0..400 * 400 {
                let at = [i % 400, i / 400].map(|i| i as f32 / 399.0);
                let place = grid.clamped(grid.coordinates(point(shape, edges, at)));
                touched[grid.index(place)] = true;
            }
            assert!(occupied.iter().zip(&touched).all(|(&occupied, &touched)| occupied || !touched), "{shape:?}");
            let [occupied, touched] = [occupied, touched].map(|places| places.into_iter().filter(|&p| p).count());
            assert!(occupied <= 2 * touched, "{shape:?}: {occupied} places for {touched}");
        }
    }

    #[test]
    fn a_disk_that_faces_what_it_lights_may_lie_anywhere_within_its_radius() {
        let edges = [vec3(3.0, 0.5, -0.7), vec3(0.2, 1.4, 0.9)];
        let has_middle = |shape: PrimitiveShape| {
            let bvh = bvh(shape, edges);
            let grid = Grid::new(&bvh, UVec3::new(9, 16, 7));
            let place = grid.clamped(grid.coordinates(vec3(0.1, -0.2, 0.3)));
            occupied_places(&bvh, &grid)[grid.index(place)]
        };
        assert!(has_middle(PrimitiveShape::FacingDisk) && !has_middle(PrimitiveShape::Sphere));
    }
}
