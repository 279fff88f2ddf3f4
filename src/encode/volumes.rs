//! Volumes of media as the kernels read them (`glsl/include/path/volume.glsl`): one record each, the words of their voxels, and the
//! majorants of the extinction.

use std::borrow::Cow;

use glam::{DMat4, UVec3, Vec3};
use rayon::prelude::*;

use crate::generated::constants;
use crate::generated::layout::VolumeRecord;
use crate::scene::{AlbedoVolume, Media, Medium, Volume, VolumeWrap};

/// Part of a voxel by which a place of the kernels may be wrong.
const SLACK: f32 = 0.01;
/// Factor of majorants: kernels round values after this file.
const ROUNDED_UP: f32 = 1.0 + 1.0e-5;

/// Numbers of a medium's volumes, or `NONE`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VolumeNumbers {
    pub extinction: u32,
    pub albedo: u32,
    pub emission: u32,
}

/// Numbers of the volumes of all media.
pub(super) fn numbers(media: &Media) -> Vec<VolumeNumbers> {
    let mut count = 0;
    let mut number = |is_there: bool| {
        count += u32::from(is_there);
        if is_there { count - 1 } else { constants::NONE }
    };
    let of = |medium: &Medium| {
        let volumes = medium.volumes.as_ref();
        VolumeNumbers {
            extinction: number(volumes.is_some()),
            albedo: number(volumes.is_some_and(|volumes| volumes.albedo.is_some())),
            emission: number(volumes.is_some_and(|volumes| volumes.emission.is_some())),
        }
    };
    media.all.iter().map(of).collect()
}

/// Records of all volumes, whose addresses are still numbers of grids, and the words of these grids.
pub(super) fn records(media: &Media) -> (Vec<VolumeRecord>, Vec<Cow<'_, [u32]>>) {
    let (mut records, mut grids) = (Vec::new(), Vec::new());
    for medium in &media.all {
        let scattering = matches!(
            medium.volumes.as_ref().and_then(|volumes| volumes.albedo.as_ref()),
            Some(AlbedoVolume::Scattering(_))
        );
        for (place, volume) in medium.all_volumes().enumerate() {
            let mut record = record(volume);
            record.address = grids.len() as u32;
            grids.push(Cow::Borrowed(bytemuck::cast_slice(&volume.values[..])));
            if place == 0 {
                record.majorants = grids.len() as u32;
                grids.push(Cow::Owned(majorants(volume, medium.extinction, &record)));
            } else {
                record.majorants = record.address;
            }
            // The second volume is that of the albedo, if there is one.
            record.flags |= if place == 1 && scattering { constants::VOLUME_SCATTERING } else { 0 };
            records.push(record);
        }
    }
    (records, grids)
}

/// Puts the addresses of grids in the place of their numbers.
pub(super) fn set_addresses(records: &mut [VolumeRecord], addresses: &[u32]) {
    for record in records {
        record.address = addresses[record.address as usize];
        record.majorants = addresses[record.majorants as usize];
    }
}

fn record(volume: &Volume) -> VolumeRecord {
    let scale = DMat4::from_scale(volume.size.as_dvec3());
    let grid_from_world = scale * volume.unit_from_world;
    let row = |axis| grid_from_world.row(axis).as_vec4().into();
    let (side, blocks) = volume.blocks();
    let flag = |is_set: bool, flag: u32| if is_set { flag } else { 0 };
    VolumeRecord {
        grid_x: row(0),
        grid_y: row(1),
        grid_z: row(2),
        size: volume.size.into(),
        flags: flag(volume.has_colors, constants::VOLUME_COLORS)
            | flag(volume.is_nearest, constants::VOLUME_NEAREST)
            | match volume.wrap {
                VolumeWrap::Clamp => constants::VOLUME_CLAMP,
                VolumeWrap::Repeat => constants::VOLUME_REPEAT,
                VolumeWrap::Mirror => constants::VOLUME_MIRROR,
                VolumeWrap::Zero => 0,
            },
        blocks: blocks.into(),
        side: side as f32,
        ..bytemuck::Zeroable::zeroed()
    }
}

/// Largest extinction of each block, over all channels and all voxels that a place in the block may be interpolated from.
fn majorants(volume: &Volume, extinction: Vec3, record: &VolumeRecord) -> Vec<u32> {
    let (blocks, side) = (UVec3::from(record.blocks), record.side);
    let first_and_last = |block: u32, axis: usize| {
        let size = volume.size[axis] as i64;
        let low = (block as f32 * side - 0.5 - SLACK).floor() as i64;
        let high = (((block + 1) as f32 * side).min(size as f32) - 0.5 + SLACK).floor() as i64 + 1;
        // Voxels beyond the border have the values of others, near the same border or the opposite one.
        let wraps = volume.wrap == VolumeWrap::Repeat && (low < 0 || high >= size);
        (low.max(0) as u32, high.min(size - 1) as u32, wraps)
    };
    let value = |x: u32, y: u32, z: u32| {
        let index = ((z as usize * volume.size.y as usize) + y as usize) * volume.size.x as usize + x as usize;
        match volume.has_colors {
            true => {
                let color = [0, 1, 2].map(|channel| volume.values[3 * index + channel]);
                (Vec3::from_array(color) * extinction).max_element()
            }
            false => volume.values[index] * extinction.max_element(),
        }
    };
    let of_block = |index: usize| {
        let (row, x) = (index / blocks.x as usize, index as u32 % blocks.x);
        let block = UVec3::new(x, row as u32 % blocks.y, row as u32 / blocks.y);
        let ranges = [0, 1, 2].map(|axis| {
            let (first, last, wraps) = first_and_last(block[axis], axis);
            let opposite = wraps.then_some([0, volume.size[axis] - 1]);
            (first..=last).chain(opposite.into_iter().flatten())
        });
        let [xs, ys, zs] = ranges;
        let mut most = 0.0f32;
        for z in zs {
            for y in ys.clone() {
                for x in xs.clone() {
                    most = most.max(value(x, y, z));
                }
            }
        }
        (most * ROUNDED_UP).to_bits()
    };
    let count = blocks.to_array().map(|count| count as usize).iter().product();
    (0..count).into_par_iter().map(of_block).collect()
}
