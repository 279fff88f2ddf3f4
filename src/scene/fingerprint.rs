//! Fingerprint of a scene: two readings with equal fingerprints render equal pictures.

use postcard::ser_flavors::Flavor;
use rayon::prelude::*;
use serde::Serialize;
use xxhash_rust::xxh3::Xxh3;

use super::deformation::Deformation;
use super::{Camera, Scene};
use crate::{Error, Result};

/// Number of primitives that one task hashes.
const CHUNK: usize = 1 << 14;

/// Hash (XXH3, 128 bits, in hexadecimal) of everything in the scene that can change a picture: geometry, materials,
/// emitters, texels, camera, film and integrator, after definitions and transformations. Names, warnings and paths of
/// files are left out, so a scene may be moved.
///
/// # Errors
/// [`Error::Render`] where a part of the scene cannot be serialized. No such part is known.
pub fn fingerprint(scene: &Scene) -> Result<String> {
    fingerprints(scene).map(|found| found.scene)
}

/// Fingerprints of a scene, of its world and of its geometry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fingerprints {
    /// Hash of the scene, as [`fingerprint`] has it.
    pub scene: String,
    /// Hash of all that scatters or emits light: the scene without camera, film and integrator. Scenes of one world teach guides the same.
    pub world: String,
    /// Hash of what a hierarchy is built of: all shapes with the numbers of their materials and emitters, and all motions.
    pub(crate) geometry: u128,
}

/// All fingerprints of a scene.
///
/// # Errors
/// Where [`fingerprint`] fails.
pub fn fingerprints(scene: &Scene) -> Result<Fingerprints> {
    // Every field is named, so that a new one cannot be forgotten.
    let Scene {
        name: _,
        cameras: _,
        views: _,
        objects: _,
        warnings: _,
        is_photometric: _,
        camera,
        film,
        integrator,
        sample_count,
        primitives,
        deformations,
        groups,
        instances,
        motions,
        camera_motion,
        materials,
        media,
        emitters,
        environment,
        delta_emitters,
        textures,
        images,
    } = scene;
    let primitives = (primitives.len(), hashes(primitives.par_chunks(CHUNK))?);
    let images = hashes(images.par_iter())?;
    let lights = (emitters, environment, delta_emitters);
    let small = (camera, film, integrator, sample_count, materials, media, &lights, textures);
    let flat = hash(&(&primitives, &images, small))?;
    let all_deformations = [deformations].into_iter().chain(groups.iter().map(|group| &group.deformations));
    let all_deformations: Vec<&Vec<Deformation>> = all_deformations.collect();
    let deforms = all_deformations.iter().any(|deformations| !deformations.is_empty());
    let deformed = if deforms { Some(hash(&all_deformations)?) } else { None };
    let groups = groups.iter().map(|group| hashes(group.primitives.par_chunks(CHUNK))).collect::<Result<Vec<_>>>()?;
    let shown = (instances.len(), hashes(instances.par_chunks(CHUNK))?);
    let is_flat = instances.is_empty() && camera_motion.is_none();
    let whole = if is_flat { flat } else { hash(&(flat, &groups, &shown, motions, camera_motion))? };
    let geometry = hash(&(&primitives, &groups, &shown, motions, camera_motion))?;
    let world = hash(&(primitives, images, (materials, media, lights, textures), groups, shown, motions))?;
    // Scenes in which nothing deforms keep their fingerprints.
    let with = |own: u128| deformed.map_or(Ok(own), |deformed| hash(&(own, deformed)));
    let [whole, world, geometry] = [with(whole)?, with(world)?, with(geometry)?];
    Ok(Fingerprints { scene: format!("{whole:032x}"), world: format!("{world:032x}"), geometry })
}

/// Fingerprint of a scene whose camera was changed, from that of the scene and the new camera. It is not that of a file with this camera.
pub(crate) fn with_camera(scene: &str, camera: &Camera) -> Result<String> {
    hash(&(scene, camera)).map(|hash| format!("{hash:032x}"))
}

fn hashes<T: Serialize>(items: impl IndexedParallelIterator<Item = T>) -> Result<Vec<u128>> {
    items.map(|item| hash(&item)).collect()
}

fn hash(value: &impl Serialize) -> Result<u128> {
    let failed = |error| Error::Render(format!("the scene cannot be hashed: {error}"));
    postcard::serialize_with_flavor(value, Sink::default()).map_err(failed)
}

/// Number of bytes that are collected before they are hashed. Numbers come in a few bytes at a time.
const BUFFER: usize = 1 << 12;

/// Storage of serialized bytes that hashes them.
#[derive(Default)]
struct Sink {
    hash: Box<Xxh3>,
    buffer: Vec<u8>,
}

impl Flavor for Sink {
    type Output = u128;

    #[inline]
    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.try_extend(&[byte])
    }

    #[inline]
    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        if self.buffer.len() + bytes.len() > BUFFER {
            self.flush();
        }
        self.buffer.extend_from_slice(bytes);
        Ok(())
    }

    fn finalize(mut self) -> postcard::Result<u128> {
        self.flush();
        Ok(self.hash.digest128())
    }
}

impl Sink {
    #[cold]
    fn flush(&mut self) {
        self.hash.update(&self.buffer);
        self.buffer.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::texture::{Image, Pattern, Texels, Texture};
    use crate::scene::{
        Boundary, DeltaEmitter, DeltaKind, Group, Instance, LoadOptions, Projection, ReconstructionFilter, load,
    };
    use glam::{DMat4, Mat3, Vec3};

    fn scene() -> Scene {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/scene.xml");
        let mut scene = load(&path, &LoadOptions::default()).expect("a scene");
        // More primitives than one task hashes.
        scene.primitives = scene.primitives.iter().copied().cycle().take(CHUNK + 7).collect();
        let texels = Texels::Bytes { srgb: true, data: vec![[1, 2, 3, 4]; 6] };
        let pattern = Pattern::Checkerboard { color0: Vec3::ZERO, color1: Vec3::ONE };
        scene.textures.push(Texture { name: "a".into(), pattern, to_uv: Mat3::IDENTITY });
        scene.images.push(Image { name: "a.png".into(), width: 3, height: 2, texels });
        scene
    }

    fn point_light() -> DeltaEmitter {
        let kind = DeltaKind::Point { position: Vec3::ZERO, intensity: Vec3::ONE };
        DeltaEmitter { kind, sampling_weight: 1.0 }
    }

    /// Makes a group of the last primitive, and shows it by an instance that may be changed.
    fn with_instance(scene: &mut Scene, change: fn(&mut Vec<Group>, &mut Vec<Instance>)) {
        let group = scene.group_from(CHUNK + 6);
        scene.add_instance(group, &DMat4::IDENTITY);
        change(&mut scene.groups, &mut scene.instances);
    }

    type Change = fn(&mut Scene);

    fn of_changed(change: impl FnOnce(&mut Scene)) -> String {
        let mut scene = scene();
        change(&mut scene);
        fingerprint(&scene).expect("a hash")
    }

    #[test]
    fn everything_that_changes_a_picture_changes_it() {
        let changes: [(&str, Change); 26] = [
            ("nothing", |_| {}),
            ("the last primitive", |s| s.primitives.last_mut().unwrap().edge_u.x += 1.0e-4),
            ("a primitive more", |s| s.primitives.push(s.primitives[0])),
            ("two primitives swapped", |s| s.primitives.swap(0, CHUNK + 6)),
            ("the camera", |s| s.camera.fov += 1.0e-4),
            ("the projection", |s| s.camera.projection = Projection::Orthographic),
            ("the lens", |s| {
                s.camera.projection = Projection::ThinLens { aperture_radius: 0.1, focus_distance: 2.0 };
            }),
            ("the filter", |s| s.film.filter = ReconstructionFilter::Tent { radius: 1.5 }),
            ("the integrator", |s| s.integrator.max_depth = Some(77)),
            ("the sample count", |s| s.sample_count = Some(77)),
            ("a material", |s| drop(s.materials.pop())),
            ("a boundary", |s| s.materials[0].boundary = Some(Boundary { interior: None, exterior: Some(0) })),
            ("the camera's medium", |s| s.media.of_camera = Some(0)),
            ("an emitter", |s| s.emitters[0].sampling_weight = 0.5),
            ("its radiance", |s| s.emitters[0].radiance.value.x += 1.0e-4),
            ("its texture", |s| s.emitters[0].radiance.texture = Some(0)),
            ("a point light", |s| s.delta_emitters.push(point_light())),
            ("a texture", |s| drop(s.textures.pop())),
            ("the environment", |s| s.environment = Some(crate::scene::Environment::constant(Vec3::ONE))),
            ("a texel", |s| s.images[0].texels = Texels::Bytes { srgb: true, data: vec![[1, 2, 3, 5]; 6] }),
            ("its encoding", |s| s.images[0].texels = Texels::Bytes { srgb: false, data: vec![[1, 2, 3, 4]; 6] }),
            ("an image's shape", |s| (s.images[0].width, s.images[0].height) = (2, 3)),
            ("an instance", |s| with_instance(s, |_, _| ())),
            ("a second instance", |s| with_instance(s, |_, instances| instances.push(instances[0]))),
            ("the place of an instance", |s| with_instance(s, |_, instances| instances[0].origin.x += 1.0e-4)),
            ("a group", |s| with_instance(s, |groups, _| groups[0].primitives[0].material += 1)),
        ];
        let hashes = changes.map(|(what, change)| (what, of_changed(change)));
        for (at, (what, hash)) in hashes.iter().enumerate() {
            let same = hashes[..at].iter().find(|(_, other)| other == hash);
            assert!(same.is_none(), "{what}: {same:?}");
        }
    }

    /// A guide learns the world, whoever looks at it.
    #[test]
    fn the_world_has_no_camera_and_no_film() {
        let of = |change: Change| {
            let mut scene = scene();
            change(&mut scene);
            fingerprints(&scene).expect("hashes")
        };
        let here = of(|_| {});
        let of_camera: [Change; 5] = [
            |s| s.camera.fov += 1.0e-4,
            |s| s.camera.projection = Projection::Orthographic,
            |s| s.film.filter = ReconstructionFilter::Tent { radius: 1.5 },
            |s| s.integrator.max_depth = Some(77),
            |s| s.sample_count = Some(77),
        ];
        for change in of_camera {
            let there = of(change);
            assert!(there.world == here.world && there.scene != here.scene);
        }
        let of_world: [Change; 4] = [
            |s| s.primitives.swap(0, CHUNK + 6),
            |s| s.emitters[0].radiance.value.x += 1.0e-4,
            |s| drop(s.materials.pop()),
            |s| with_instance(s, |_, _| ()),
        ];
        for change in of_world {
            let there = of(change);
            assert!(there.world != here.world && there.scene != here.scene);
        }
    }

    #[test]
    fn names_and_warnings_do_not() {
        let renamed = of_changed(|s| {
            (s.name, s.images[0].name, s.materials[0].name) = ("b".into(), "b".into(), "b".into());
            s.warnings.push("careful".into());
        });
        assert_eq!(renamed, of_changed(|_| {}));
    }
}
