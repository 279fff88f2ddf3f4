//! Scenes made in code.

use std::path::Path;

use glam::{DMat3, DMat4, Mat4, Vec2, Vec3};

use super::deformation::{Deformation, DeformedTriangle, MOST_INTERVALS, split_off};
use super::motion::is_even;
use super::objects::Objects;
use super::{
    AreaEmitter, Bsdf, Camera, FilmDescription, FovAxis, Group, Instance, IntegratorDescription, LoadOptions, Material,
    MaterialKind, Media, Motion, Primitive, PrimitiveShape, Projection, ReconstructionFilter, Scene, SurfaceMaterial,
    Textured, load,
};
use crate::{Error, Result};

/// What covers a shape: a material, and light where it emits any. A scene gives these out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Surface {
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Index into [`Scene::emitters`].
    pub emitter: Option<u32>,
}

impl Camera {
    /// A pinhole camera at `eye` that looks at `target`, upright in a world whose `y` axis points up; a camera that looks
    /// along that axis has `z` up. `fov` is the horizontal field of view in degrees.
    pub fn look_at(eye: impl Into<Vec3>, target: impl Into<Vec3>, fov: f32) -> Self {
        let eye = eye.into();
        let forward = (target.into() - eye).normalize_or(Vec3::NEG_Z);
        let left = Vec3::Y.cross(forward).try_normalize().unwrap_or_else(|| Vec3::Z.cross(forward).normalize());
        let axes = [left, forward.cross(left), forward].map(|axis| axis.extend(0.0));
        Self {
            projection: Projection::Perspective,
            world_from_camera: Mat4::from_cols(axes[0], axes[1], axes[2], eye.extend(1.0)),
            fov,
            fov_axis: FovAxis::X,
            principal_point: Vec2::ZERO,
            near_clip: 1.0e-2,
            far_clip: 1.0e4,
        }
    }
}

/// Scenes from files and from code.
///
/// ```
/// use lodestar::scene::{Camera, Scene};
/// let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 5.0], [0.0, 0.0, 0.0], 40.0), 64, 64);
/// let gray = scene.add_diffuse([0.5; 3]);
/// let lamp = scene.add_light([10.0; 3]);
/// scene.add_sphere([0.0, 0.0, 0.0], 1.0, gray);
/// scene.add_parallelogram([0.0, 3.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], lamp);
/// assert_eq!(scene.primitives.len(), 2);
/// ```
impl Scene {
    /// Reads a Mitsuba scene.
    ///
    /// # Errors
    /// Where the file, or a file that it names, cannot be read or asks for something unsupported.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        load(path.as_ref(), &LoadOptions::default())
    }

    /// An empty scene on a film of that size in pixels, with a box filter.
    pub fn new(camera: Camera, width: u32, height: u32) -> Self {
        Self {
            name: "scene".into(),
            camera,
            cameras: Vec::new(),
            views: Vec::new(),
            film: FilmDescription { width, height, crop: None, filter: ReconstructionFilter::Box },
            integrator: IntegratorDescription::default(),
            sample_count: None,
            primitives: Vec::new(),
            deformations: Vec::new(),
            groups: Vec::new(),
            instances: Vec::new(),
            motions: Vec::new(),
            objects: Objects::default(),
            camera_motion: None,
            materials: Vec::new(),
            media: Media::default(),
            emitters: Vec::new(),
            environment: None,
            delta_emitters: Vec::new(),
            textures: Vec::new(),
            images: Vec::new(),
            warnings: Vec::new(),
            is_photometric: false,
        }
    }

    /// Adds a diffuse material with two sides. `reflectance` is linear sRGB, each channel in [0, 1].
    pub fn add_diffuse(&mut self, reflectance: impl Into<Vec3>) -> Surface {
        let bsdf = Bsdf::Diffuse { reflectance: Textured::constant(reflectance.into()) };
        self.add_material(SurfaceMaterial { two_sided: true, ..SurfaceMaterial::plain(bsdf) })
    }

    /// Adds a material.
    pub fn add_material(&mut self, material: SurfaceMaterial) -> Surface {
        let name = format!("material {}", self.materials.len());
        self.materials.push(Material { name, kind: MaterialKind::Surface(material), boundary: None });
        Surface { material: self.materials.len() as u32 - 1, emitter: None }
    }

    /// Adds an emitter on a black material. `radiance` is linear sRGB, W/(m^2 sr). It emits from the side that the normal
    /// points to.
    pub fn add_light(&mut self, radiance: impl Into<Vec3>) -> Surface {
        self.emitters.push(AreaEmitter::new(Textured::constant(radiance.into())));
        let emitter = Some(self.emitters.len() as u32 - 1);
        Surface { emitter, ..self.add_diffuse(Vec3::ZERO) }
    }

    /// Adds a sphere. Its normal points outwards.
    pub fn add_sphere(&mut self, center: impl Into<Vec3>, radius: f32, surface: Surface) {
        let sphere = primitive(PrimitiveShape::Sphere, center.into(), radius * Vec3::X, radius * Vec3::Z, surface);
        self.primitives.push(Primitive { uvs: [Vec2::ONE; 3], ..sphere });
    }

    /// Adds a lamp that is a disk which faces what it lights. All other light passes it.
    pub fn add_facing_disk(&mut self, center: impl Into<Vec3>, radius: f32, radiance: impl Into<Vec3>) {
        self.emitters.push(AreaEmitter::new(Textured::constant(radiance.into())));
        let opacity = Textured::constant(0.0);
        let black = Bsdf::Diffuse { reflectance: Textured::constant(Vec3::ZERO) };
        let null = self.add_material(SurfaceMaterial { opacity, ..SurfaceMaterial::plain(black) });
        self.add_sphere(center, radius, Surface { emitter: Some(self.emitters.len() as u32 - 1), ..null });
        let shape = PrimitiveShape::FacingDisk;
        self.primitives.last_mut().expect("the sphere").shape = shape;
    }

    /// Adds a parallelogram around `center`, from there half a side to either end of `half_u` and `half_v`. Its normal points
    /// along their cross product.
    pub fn add_parallelogram(
        &mut self,
        center: impl Into<Vec3>,
        half_u: impl Into<Vec3>,
        half_v: impl Into<Vec3>,
        surface: Surface,
    ) {
        let shape = PrimitiveShape::Parallelogram;
        self.primitives.push(primitive(shape, center.into(), half_u.into(), half_v.into(), surface));
    }

    /// Adds a mesh with flat triangles: positions, and three of their indices for each triangle, counterclockwise where the
    /// normal points to the viewer.
    ///
    /// # Panics
    /// Where an index is out of range.
    pub fn add_mesh(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]], surface: Surface) {
        let triangle = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| Vec3::from(positions[corner as usize]));
            primitive(PrimitiveShape::Triangle, a, b - a, c - a, surface)
        };
        self.primitives.extend(triangles.iter().map(triangle));
    }

    /// Adds a mesh with flat triangles that changes its shape while the shutter is open: sets of positions at evenly spaced times, two
    /// to 17, and three of their indices for each triangle.
    ///
    /// # Panics
    /// Where there are fewer or more sets, or an index is out of range of some set.
    pub fn add_deforming_mesh(&mut self, sets: &[Vec<[f32; 3]>], triangles: &[[u32; 3]], surface: Surface) {
        assert!((2..=MOST_INTERVALS + 1).contains(&sets.len()), "{} sets of positions", sets.len());
        let first = self.primitives.len() as u32;
        let key = |set: &Vec<[f32; 3]>, corners: &[u32; 3]| {
            let vertices = corners.map(|corner| Vec3::from(set[corner as usize]));
            DeformedTriangle { vertices, normals: None }
        };
        let keys = triangles.iter().flat_map(|corners| sets.iter().map(move |set| key(set, corners))).collect();
        self.deformations.push(Deformation { first, intervals: sets.len() as u32 - 1, keys });
        self.add_mesh(&sets[0], triangles, surface);
    }

    /// Makes a group of all primitives from the index `first` on, which are no longer shown where they are. Returns the group's index.
    ///
    /// # Panics
    /// Where there are fewer primitives.
    pub fn group_from(&mut self, first: usize) -> u32 {
        let deformations = split_off(&mut self.deformations, first);
        self.groups.push(Group { primitives: self.primitives.split_off(first), deformations });
        self.groups.len() as u32 - 1
    }

    /// Shows a group in the place that an affine transform gives it.
    pub fn add_instance(&mut self, group: u32, world_from_group: &DMat4) {
        self.instances.push(Instance::new(group, world_from_group));
    }

    /// Whether an instance shows spheres as spheres at all times.
    fn keeps_spheres(&self, instance: &Instance) -> bool {
        match instance.motion {
            Some(motion) => {
                let motion = &self.motions[motion as usize];
                let starts = motion.segments().iter().map(|segment| f64::from(segment.start));
                starts.chain([1.0]).all(|time| is_even(&DMat3::from_mat4(motion.at(time))))
            }
            None => is_even(&instance.world_from_group()),
        }
    }

    /// Shows a group that moves.
    pub fn add_moving_instance(&mut self, group: u32, motion: Motion) {
        self.instances.push(Instance::moving(group, self.motions.len() as u32, &motion));
        self.motions.push(motion);
    }

    /// Moves the camera.
    pub fn move_camera(&mut self, motion: Motion) {
        self.camera.world_from_camera = motion.at(0.5).as_mat4();
        self.camera_motion = Some(motion);
    }
}

impl Scene {
    /// Checks the camera, and every primitive's numbers and indices. Readers of files make such checks themselves.
    ///
    /// # Errors
    /// [`Error::Settings`], naming the camera or the primitive by its index in [`Scene::primitives`].
    pub(crate) fn check(&self) -> Result<()> {
        let refuse = |message: String| Err(Error::Settings(message));
        self.camera.check()?;
        let of_groups = self.groups.iter().flat_map(|group| &group.primitives);
        for (at, primitive) in self.primitives.iter().chain(of_groups.clone()).enumerate() {
            let Primitive { origin, edge_u, edge_v, material, emitter, .. } = *primitive;
            if ![origin, edge_u, edge_v].iter().all(|vector| vector.is_finite()) {
                return refuse(format!("primitive {at} has a coordinate that is not finite; give it finite ones"));
            }
            if material as usize >= self.materials.len() {
                let count = self.materials.len();
                return refuse(format!("primitive {at} has material {material}, but the scene has {count} materials"));
            }
            if let Some(emitter) = emitter.filter(|&emitter| emitter as usize >= self.emitters.len()) {
                let count = self.emitters.len();
                return refuse(format!("primitive {at} has emitter {emitter}, but the scene has {count} emitters"));
            }
        }
        self.check_deformations()?;
        for (at, instance) in self.instances.iter().enumerate() {
            if instance.group as usize >= self.groups.len() {
                let (group, count) = (instance.group, self.groups.len());
                return refuse(format!("instance {at} shows group {group}, but the scene has {count} groups"));
            }
            if instance.motion.is_some_and(|motion| motion as usize >= self.motions.len()) {
                let count = self.motions.len();
                return refuse(format!("instance {at} has a motion that is none of the scene's {count}"));
            }
            let shows_sphere = self.groups[instance.group as usize].has_sphere();
            if shows_sphere && !self.keeps_spheres(instance) {
                return refuse(format!("instance {at} scales a sphere unevenly or shears it; give it an even scale"));
            }
            if instance.group_from_world().is_none() {
                return refuse(format!(
                    "the transform of instance {at} has no inverse, or shears too much; add its primitives to the scene"
                ));
            }
        }
        Ok(())
    }

    /// Checks that deformations are those of triangles, in their order.
    fn check_deformations(&self) -> Result<()> {
        let of_groups = self.groups.iter().map(|group| (&group.primitives, &group.deformations));
        for (primitives, deformations) in [(&self.primitives, &self.deformations)].into_iter().chain(of_groups) {
            let mut next = 0;
            for deformation in deformations {
                let Deformation { first, intervals, ref keys } = *deformation;
                let is_whole = (1..=MOST_INTERVALS as u32).contains(&intervals)
                    && keys.len() % deformation.keys_of_each() == 0
                    && first >= next
                    && first as usize + keys.len() / deformation.keys_of_each() <= primitives.len();
                let fits = |index: u32| {
                    let p = &primitives[index as usize];
                    let keys = deformation.keys_of(index);
                    let [a, b, c] = keys[0].vertices;
                    let is_sound = |key: &DeformedTriangle| {
                        let vectors = || key.vertices.iter().chain(key.normals.iter().flatten());
                        vectors().all(|vector| vector.is_finite()) && key.normals.is_some() == p.normals.is_some()
                    };
                    p.shape == PrimitiveShape::Triangle
                        && [p.origin, p.edge_u, p.edge_v] == [a, b - a, c - a]
                        && keys.iter().all(is_sound)
                };
                if !is_whole || !deformation.triangles().all(fits) {
                    return Err(Error::Settings(format!(
                        "the deformation from primitive {first} on does not fit: give 2 to {} finite triangles for each of its \
                         triangles, the first of which is the primitive, and keep deformations in order",
                        MOST_INTERVALS + 1
                    )));
                }
                next = deformation.triangles().end;
            }
        }
        Ok(())
    }
}

fn primitive(shape: PrimitiveShape, origin: Vec3, edge_u: Vec3, edge_v: Vec3, surface: Surface) -> Primitive {
    let Surface { material, emitter } = surface;
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::Y];
    Primitive {
        shape,
        origin,
        edge_u,
        edge_v,
        normals: None,
        uvs,
        flip_normal: false,
        front_only: false,
        unseen: false,
        material,
        emitter,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_renderer_can_take_is_refused() {
        let scene = |change: &dyn Fn(&mut Scene)| {
            let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], 40.0), 8, 8);
            let gray = scene.add_diffuse([0.5; 3]);
            scene.add_sphere([0.0; 3], 1.0, gray);
            change(&mut scene);
            scene.check().map_err(|error| error.to_string())
        };
        assert_eq!(scene(&|_| ()), Ok(()));
        let refused = |change: &dyn Fn(&mut Scene), words: &str| {
            let error = scene(change).unwrap_err();
            assert!(error.contains(words), "{error}");
        };
        refused(&|s| s.primitives[0].material = 1, "primitive 0 has material 1, but the scene has 1 materials");
        refused(&|s| s.primitives[0].emitter = Some(0), "primitive 0 has emitter 0, but the scene has 0 emitters");
        refused(&|s| s.primitives[0].origin.y = f32::NAN, "primitive 0 has a coordinate");
        let instance = |s: &mut Scene, matrix: DMat4| {
            s.add_parallelogram([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], Surface { material: 0, emitter: None });
            let group = s.group_from(1);
            s.add_instance(group, &matrix);
        };
        let scaled = |x: f64, y: f64, z: f64| DMat4::from_scale(glam::dvec3(x, y, z));
        assert_eq!(scene(&|s| instance(s, scaled(1.0e4, -1.0, 1.0e-4))), Ok(()));
        refused(&|s| instance(s, scaled(1.0, 0.0, 1.0)), "the transform of instance 0 has no inverse");
        refused(&|s| instance(s, scaled(1.0, f64::NAN, 1.0)), "the transform of instance 0 has no inverse");
        let slanted =
            DMat4::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 600.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        refused(&|s| instance(s, slanted), "shears too much");
        refused(&|s| s.add_instance(3, &DMat4::IDENTITY), "instance 0 shows group 3, but the scene has 0 groups");
        let sphere = |s: &mut Scene, matrix: DMat4| {
            let group = s.group_from(0);
            s.add_instance(group, &matrix);
        };
        assert_eq!(scene(&|s| sphere(s, scaled(-2.0, 2.0, 2.0))), Ok(()));
        refused(&|s| sphere(s, scaled(2.0, 1.0, 2.0)), "instance 0 scales a sphere unevenly");
        refused(&|s| s.camera.fov = 180.0, "field of view is 180 degrees");
        refused(&|s| s.camera.fov = f32::NAN, "not finite");
    }

    #[test]
    fn cameras_look_at_their_targets() {
        for (eye, target) in
            [([0.0, 0.0, 5.0], [0.0; 3]), ([1.0, 2.0, 3.0], [-1.0, 0.5, 7.0]), ([0.0, 9.0, 0.0], [0.0; 3])]
        {
            let camera = Camera::look_at(eye, target, 40.0);
            let [left, up, forward] =
                [Vec3::X, Vec3::Y, Vec3::Z].map(|a| camera.world_from_camera.transform_vector3(a));
            assert!(left.cross(up).distance(forward) < 1.0e-6, "right-handed");
            assert!(up.y >= 0.0 && left.y.abs() < 1.0e-6, "upright");
            let towards = (Vec3::from(target) - Vec3::from(eye)).normalize();
            assert!(forward.distance(towards) < 1.0e-6);
        }
    }
}
