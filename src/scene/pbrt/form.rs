//! Forms of shapes: meshes, files of meshes, spheres and disks.

use std::f64::consts::PI;

use glam::DMat4;

use crate::scene::mesh::{MAX_TRIANGLES, Mesh};

/// Form of a shape in its own space.
#[derive(Debug)]
pub(super) enum Form {
    Mesh(Mesh),
    /// PLY file by its name, which is read with the whole scene.
    Ply {
        name: String,
        has_normals: bool,
    },
    /// Whole sphere around the origin.
    Sphere {
        radius: f64,
    },
    /// Whole disk at a height over the plane of x and y.
    Disk {
        radius: f64,
        height: f64,
    },
}

/// Sentence about a shape with which a scene has more triangles than fit.
pub(super) fn too_many_triangles(so_far: usize) -> String {
    format!("with this shape the scene has {so_far} triangles so far; no more than {MAX_TRIANGLES} fit")
}

impl Form {
    /// Number of triangles in memory.
    pub fn triangle_count(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.triangles.len(),
            Self::Ply { .. } | Self::Sphere { .. } | Self::Disk { .. } => 0,
        }
    }

    /// Number of vertices in memory.
    pub fn vertex_count(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.positions.len(),
            Self::Ply { .. } | Self::Sphere { .. } | Self::Disk { .. } => 0,
        }
    }

    /// Whether vertices have normals, so that the surface is smooth.
    pub fn has_normals(&self) -> bool {
        match self {
            Self::Mesh(mesh) => !mesh.normals.is_empty(),
            Self::Ply { has_normals, .. } => *has_normals,
            Self::Sphere { .. } | Self::Disk { .. } => false,
        }
    }
}

/// Area of a form. As in pbrt, that of a sphere or a disk is the area in its own space.
pub(super) fn own_area(form: &Form) -> Option<f64> {
    match form {
        Form::Sphere { radius } => Some(4.0 * PI * radius * radius),
        Form::Disk { radius, .. } => Some(PI * radius * radius),
        Form::Mesh(_) | Form::Ply { .. } => None,
    }
}

/// Area of each triangle of a mesh in the world.
pub(super) fn triangle_areas(mesh: &Mesh, to_world: &DMat4) -> Vec<f64> {
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|index| to_world.transform_point3(mesh.positions[index as usize].as_dvec3()));
        0.5 * (b - a).cross(c - a).length()
    };
    mesh.triangles.iter().map(area).collect()
}
