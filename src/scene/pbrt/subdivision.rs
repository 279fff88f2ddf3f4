//! Loop's subdivision of triangle meshes (Loop 1987), with the limits of positions and normals.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;

use crate::scene::mesh::{MAX_TRIANGLES, Mesh};

/// Control mesh, and its refinements.
struct Surface {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

/// Neighbors of a vertex in the order in which they lie around it.
struct Ring {
    points: Vec<u32>,
    /// Whether the first and the last neighbor lie on the mesh's border.
    is_border: bool,
}

/// Mesh after `levels` refinements, with its vertices on the limit surface. `room` is the most triangles that it may have: those
/// that the scene's other shapes leave of [`MAX_TRIANGLES`]. The error says why there is no mesh.
pub(super) fn subdivide(control: &Mesh, levels: u32, room: usize) -> Result<Mesh, String> {
    let count = control.triangles.len().max(1) as u128;
    let others = (MAX_TRIANGLES - room.min(MAX_TRIANGLES)) as u128;
    let all = 4_u128.checked_pow(levels).and_then(|factor| factor.checked_mul(count)?.checked_add(others));
    if all.is_none_or(|all| all - others > room as u128) {
        let all = all.map_or_else(|| format!("more than {}", u128::MAX), |all| all.to_string());
        return Err(format!(
            "with {levels} levels the scene has {all} triangles so far, but no more than {MAX_TRIANGLES} fit; use fewer"
        ));
    }
    let points = control.positions.iter().map(|position| position.as_dvec3()).collect();
    let mut surface = Surface { points, triangles: control.triangles.clone() };
    for _ in 0..levels {
        surface = surface.refined()?;
    }
    surface.limit()
}

impl Surface {
    /// Rings of all vertices; an empty one where no triangle has the vertex.
    fn rings(&self) -> Result<Vec<Ring>, String> {
        let mut next: Vec<Vec<[u32; 2]>> = vec![Vec::new(); self.points.len()];
        for &[a, b, c] in &self.triangles {
            next[a as usize].push([b, c]);
            next[b as usize].push([c, a]);
            next[c as usize].push([a, b]);
        }
        next.iter().map(|pairs| ring(pairs)).collect()
    }

    /// Surface with four triangles for each.
    fn refined(&self) -> Result<Self, String> {
        let rings = self.rings()?;
        let mut points: Vec<DVec3> = (0..self.points.len()).map(|vertex| self.even(vertex, &rings[vertex])).collect();
        // Corners opposite of each edge, and the vertex on it.
        let mut edges: HashMap<[u32; 2], (Vec<u32>, u32)> = HashMap::new();
        for &[a, b, c] in &self.triangles {
            for [from, to, opposite] in [[a, b, c], [b, c, a], [c, a, b]] {
                let fresh = points.len() as u32 + edges.len() as u32;
                edges.entry([from.min(to), from.max(to)]).or_insert((Vec::new(), fresh)).0.push(opposite);
            }
        }
        let at = |index: u32| self.points[index as usize];
        let mut odd = vec![DVec3::ZERO; edges.len()];
        for (&[a, b], (opposite, index)) in &edges {
            odd[*index as usize - self.points.len()] = match opposite[..] {
                [c, d] => 0.375 * (at(a) + at(b)) + 0.125 * (at(c) + at(d)),
                _ => 0.5 * (at(a) + at(b)),
            };
        }
        points.extend(odd);
        let middle = |a: u32, b: u32| edges[&[a.min(b), a.max(b)]].1;
        let split = |&[a, b, c]: &[u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        Ok(Self { points, triangles: self.triangles.iter().flat_map(split).collect() })
    }

    /// New place of an old vertex.
    fn even(&self, vertex: usize, ring: &Ring) -> DVec3 {
        self.weighted(vertex, ring, 0.125, beta(ring.points.len()))
    }

    /// The vertex moved towards its neighbors. `border` and `inner` are the weights of each neighbor that counts.
    fn weighted(&self, vertex: usize, ring: &Ring, border: f64, inner: f64) -> DVec3 {
        let at = |index: u32| self.points[index as usize];
        let (weight, sum, count) = match (&ring.points[..], ring.is_border) {
            ([first, .., last], true) => (border, at(*first) + at(*last), 2),
            (points, _) => (inner, points.iter().map(|&index| at(index)).sum(), points.len()),
        };
        (1.0 - weight * count as f64) * self.points[vertex] + weight * sum
    }

    /// Mesh of the points of the limit surface and their normals.
    fn limit(&self) -> Result<Mesh, String> {
        let rings = self.rings()?;
        let mut facing = vec![DVec3::ZERO; self.points.len()];
        for &triangle in &self.triangles {
            let [a, b, c] = triangle.map(|index| self.points[index as usize]);
            let normal = (b - a).cross(c - a);
            triangle.iter().for_each(|&index| facing[index as usize] += normal);
        }
        let mut mesh = Mesh { triangles: self.triangles.clone(), ..Mesh::default() };
        for (vertex, ring) in rings.iter().enumerate() {
            let valence = ring.points.len();
            let gamma = 1.0 / (valence as f64 + 3.0 / (8.0 * beta(valence)));
            mesh.positions.push(self.weighted(vertex, ring, 0.2, gamma).as_vec3());
            let normal = self.normal(vertex, ring);
            let normal = if normal.dot(facing[vertex]) < 0.0 { -normal } else { normal };
            mesh.normals.push(normal.normalize_or_zero().as_vec3());
        }
        Ok(mesh)
    }

    /// Normal of the limit surface, of any length and on either side.
    fn normal(&self, vertex: usize, ring: &Ring) -> DVec3 {
        let at = |index: usize| self.points[ring.points[index] as usize];
        let valence = ring.points.len();
        if valence < 2 {
            return DVec3::ZERO;
        }
        if !ring.is_border {
            let turn = |index: usize| index as f64 / valence as f64 * TAU;
            let sum = |wave: fn(f64) -> f64| (0..valence).map(|index| wave(turn(index)) * at(index)).sum::<DVec3>();
            return sum(f64::cos).cross(sum(f64::sin));
        }
        // Along the border, and across it.
        let along = at(valence - 1) - at(0);
        let own = self.points[vertex];
        let across = match valence {
            2 => at(0) + at(1) - 2.0 * own,
            3 => at(1) - own,
            4 => -at(0) + 2.0 * at(1) + 2.0 * at(2) - at(3) - 2.0 * own,
            _ => {
                let step = 0.5 * TAU / (valence - 1) as f64;
                let inner =
                    (1..valence - 1).map(|index| (2.0 * step.cos() - 2.0) * (index as f64 * step).sin() * at(index));
                -(step.sin() * (at(0) + at(valence - 1)) + inner.sum::<DVec3>())
            }
        };
        along.cross(across)
    }
}

/// Weight of each neighbor of a vertex with this number of neighbors.
fn beta(valence: usize) -> f64 {
    match valence {
        3 => 3.0 / 16.0,
        valence => 3.0 / (8.0 * valence.max(1) as f64),
    }
}

/// Ring of the triangles of one vertex, of which each leads from one neighbor to the next.
fn ring(pairs: &[[u32; 2]]) -> Result<Ring, String> {
    let fault =
        || "the control mesh has an edge of more than two triangles, or triangles that face both ways".to_owned();
    let mut next = HashMap::with_capacity(pairs.len());
    let mut has_previous = std::collections::HashSet::with_capacity(pairs.len());
    for &[from, to] in pairs {
        if next.insert(from, to).is_some() || !has_previous.insert(to) {
            return Err(fault());
        }
    }
    let begin = pairs.iter().map(|pair| pair[0]).find(|from| !has_previous.contains(from));
    let is_border = begin.is_some();
    let Some(first) = begin.or_else(|| pairs.first().map(|pair| pair[0])) else {
        return Ok(Ring { points: Vec::new(), is_border: false });
    };
    let mut points = vec![first];
    while let Some(&to) = points.last().and_then(|last| next.get(last)) {
        if to == first {
            break;
        }
        points.push(to);
        if points.len() > pairs.len() + 1 {
            return Err(fault());
        }
    }
    match points.len() == pairs.len() + usize::from(is_border) {
        true => Ok(Ring { points, is_border }),
        false => Err(fault()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn octahedron() -> Mesh {
        let positions = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z].to_vec();
        let top = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2]];
        let bottom = top.map(|[a, b, _]| [b, a, 5]);
        Mesh { positions, triangles: [top, bottom].concat(), ..Mesh::default() }
    }

    /// The limit of the octahedron's corners, by hand: the neighbors of one have the sum 0, so the corner shrinks by 1 - 4 gamma.
    #[test]
    fn corners_go_to_their_limits() {
        let mesh = subdivide(&octahedron(), 3, MAX_TRIANGLES).unwrap();
        assert_eq!(mesh.triangles.len(), 8 * 64);
        let gamma = 1.0 / (4.0 + 3.0 / (8.0 * beta(4)));
        let expected = 1.0 - 4.0 * gamma;
        for (corner, &unit) in octahedron().positions.iter().enumerate() {
            assert!((mesh.positions[corner] - unit * expected as f32).length() < 1e-6, "{}", mesh.positions[corner]);
            assert!((mesh.normals[corner] - unit).length() < 1e-6);
        }
        // Each level has the same limit.
        let corner = subdivide(&octahedron(), 0, MAX_TRIANGLES).unwrap().positions[0];
        assert!((corner - mesh.positions[0]).length() < 1e-6);
    }

    /// A flat square stays flat, and its border stays straight but for the corners.
    #[test]
    fn borders_stay() {
        let positions: Vec<Vec3> = (0..25).map(|i| Vec3::new((i % 5) as f32, (i / 5) as f32, 0.0)).collect();
        let corner = |x: u32, y: u32| 5 * y + x;
        let squares = (0..16).map(|i| (i % 4, i / 4));
        let triangles = squares
            .flat_map(|(x, y)| {
                let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let mesh = subdivide(&Mesh { positions, triangles, ..Mesh::default() }, 2, MAX_TRIANGLES).unwrap();
        for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
            assert!(position.z == 0.0 && (*normal - Vec3::Z).length() < 1e-6, "{position} {normal}");
            assert!(position.cmpge(Vec3::splat(-1e-6)).all() && position.max_element() < 4.0 + 1e-6);
        }
        assert!((mesh.positions[2] - Vec3::new(2.0, 0.0, 0.0)).length() < 1e-6);
    }

    #[test]
    fn what_is_refused() {
        let mut mesh = octahedron();
        mesh.triangles.push([0, 1, 3]);
        assert!(subdivide(&mesh, 1, MAX_TRIANGLES).is_err());
        assert!(subdivide(&octahedron(), 60, MAX_TRIANGLES).is_err());
        assert!(subdivide(&octahedron(), 1, 32).is_ok() && subdivide(&octahedron(), 1, 31).is_err());
    }
}
