//! Reader of the forms of shapes.

use std::f64::consts::TAU;

use super::files::{self, Files};
use super::form::Form;
use super::parameters::Parameters;
use super::quadrics::{self, Cylinder, Disk, Sphere};
use super::subdivision;
use super::world::Entity;
use crate::Result;
use crate::scene::mesh::{self, Mesh};

/// Beginning of a PLY file that contains its header.
const HEADER_BYTES: u64 = 1 << 16;

/// Reads the form of a shape. `room` is the most triangles that a subdivision may make.
pub(super) fn read(entity: &Entity, room: usize, files: &mut Files, warnings: &mut Vec<String>) -> Result<Form> {
    let parameters = &entity.parameters;
    parameters.ignore(&["alpha"]);
    let approximate = |what: &str, warnings: &mut Vec<String>| {
        warnings.push(format!("{}: {what} is cut into triangles", parameters.place));
    };
    match entity.kind.as_str() {
        "trianglemesh" => triangle_mesh(parameters).map(Form::Mesh),
        "bilinearmesh" => bilinear_mesh(parameters, warnings).map(Form::Mesh),
        "plymesh" => ply_mesh(parameters, files, warnings),
        "sphere" => {
            let radius = parameters.positive("radius", 1.0)?;
            let z = [parameters.number("zmin", -radius)?, parameters.number("zmax", radius)?];
            let [low, high] = [z[0].min(z[1]).clamp(-radius, radius), z[0].max(z[1]).clamp(-radius, radius)];
            let sphere = Sphere { radius, low, high, angle: angle(parameters)? };
            if sphere == Sphere::whole(radius) {
                return Ok(Form::Sphere { radius });
            }
            approximate("a part of a sphere", warnings);
            Ok(Form::Mesh(quadrics::sphere(&sphere)))
        }
        "disk" => {
            let radius = parameters.positive("radius", 1.0)?;
            let (height, inner) = (parameters.number("height", 0.0)?, parameters.number("innerradius", 0.0)?);
            let disk = Disk { radius, inner, height, angle: angle(parameters)? };
            if disk.inner == 0.0 && disk.angle == TAU {
                return Ok(Form::Disk { radius, height });
            }
            approximate("a part of a disk", warnings);
            Ok(Form::Mesh(quadrics::disk(&disk)))
        }
        "cylinder" => {
            let radius = parameters.positive("radius", 1.0)?;
            let (low, high) = (parameters.number("zmin", -1.0)?, parameters.number("zmax", 1.0)?);
            approximate("a cylinder", warnings);
            Ok(Form::Mesh(quadrics::cylinder(&Cylinder { radius, low, high, angle: angle(parameters)? })))
        }
        "loopsubdiv" => {
            parameters.ignore(&["scheme"]);
            let levels = parameters.integer("levels", 0..=12)?.unwrap_or(3) as u32;
            let control = triangle_mesh(parameters)?;
            let mesh = subdivision::subdivide(&control, levels, room);
            mesh.map(Form::Mesh).map_err(|message| entity.error(format!("`loopsubdiv`: {message}")))
        }
        other @ ("cone" | "paraboloid" | "hyperboloid" | "heightfield" | "nurbs") => Err(entity.error(format!(
            "the shape `{other}` belongs to pbrt-v3 and is not supported; make a mesh of it"
        ))),
        other => Err(entity.error(format!(
            "the shape `{}` is not known; use `trianglemesh`, `plymesh`, `bilinearmesh`, `sphere`, `disk`, `cylinder` or `curve`",
            super::tokens::brief(other)
        ))),
    }
}

/// Angle in radians up to which a surface of revolution reaches.
fn angle(parameters: &Parameters) -> Result<f64> {
    let degrees = parameters.number("phimax", 360.0)?;
    Ok(if degrees >= 360.0 { TAU } else { degrees.max(0.0).to_radians() })
}

fn triangle_mesh(parameters: &Parameters) -> Result<Mesh> {
    parameters.ignore(&["faceIndices", "S"]);
    let mesh = vertices(parameters)?;
    let count = mesh.positions.len();
    let indices = match parameters.indices("indices", count)? {
        Some(indices) => indices,
        None if count == 3 => vec![0, 1, 2],
        None => return Err(parameters.error("a `trianglemesh` needs its parameter \"integer indices\"")),
    };
    let (triangles, rest) = indices.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(parameters.error("the number of `indices` of a `trianglemesh` must be a multiple of 3"));
    }
    with_triangles(parameters, mesh, triangles.to_vec())
}

/// Reads a mesh of bilinear patches as two triangles for each.
fn bilinear_mesh(parameters: &Parameters, warnings: &mut Vec<String>) -> Result<Mesh> {
    parameters.ignore(&["faceIndices"]);
    if let Some(given) = parameters.get("emissionfilename") {
        return Err(given.error("is not supported; use `filename` of the AreaLightSource"));
    }
    let mut mesh = vertices(parameters)?;
    let count = mesh.positions.len();
    let indices = match parameters.indices("indices", count)? {
        Some(indices) => indices,
        None if count == 4 => vec![0, 1, 2, 3],
        None => return Err(parameters.error("a `bilinearmesh` needs its parameter \"integer indices\"")),
    };
    let (patches, rest) = indices.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(parameters.error("the number of `indices` of a `bilinearmesh` must be a multiple of 4"));
    }
    let is_bent = |patch: &[u32; 4]| {
        let [a, b, c, d] = patch.map(|index| mesh.positions[index as usize].as_dvec3());
        let volume = (b - a).cross(c - a).dot(d - a).abs();
        volume > 1.0e-4 * (b - a).length() * (c - a).length() * (d - a).length()
    };
    if patches.iter().any(is_bent) {
        let message = "a bilinear patch whose corners lie in no plane becomes two triangles";
        warnings.push(format!("{}: {message}", parameters.place));
    }
    let mut triangles: Vec<_> = patches.iter().flat_map(|&[a, b, c, d]| [[a, b, d], [a, d, c]]).collect();
    if mesh.uvs.is_empty() {
        // Without coordinates of its own, each patch is a unit square.
        let corners: Vec<u32> = patches.as_flattened().to_vec();
        let square = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(glam::Vec2::from);
        mesh = Mesh {
            positions: corners.iter().map(|&index| mesh.positions[index as usize]).collect(),
            normals: corners.iter().filter_map(|&index| mesh.normals.get(index as usize).copied()).collect(),
            uvs: square.into_iter().cycle().take(corners.len()).collect(),
            ..Mesh::default()
        };
        triangles = (0..patches.len() as u32)
            .map(|patch| 4 * patch)
            .flat_map(|a| [[a, a + 1, a + 3], [a, a + 3, a + 2]])
            .collect();
    }
    with_triangles(parameters, mesh, triangles)
}

fn vertices(parameters: &Parameters) -> Result<Mesh> {
    let positions = parameters.points("P")?;
    if positions.is_empty() {
        return Err(parameters.error(format!("{} needs its parameter \"point3 P\"", parameters.owner)));
    }
    let (normals, uvs) = (parameters.points("N")?, parameters.points_2d("uv")?);
    for (name, given) in [("N", normals.len()), ("uv", uvs.len())] {
        if let (Some(parameter), true) = (parameters.get(name), given != 0 && given < positions.len()) {
            return Err(parameter.error(format!("has {given} values for {} vertices", positions.len())));
        }
    }
    let count = positions.len();
    let cut = |mut normals: Vec<_>| {
        normals.truncate(count);
        normals
    };
    let uvs = uvs.into_iter().take(count).collect();
    Ok(Mesh { positions, normals: cut(normals), uvs, ..Mesh::default() })
}

fn with_triangles(parameters: &Parameters, mesh: Mesh, triangles: Vec<[u32; 3]>) -> Result<Mesh> {
    if triangles.len() > mesh::MAX_TRIANGLES {
        let limit = mesh::MAX_TRIANGLES;
        return Err(parameters.error(format!("a mesh of {} triangles; no more than {limit} fit", triangles.len())));
    }
    Ok(Mesh { triangles, ..mesh })
}

fn ply_mesh(parameters: &Parameters, files: &mut Files, warnings: &mut Vec<String>) -> Result<Form> {
    let name = parameters.text("filename")?;
    let name = name.ok_or_else(|| parameters.error("a `plymesh` needs its parameter \"string filename\""))?;
    if let Some(displacement) = parameters.get("displacement") {
        warnings.push(format!("{}: the displacement of a `plymesh` is not rendered", displacement.place));
    }
    parameters.ignore(&["edgelength"]);
    let path = files.existing(name, "mesh file", &parameters.place)?;
    let (beginning, is_compressed) = files::beginning(&path, HEADER_BYTES)?;
    if is_compressed {
        return mesh::parse_ply(&path, &files.bytes(&path)?).map(Form::Mesh);
    }
    let header = String::from_utf8_lossy(&beginning);
    let header = header.split("end_header").next().unwrap_or_default();
    let has = |name: &str| {
        header
            .lines()
            .any(|line| line.starts_with("property") && line.split_ascii_whitespace().next_back() == Some(name))
    };
    Ok(Form::Ply { name: name.to_owned(), has_normals: has("nx") && has("ny") && has("nz") })
}
