//! Triangle meshes, as every reader of mesh files makes them.

use earcut::Earcut;
use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::scene::deformation::MOST_INTERVALS;

/// Most triangles of a scene, copies of instances included. Devices can address this many at three texels each.
pub(in crate::scene) const MAX_TRIANGLES: usize = 1 << 25;

/// One mesh. Vertices that differ in any attribute are kept apart, as in Mitsuba, so that smooth normals do not cross
/// texture seams.
#[derive(Debug, Default)]
pub(in crate::scene) struct Mesh {
    pub positions: Vec<Vec3>,
    /// One normal per vertex, of any length, zero where the file gives none; empty where no vertex has one.
    pub normals: Vec<Vec3>,
    /// One texture coordinate per vertex, as in the file; empty where it has none.
    pub uvs: Vec<Vec2>,
    /// One color per vertex, as in the file; empty where it has none. They may be no numbers.
    pub colors: Vec<Vec3>,
    /// Other numbers and colors of vertices and faces that textures show.
    pub attributes: Vec<MeshAttribute>,
    /// Whether the file gives the colors as whole numbers, of which the largest stands for 1.
    pub has_byte_colors: bool,
    /// Largest distance from the surface that the mesh stands for, in radii of its tubes; 0 where the mesh is the surface.
    pub deviation: f32,
    /// Number of faces of the file that are points or lines, which are left out.
    pub left_out: usize,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Numbers or colors of the vertices or the triangles of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::scene) struct MeshAttribute {
    /// Mitsuba's name: one that begins with `face_` has a value for each triangle, another for each vertex.
    pub name: String,
    /// Values; a number counts as a gray color. They may be no numbers.
    pub values: Vec<Vec3>,
}

impl Mesh {
    /// Colors of a triangle's corners by the attribute of that name; `None` where the mesh does not have it.
    pub fn corner_colors(&self, attribute: &str, triangle: usize) -> Option<[Vec3; 3]> {
        let values = self.values_of(attribute)?;
        match attribute.starts_with("face_") {
            true => values.get(triangle).map(|&value| [value; 3]),
            false => Some(self.triangles.get(triangle)?.map(|vertex| values[vertex as usize])),
        }
    }

    /// Values of the attribute of that name, as Mitsuba calls it; `None` where the mesh does not have it.
    pub fn values_of(&self, attribute: &str) -> Option<&[Vec3]> {
        if attribute == VERTEX_COLOR {
            return (!self.colors.is_empty()).then_some(&self.colors);
        }
        let found = self.attributes.iter().find(|own| own.name == attribute)?;
        Some(&found.values)
    }
}

/// Places of a mesh's vertices at another time than the first.
pub(in crate::scene) struct VertexSet<'a> {
    pub positions: &'a [Vec3],
    /// One normal per vertex, of any length; empty where the file gives none.
    pub normals: &'a [Vec3],
}

impl Mesh {
    /// Places of the vertices at evenly spaced times after the first; none where the mesh keeps its shape. These are the attributes
    /// `position1`, `position2` and so on, and `normal1`, `normal2` and so on.
    pub fn later_sets(&self) -> Vec<VertexSet<'_>> {
        let sets = (1..=MOST_INTERVALS).map(|at| {
            let positions = self.values_of(&set_attribute("position", at))?;
            Some(VertexSet { positions, normals: self.values_of(&set_attribute("normal", at)).unwrap_or(&[]) })
        });
        sets.map_while(|set| set).collect()
    }
}

/// Name of the attribute that has the positions or the normals of a later set of vertices.
pub(in crate::scene) fn set_attribute(kind: &str, at: usize) -> String {
    format!("vertex_{kind}{at}")
}

/// Mitsuba's name of the colors of vertices.
pub(in crate::scene) const VERTEX_COLOR: &str = "vertex_color";

/// Most corners of a concave polygon. The time that its cutting takes grows with their square.
const MOST_CORNERS: usize = 1 << 16;

/// Cutter of polygons into triangles.
#[derive(Default)]
pub(in crate::scene) struct Cutter {
    earcut: Earcut<f64>,
    corners: Vec<[f64; 2]>,
    indices: Vec<u32>,
    /// Number of faces that were points or lines, and were left out.
    pub left_out: usize,
}

impl Cutter {
    /// Adds the triangles of a polygon of vertices. A convex one is cut around its first vertex, and a concave one by its ears. A face that
    /// is a point or a line is left out.
    ///
    /// # Errors
    /// Where a concave polygon has more than [`MOST_CORNERS`].
    pub fn add(&mut self, triangles: &mut Vec<[u32; 3]>, polygon: &[u32], positions: &[Vec3]) -> Result<(), String> {
        match polygon {
            [] | [_] | [_, _] => self.left_out += 1,
            [a, b, c] => triangles.push([*a, *b, *c]),
            _ if self.is_concave(polygon, positions) => {
                if polygon.len() > MOST_CORNERS {
                    return Err(format!("a concave face has more than {MOST_CORNERS} corners; cut it into triangles"));
                }
                self.earcut.earcut(self.corners.iter().copied(), &[], &mut self.indices);
                // The cutter's triangles all turn counterclockwise, and so does the polygon in the plane of its corners.
                let (found, _) = self.indices.as_chunks::<3>();
                triangles.extend(found.iter().map(|&[a, b, c]| {
                    let [pa, pb, pc] = [a, b, c].map(|at| DVec2::from_array(self.corners[at as usize]));
                    let turns_left = (pb - pa).perp_dot(pc - pa) >= 0.0;
                    let [a, b, c] = [a, b, c].map(|at| polygon[at as usize]);
                    if turns_left { [a, b, c] } else { [a, c, b] }
                }));
            }
            _ => triangles.extend(polygon[1..].windows(2).map(|pair| [polygon[0], pair[0], pair[1]])),
        }
        Ok(())
    }

    /// Whether some corner of a polygon turns against the others. Then `corners` are those of its projection along an axis, in which it
    /// turns counterclockwise.
    fn is_concave(&mut self, polygon: &[u32], positions: &[Vec3]) -> bool {
        let count = polygon.len();
        // A position may be missing where the file is faulty, which is told later.
        let at = |index: usize| {
            positions.get(polygon[index % count] as usize).map(|position| position.as_dvec3()).unwrap_or_default()
        };
        let first = at(0);
        let normal: DVec3 = (1..count - 1).map(|i| (at(i) - first).cross(at(i + 1) - first)).sum();
        let turn = |i: usize| (at(i + 1) - at(i)).cross(at(i + 2) - at(i + 1)).dot(normal);
        // Rounding must not make a flat corner a concave one.
        let least = -1.0e-5 * normal.length_squared();
        if !normal.is_finite() || (0..count).all(|i| turn(i) >= least) {
            return false;
        }
        let [x, y, z] = normal.abs().to_array();
        let plane = |p: DVec3| match (x >= y && x >= z, y >= z) {
            (true, _) if normal.x > 0.0 => [p.y, p.z],
            (true, _) => [p.z, p.y],
            (_, true) if normal.y > 0.0 => [p.z, p.x],
            (_, true) => [p.x, p.z],
            _ if normal.z > 0.0 => [p.x, p.y],
            _ => [p.y, p.x],
        };
        self.corners.clear();
        self.corners.extend((0..count).map(|index| plane(at(index))));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area of the triangles, seen along the normal of their plane.
    fn area(triangles: &[[u32; 3]], positions: &[Vec3]) -> f32 {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|index| positions[index as usize]);
            0.5 * (b - a).cross(c - a)
        };
        triangles.iter().map(|t| area(t).dot(Vec3::new(1.0, 2.0, 3.0).normalize()).abs()).sum()
    }

    /// An L of six corners, begun at each of them, turned both ways, in a plane that leans.
    #[test]
    fn concave_polygons_keep_their_area() {
        let flat = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let normal = Vec3::new(1.0, 2.0, 3.0).normalize();
        let (x, y) = normal.any_orthonormal_pair();
        let positions = flat.map(|[a, b]| Vec3::splat(7.0) + a * x + b * y);
        for first in 0..6 {
            for backward in [false, true] {
                let mut polygon: Vec<u32> = (0..6).map(|i| (first + i) % 6).collect();
                if backward {
                    polygon.reverse();
                }
                let (mut triangles, mut cutter) = (Vec::new(), Cutter::default());
                cutter.add(&mut triangles, &polygon, &positions).unwrap();
                assert_eq!((triangles.len(), cutter.left_out), (4, 0));
                assert!((area(&triangles, &positions) - 3.0).abs() < 1e-5, "{first}: {}", area(&triangles, &positions));
                for [a, b, c] in triangles.iter().map(|t| t.map(|index| positions[index as usize])) {
                    let turn = (b - a).cross(c - a).dot(normal);
                    assert!(if backward { turn < 0.0 } else { turn > 0.0 }, "{first}: {turn}");
                }
            }
        }
    }

    #[test]
    fn convex_polygons_are_fans_and_lines_are_left_out() {
        let positions = [[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [1.0, 2.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let (mut triangles, mut cutter) = (Vec::new(), Cutter::default());
        cutter.add(&mut triangles, &[0, 1, 2, 3], &positions).unwrap();
        cutter.add(&mut triangles, &[0, 1], &positions).unwrap();
        cutter.add(&mut triangles, &[], &positions).unwrap();
        // Corners on one line, or all in one place, are no reason to cut otherwise.
        cutter.add(&mut triangles, &[0, 0, 0, 0], &positions).unwrap();
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3], [0, 0, 0], [0, 0, 0]]);
        assert_eq!(cutter.left_out, 2);
    }
}
