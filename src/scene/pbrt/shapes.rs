//! Shapes as objects, with their meshes.

use std::sync::Arc;

use glam::{DMat4, DVec3, Vec2, Vec3};

use super::area_lights::AreaLight;
use super::form::{Form, own_area, too_many_triangles, triangle_areas};
use super::materials::{Cover, Materials};
use super::media::Media;
use super::names::Names;
use super::quadrics::{self, Disk, Sphere};
use super::textures::Textures;
use super::transforms::{is_mirrored, rigid};
use super::world::{Entity, Shape, World};
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{nested, object};
use crate::scene::description::object::{MESH, Object, Value};
use crate::scene::mesh::{self, MAX_TRIANGLES, Mesh, Strand};

/// Most different areas of the triangles of one light whose `power` is given: each makes an emitter of its own.
const MAX_AREAS: usize = 4096;
/// Distance between the two sides of a light that emits from both, as a share of its size.
const GAP: f64 = 1.0e-4;

/// Shapes as objects.
pub(super) struct Shapes<'l> {
    names: &'l Names,
    media: &'l Media,
    /// Factor of all light.
    exposure: f64,
    world: &'l World,
    triangle_count: usize,
}

/// Shape on the way to an object.
struct Placed<'s> {
    entity: &'s Entity,
    form: Form,
    to_world: DMat4,
    /// Transform at the end of the motion, where it is another.
    at_end: Option<DMat4>,
    is_reversed: bool,
    cover: Cover,
}

impl<'l> Shapes<'l> {
    pub fn new(names: &'l Names, media: &'l Media, exposure: f64, world: &'l World) -> Self {
        Self { names, media, exposure, world, triangle_count: 0 }
    }

    /// Objects of a shape: one, or several where it emits from both sides or where triangles differ in radiance.
    pub fn objects(
        &mut self,
        shape: Shape,
        materials: &mut Materials,
        textures: &mut Textures,
    ) -> Result<Vec<(String, Object)>> {
        let Shape { form, tubes, entity, is_reversed, material, light, media } = shape;
        let is_tubular = !tubes.is_empty();
        let form = if is_tubular { tubular(tubes, &entity, textures)? } else { form };
        let cover = materials.cover(&material, entity.parameters.get("alpha"), textures)?;
        // Fibers are seen from outside only.
        let is_reversed = is_reversed && !(cover.is_hair && is_tubular);
        if cover.is_hair && !is_tubular {
            check_hair(&entity, textures)?;
        }
        if let (Some(alpha), Some(_)) = (entity.parameters.get("alpha"), &light)
            && alpha.kind == "float"
            && alpha.number()? == 0.0
        {
            let message = "a light with an `alpha` of 0 lights the scene, but is seen by the camera and in mirrors; pbrt's is not";
            textures.images.warn(&alpha.place, message);
        }
        let light = light.map(|light| AreaLight::read(&light, self.exposure, textures)).transpose()?;
        let interior = cover.interior.clone();
        let is_textured = cover.is_textured || light.as_ref().is_some_and(AreaLight::is_textured);
        let label = self.names.label(&entity.parameters.place, &format!("shape `{}`", entity.kind));
        let (to_world, at_end) = (entity.to_world.matrix, entity.at_end.map(|end| end.matrix));
        let needs_mesh = light.as_ref().is_some_and(|light| light.is_two_sided || light.has_power());
        let form = prepared(form, &entity, is_textured, needs_mesh, textures)?;
        let placed = Placed { entity: &entity, form, to_world, at_end, is_reversed, cover };
        let parts = match &light {
            None => vec![(placed, None)],
            Some(light) => lit(placed, light, textures)?,
        };
        parts
            .into_iter()
            .map(|(part, emitter)| {
                let shape = self.object(part, emitter)?;
                Ok(self.names.entry(label.clone(), &entity.kind, self.media.around(shape, &media, interior.as_deref())))
            })
            .collect()
    }

    fn object(&mut self, placed: Placed, emitter: Option<Object>) -> Result<Object> {
        let Placed { entity, form, mut to_world, mut at_end, is_reversed, cover } = placed;
        let mirrored = is_mirrored(&to_world);
        let has_normals = form.has_normals();
        // In pbrt the normals that a mesh gives decide which side is the front, and else the order of its vertices before they
        // are transformed.
        let mut flips = is_reversed ^ (mirrored && !has_normals);
        let mut shape = match form {
            Form::Mesh(mesh) => {
                self.count(&mesh, entity)?;
                let shape = object(Kind::Shape, "mesh", [("face_normals", Value::Boolean(!has_normals))]);
                shape.with(MESH, Value::Mesh(Arc::new(mesh)))
            }
            Form::Ply { name, .. } => object(
                Kind::Shape,
                "ply",
                [("filename", Value::Text(name)), ("face_normals", Value::Boolean(!has_normals))],
            ),
            Form::Sphere { radius } => {
                flips = is_reversed ^ mirrored;
                if cover.is_textured {
                    // pbrt's v runs from the lowest z up, Mitsuba's down.
                    let turned = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
                    to_world *= turned;
                    at_end = at_end.map(|end| end * turned);
                    flips = !flips;
                }
                object(Kind::Shape, "sphere", [("radius", Value::Float(radius))])
            }
            Form::Disk { radius, height } => {
                flips = is_reversed;
                to_world *=
                    DMat4::from_translation(DVec3::Z * height) * DMat4::from_scale(DVec3::new(radius, radius, 1.0));
                object(Kind::Shape, "disk", [])
            }
        };
        shape = shape.with("flip_normals", Value::Boolean(flips));
        if to_world != DMat4::IDENTITY || at_end.is_some() {
            shape = shape.with("to_world", self.world.placed(&to_world, at_end.as_ref()));
        }
        shape = shape.with("bsdf", Value::Reference(cover.id.clone()));
        if let Some(emitter) = emitter {
            shape = shape.with("emitter", nested(emitter));
        }
        Ok(shape)
    }

    /// Counts the triangles of a mesh.
    fn count(&mut self, mesh: &Mesh, entity: &Entity) -> Result<()> {
        self.triangle_count += mesh.triangles.len();
        match self.triangle_count > MAX_TRIANGLES {
            true => Err(entity.error(too_many_triangles(self.triangle_count))),
            false => Ok(()),
        }
    }
}

/// Refuses hair on a ribbon, and warns where a shape of hair is no tube.
fn check_hair(entity: &Entity, textures: &mut Textures) -> Result<()> {
    if entity.kind == "curve" {
        return Err(
            entity.error("the material `hair` on a `ribbon` is not supported; make the curve `flat` or `cylinder`")
        );
    }
    let message = "the material `hair` is made for curves: here a ray meets its fiber by the angle to the normal, not by `v`, \
                   and a mesh from outside only";
    textures.images.warn(&entity.parameters.place, message);
    Ok(())
}

/// Mesh of tubes. In pbrt, `u` runs along a curve, and `v` across it.
fn tubular(tubes: Vec<Strand>, entity: &Entity, textures: &mut Textures) -> Result<Form> {
    let message = "curves are read as tubes of triangles; a flat one is shaded as a tube, too";
    textures.images.warn(&entity.parameters.place, message);
    let mut mesh = mesh::of_strands(tubes).map_err(|message| entity.error(message))?;
    let percent = 100.0 * mesh.deviation;
    if percent > 1.5 {
        let message = format!(
            "these are many curves, so their tubes are coarser: up to {percent:.0} % of the radius from the surface"
        );
        textures.images.warn(&entity.parameters.place, &message);
    }
    mesh.uvs.iter_mut().for_each(|uv| *uv = Vec2::new(uv.y, uv.x));
    Ok(Form::Mesh(mesh))
}

/// The form as Mitsuba's shapes can have it: what they lack becomes a mesh.
fn prepared(form: Form, entity: &Entity, is_textured: bool, needs_mesh: bool, textures: &mut Textures) -> Result<Form> {
    let mut warn = |message: &str| textures.images.warn(&entity.parameters.place, message);
    Ok(match form {
        Form::Sphere { radius }
            if [Some(entity.to_world), entity.at_end].iter().flatten().any(|own| rigid(&own.matrix).is_none()) =>
        {
            warn("a sphere that is scaled unevenly is cut into triangles");
            Form::Mesh(quadrics::sphere(&Sphere::whole(radius)))
        }
        Form::Disk { radius, height } if is_textured || entity.at_end.is_some() => {
            warn(match is_textured {
                true => "a disk with a texture is cut into triangles",
                false => "a disk that moves is cut into triangles",
            });
            let disk = Disk { radius, inner: 0.0, height, angle: std::f64::consts::TAU };
            Form::Mesh(quadrics::disk(&disk))
        }
        Form::Ply { name, has_normals } if is_textured || needs_mesh => {
            let path = textures.images.files.existing(&name, "mesh file", &entity.parameters.place)?;
            let mesh = mesh::parse_ply(&path, &textures.images.files.bytes(&path)?)?;
            match is_textured && mesh.uvs.is_empty() {
                true => Form::Mesh(with_uvs(mesh)),
                false if needs_mesh => Form::Mesh(mesh),
                false => Form::Ply { name, has_normals },
            }
        }
        Form::Mesh(mesh) if is_textured && mesh.uvs.is_empty() => Form::Mesh(with_uvs(mesh)),
        form => form,
    })
}

/// The mesh with pbrt's texture coordinates of triangles that have none.
fn with_uvs(mesh: Mesh) -> Mesh {
    let corners: Vec<usize> = mesh.triangles.as_flattened().iter().map(|&index| index as usize).collect();
    let triangle = [Vec2::ZERO, Vec2::X, Vec2::ONE];
    Mesh {
        positions: corners.iter().map(|&index| mesh.positions[index]).collect(),
        normals: corners.iter().filter_map(|&index| mesh.normals.get(index).copied()).collect(),
        uvs: triangle.into_iter().cycle().take(corners.len()).collect(),
        triangles: (0..mesh.triangles.len() as u32).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect(),
        ..Mesh::default()
    }
}

/// Parts of a shape that emits, with their emitters.
fn lit<'s>(
    placed: Placed<'s>,
    light: &AreaLight,
    textures: &mut Textures,
) -> Result<Vec<(Placed<'s>, Option<Object>)>> {
    let size = diagonal(&placed.form);
    let mut parts = Vec::new();
    for (part, area) in by_area(placed, light)? {
        let emitter = light.emitter(area, textures)?;
        if light.is_two_sided {
            parts.push((back(&part, size), Some(emitter.clone())));
        }
        parts.push((part, Some(emitter)));
    }
    Ok(parts)
}

/// Parts of a shape whose lights have one radiance each. In pbrt, each triangle of a mesh is a light with the whole `power`.
fn by_area<'s>(placed: Placed<'s>, light: &AreaLight) -> Result<Vec<(Placed<'s>, f64)>> {
    if !light.has_power() {
        return Ok(vec![(placed, 1.0)]);
    }
    let Form::Mesh(mesh) = &placed.form else {
        let area = own_area(&placed.form).unwrap_or(1.0);
        return Ok(vec![(placed, area)]);
    };
    let areas = triangle_areas(mesh, &placed.to_world);
    let mut groups: Vec<(f64, Vec<[u32; 3]>)> = Vec::new();
    let mut order: Vec<usize> = (0..areas.len()).filter(|&index| areas[index] > 0.0).collect();
    order.sort_by(|&a, &b| areas[a].total_cmp(&areas[b]));
    for index in order {
        match groups.last_mut() {
            Some((area, group)) if areas[index] <= *area * (1.0 + 1.0e-5) => group.push(mesh.triangles[index]),
            _ => groups.push((areas[index], vec![mesh.triangles[index]])),
        }
    }
    if groups.len() > MAX_AREAS {
        let message = format!(
            "the `power` of a light holds for each triangle, and these have {} different areas; give `L`",
            groups.len()
        );
        return Err(placed.entity.error(message));
    }
    let part = |(area, triangles): (f64, Vec<[u32; 3]>)| {
        let form = Form::Mesh(part_of(mesh, triangles));
        let Placed { entity, to_world, at_end, is_reversed, ref cover, .. } = placed;
        (Placed { entity, form, to_world, at_end, is_reversed, cover: cover.clone() }, area)
    };
    Ok(groups.into_iter().map(part).collect())
}

/// Some triangles of a mesh, with the vertices that they use.
fn part_of(mesh: &Mesh, mut triangles: Vec<[u32; 3]>) -> Mesh {
    let mut used = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    for index in triangles.as_flattened_mut() {
        *index = used.partition_point(|&other| other < *index) as u32;
    }
    Mesh {
        positions: at(&mesh.positions, &used),
        normals: at(&mesh.normals, &used),
        uvs: at(&mesh.uvs, &used),
        triangles,
        ..Mesh::default()
    }
}

/// Values of these vertices; none where the mesh has no such values.
fn at<T: Copy>(values: &[T], vertices: &[u32]) -> Vec<T> {
    vertices.iter().filter_map(|&vertex| values.get(vertex as usize).copied()).collect()
}

/// Diagonal of the box around a mesh; 0 for other forms.
fn diagonal(form: &Form) -> f64 {
    let Form::Mesh(mesh) = form else { return 0.0 };
    let low = mesh.positions.iter().copied().reduce(Vec3::min).unwrap_or_default();
    let high = mesh.positions.iter().copied().reduce(Vec3::max).unwrap_or_default();
    f64::from((high - low).length())
}

/// The other side of a shape, a little behind it. `size` is the [`diagonal`] of the whole shape.
fn back<'s>(front: &Placed<'s>, size: f64) -> Placed<'s> {
    let (form, offset) = match &front.form {
        Form::Mesh(mesh) => (Form::Mesh(behind(mesh, size, front.is_reversed)), DMat4::IDENTITY),
        // The inside of a sphere.
        Form::Sphere { radius } => {
            let side = if front.is_reversed { 1.0 } else { -1.0 };
            (Form::Sphere { radius: radius * (1.0 + side * GAP) }, DMat4::IDENTITY)
        }
        Form::Disk { radius, height } => {
            let side = if front.is_reversed { 1.0 } else { -1.0 };
            (Form::Disk { radius: *radius, height: height + side * GAP * radius }, DMat4::IDENTITY)
        }
        Form::Ply { name, has_normals } => {
            (Form::Ply { name: name.clone(), has_normals: *has_normals }, DMat4::IDENTITY)
        }
    };
    Placed {
        entity: front.entity,
        form,
        to_world: front.to_world * offset,
        at_end: front.at_end.map(|end| end * offset),
        is_reversed: !front.is_reversed,
        cover: front.cover.clone(),
    }
}

/// The mesh with its vertices moved behind the front by a small share of `size`.
fn behind(mesh: &Mesh, size: f64, is_reversed: bool) -> Mesh {
    let position = |index: u32| mesh.positions[index as usize].as_dvec3();
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for &[a, b, c] in &mesh.triangles {
        let normal = (position(b) - position(a)).cross(position(c) - position(a));
        let given = |index: u32| mesh.normals.get(index as usize).map_or(normal, |normal| normal.as_dvec3());
        let normal = normal * (normal.dot(given(a) + given(b) + given(c))).signum();
        [a, b, c].into_iter().for_each(|index| normals[index as usize] += normal);
    }
    let gap = GAP * size * if is_reversed { 1.0 } else { -1.0 };
    let moved = mesh.positions.iter().zip(&normals);
    Mesh {
        positions: moved.map(|(at, normal)| (at.as_dvec3() + gap * normal.normalize_or_zero()).as_vec3()).collect(),
        normals: mesh.normals.clone(),
        uvs: mesh.uvs.clone(),
        triangles: mesh.triangles.clone(),
        ..Mesh::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_has_no_vertices_of_others() {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE];
        let uvs = vec![Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::NEG_X, Vec2::ONE];
        let mesh = Mesh { positions, uvs, triangles: vec![[0, 1, 2], [4, 1, 3], [1, 4, 3]], ..Mesh::default() };
        let part = part_of(&mesh, vec![[4, 1, 3], [1, 4, 3]]);
        assert_eq!(part.positions, [Vec3::X, Vec3::Z, Vec3::ONE]);
        assert_eq!((part.normals.len(), part.uvs), (0, vec![Vec2::X, Vec2::NEG_X, Vec2::ONE]));
        assert_eq!(part.triangles, [[2, 0, 1], [0, 2, 1]]);
    }
}
