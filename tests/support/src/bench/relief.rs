//! Cornell box of relief: the project's Cornell box, with walls divided into any number of triangles with a rough
//! relief.

use glam::Vec3;
use lodestar::scene::{self, LoadOptions, Primitive, PrimitiveShape, Scene};

use crate::scenes_folder;

/// Height of the relief, in sides of the triangles.
const RELIEF: f32 = 0.3;

/// Cornell box with about `count` triangles.
pub fn tessellated(count: usize) -> Scene {
    let path = scenes_folder().join("cornell-box/scene.xml");
    let mut scene = scene::load(&path, &LoadOptions::default()).expect("the scene loads");
    let (lamps, walls): (Vec<_>, Vec<_>) = scene.primitives.into_iter().partition(|shape| shape.emitter.is_some());
    let coarse: Vec<Primitive> = walls.iter().flat_map(triangles).collect();
    let cuts = (count as f32 / coarse.len() as f32).sqrt().round().max(1.0) as u32;
    scene.primitives = coarse.iter().flat_map(|triangle| cut(triangle, cuts)).chain(lamps).collect();
    scene
}

/// Triangles of a flat shape. The sides of a parallelogram are given as halves from its center.
fn triangles(shape: &Primitive) -> Vec<Primitive> {
    let Primitive { origin, edge_u, edge_v, .. } = *shape;
    let triangle = |origin, edge_u, edge_v| Primitive {
        shape: PrimitiveShape::Triangle,
        normals: None,
        origin,
        edge_u,
        edge_v,
        ..*shape
    };
    match shape.shape {
        PrimitiveShape::Parallelogram => vec![
            triangle(origin - edge_u - edge_v, 2.0 * edge_u, 2.0 * edge_v),
            triangle(origin + edge_u + edge_v, -2.0 * edge_u, -2.0 * edge_v),
        ],
        _ => vec![*shape],
    }
}

/// Triangle divided into the square of `cuts` triangles. The relief is zero at its border, so that no light leaks.
fn cut(triangle: &Primitive, cuts: u32) -> impl Iterator<Item = Primitive> {
    let Primitive { origin, edge_u, edge_v, .. } = *triangle;
    let normal = edge_u.cross(edge_v).normalize();
    let height = RELIEF * edge_u.length().min(edge_v.length()) / cuts as f32;
    let vertex = move |i: u32, j: u32| -> Vec3 {
        let inside = i > 0 && j > 0 && i + j < cuts;
        let relief = if inside { height * noise(i, j) } else { 0.0 };
        origin + (edge_u * i as f32 + edge_v * j as f32) / cuts as f32 + normal * relief
    };
    let pattern = *triangle;
    let at = move |a: Vec3, b: Vec3, c: Vec3| Primitive { origin: a, edge_u: b - a, edge_v: c - a, ..pattern };
    (0..cuts).flat_map(move |i| {
        (0..cuts - i).flat_map(move |j| {
            let upright = at(vertex(i, j), vertex(i + 1, j), vertex(i, j + 1));
            let hanging = (i + j + 1 < cuts).then(|| at(vertex(i + 1, j + 1), vertex(i, j + 1), vertex(i + 1, j)));
            std::iter::once(upright).chain(hanging)
        })
    })
}

/// Noise in [-0.5, 0.5), from a hash.
fn noise(i: u32, j: u32) -> f32 {
    let mut bits = i.wrapping_mul(0x9e37_79b9) ^ j.wrapping_mul(0x85eb_ca6b);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
    bits = (bits ^ (bits >> 12)).wrapping_mul(0x297a_2d39);
    ((bits ^ (bits >> 15)) >> 8) as f32 / 16_777_216.0 - 0.5
}
