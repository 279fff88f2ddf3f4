//! Media as the kernels read them (`glsl/include/path/medium.glsl`): records of phase functions behind those of all materials.

use glam::Vec3;

use super::volumes::VolumeNumbers;
use crate::generated::constants;
use crate::generated::layout::MaterialRecord;
use crate::scene::deformation::Deformation;
use crate::scene::{Boundary, Media, Medium, PhaseLobe, Primitive, Scene, Volume};

/// Record of a medium, which has `VolumeNumbers` of volumes.
pub(crate) fn record(medium: &Medium, volumes: VolumeNumbers) -> MaterialRecord {
    let mut record = MaterialRecord {
        kind_and_flags: constants::BSDF_PHASE,
        material0: volumes.extinction,
        material1_or_relief: volumes.albedo,
        coating_specular: medium.emission.into(),
        media: volumes.emission,
        links: [[constants::NONE; 4]; 2],
        ..bytemuck::Zeroable::zeroed()
    };
    let [first, second] = medium.phase.lobes.map(|lobe| match lobe {
        PhaseLobe::HenyeyGreenstein(mean_cosine) => mean_cosine,
        PhaseLobe::Rayleigh => constants::PHASE_RAYLEIGH,
    });
    let scalars = [
        (constants::PHASE_MEAN_COSINE0, first),
        (constants::PHASE_MEAN_COSINE1, second),
        (constants::PHASE_SECOND_LOBE, medium.phase.second_lobe),
    ];
    for (parameter, value) in scalars {
        let at = (parameter - constants::PARAMETER_SCALAR0) as usize;
        record.scalars[at / 4][at % 4] = value;
    }
    // A phase function scatters all light. The albedo belongs to the flight.
    record.colors = [Vec3::ONE, medium.extinction, medium.albedo].map(|color| color.extend(0.0).into());
    record
}

/// Number by which kernels know a medium.
pub(crate) fn number(medium: Option<u32>) -> u32 {
    medium.map_or(0, |index| index + 1)
}

/// Word with the media on both sides of a surface.
pub(crate) fn word(boundary: &Boundary) -> u32 {
    number(boundary.interior) | number(boundary.exterior) << constants::EXTERIOR_MEDIUM_SHIFT
}

/// Box outside of which a medium has no particles.
fn volume_box(medium: &Medium) -> (Vec3, Vec3) {
    let bounds = medium.volumes.as_ref().map(|volumes| volumes.extinction.bounds());
    bounds.map_or((Vec3::NEG_INFINITY, Vec3::INFINITY), |(min, max)| (min.as_vec3(), max.as_vec3()))
}

/// Boxes that hold the media of a scene, as (minimum, maximum): for each medium the box of the surfaces that bound it, and everything
/// where the camera is in one.
pub fn boxes(scene: &Scene) -> Vec<(Vec3, Vec3)> {
    let Media { all, of_camera } = &scene.media;
    if of_camera.is_some() {
        return vec![(Vec3::NEG_INFINITY, Vec3::INFINITY)];
    }
    let mut boxes: Vec<Option<(Vec3, Vec3)>> = vec![None; all.len()];
    if all.is_empty() {
        return Vec::new();
    }
    let bounds = |primitive: &Primitive| scene.materials.get(primitive.material as usize)?.boundary;
    let mut add = |primitive: &Primitive, (min, max): (Vec3, Vec3)| {
        let Some(Boundary { interior, exterior }) = bounds(primitive) else { return };
        for medium in [interior, exterior].into_iter().flatten() {
            if let Some(known) = boxes.get_mut(medium as usize) {
                let (low, high) = known.get_or_insert((min, max));
                (*low, *high) = (low.min(min), high.max(max));
            }
        }
    };
    scene.primitives.iter().for_each(|primitive| add(primitive, primitive.bounds()));
    for (index, of_key) in scene.deformations.iter().flat_map(Deformation::boxes) {
        add(&scene.primitives[index as usize], of_key);
    }
    for instance in &scene.instances {
        let group = &scene.groups[instance.group as usize];
        for primitive in group.primitives.iter().filter(|own| bounds(own).is_some()) {
            add(primitive, scene.placed_box(instance, primitive.bounds()));
        }
        for (index, of_key) in group.deformations.iter().flat_map(Deformation::boxes) {
            add(&group.primitives[index as usize], scene.placed_box(instance, of_key));
        }
    }
    let within = all.iter().map(volume_box);
    let boxes = boxes.into_iter().zip(within).filter_map(|(found, within)| {
        let ((min, max), (low, high)) = (found?, within);
        Some((min.max(low), max.min(high)))
    });
    boxes.filter(|(min, max)| min.cmple(*max).all()).collect()
}

/// Largest radiance that a medium can emit.
pub(crate) fn brightest(media: &Media) -> f32 {
    let of = |medium: &Medium| {
        let volume = medium.volumes.as_ref().and_then(|volumes| volumes.emission.as_ref());
        (medium.emission * volume.map_or(Vec3::ONE, Volume::most)).max_element()
    };
    media.all.iter().map(of).fold(0.0, f32::max)
}
