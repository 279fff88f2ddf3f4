//! Media as the kernels read them (`glsl/include/path/medium.glsl`): records of phase functions behind those of all materials.

use glam::Vec3;

use crate::generated::constants;
use crate::generated::layout::MaterialRecord;
use crate::scene::{Boundary, Media, Medium, PhaseLobe, Primitive, Scene};

/// Record of a medium.
pub(crate) fn record(medium: &Medium) -> MaterialRecord {
    let mut record = MaterialRecord {
        kind_and_flags: constants::BSDF_PHASE,
        material1_or_relief: constants::NONE,
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
    for instance in &scene.instances {
        let bounded = scene.groups[instance.group as usize].primitives.iter().filter(|own| bounds(own).is_some());
        for primitive in bounded {
            add(primitive, scene.placed_box(instance, primitive.bounds()));
        }
    }
    boxes.into_iter().flatten().collect()
}
