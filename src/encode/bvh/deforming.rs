//! Keys of deforming triangles as the kernels read them, behind all primitives.

use glam::Vec3;

use super::normals::octahedral_encode;
use super::turn::Turn;
use crate::generated::constants;
use crate::generated::layout::{DeformingRecord, KeyRecord, PrimitiveRecord, TEXEL_BYTES};
use crate::scene::deformation::{Deformation, DeformedTriangle, deformation_of};

/// Texels of a key, and of a primitive.
pub(super) const KEY_TEXELS: usize = size_of::<KeyRecord>() / TEXEL_BYTES;

/// Keys of the triangles of deformations. Those of a triangle follow each other.
pub(super) struct Keys<'a> {
    deformations: &'a [Deformation],
    /// Number of keys before those of each deformation.
    before: Vec<usize>,
    pub records: Vec<KeyRecord>,
}

impl<'a> Keys<'a> {
    /// Keys of triangles that begin at another of their corners, by `turn`, than those of the deformations.
    pub fn new(deformations: &'a [Deformation], turn: impl Fn(u32) -> Turn) -> Self {
        let mut keys = Self { deformations, before: Vec::new(), records: Vec::new() };
        for deformation in deformations {
            keys.before.push(keys.records.len());
            for triangle in deformation.triangles() {
                let turn = turn(triangle);
                keys.records.extend(deformation.keys_of(triangle).iter().map(|key| record(key, turn)));
            }
        }
        keys
    }

    /// Marks the record of the primitive with this index, if it deforms. Its keys are counted from the first one of all.
    pub fn mark(&self, record: &mut PrimitiveRecord, index: u32) {
        let Some(at) = deformation_of(self.deformations, index) else { return };
        let deformation = &self.deformations[at];
        let key = self.before[at] + (index - deformation.first) as usize * deformation.keys_of_each();
        record.flags = record.flags & !constants::PRIMITIVE_LARGE | constants::PRIMITIVE_DEFORMING;
        let deforming: &mut DeformingRecord = bytemuck::cast_mut(record);
        (deforming.intervals, deforming.first_key) = (deformation.intervals, (key * KEY_TEXELS) as u32);
    }
}

/// Whether the vertices of a record's triangle move.
pub(crate) fn is_deforming(record: &PrimitiveRecord) -> bool {
    record.flags & constants::PRIMITIVE_DEFORMING != 0
}

/// Moves the first keys of the records that deform by so many texels.
pub(super) fn move_keys(records: &mut [PrimitiveRecord], texels: usize) {
    for record in records.iter_mut().filter(|record| is_deforming(record)) {
        let deforming: &mut DeformingRecord = bytemuck::cast_mut(record);
        deforming.first_key += texels as u32;
    }
}

fn record(key: &DeformedTriangle, turn: Turn) -> KeyRecord {
    let mut vertices = key.vertices.map(<[f32; 3]>::from);
    let mut normals = key.normals.map_or([0; 3], |normals| normals.map(octahedral_encode));
    turn.corners(&mut vertices);
    turn.corners(&mut normals);
    let ([vertex0, vertex1, vertex2], [normal0, normal1, normal2]) = (vertices, normals);
    KeyRecord { vertex0, normal0, vertex1, normal1, vertex2, normal2 }
}

/// Vertices of a deforming triangle at all times. The first of all `keys` is that texel of the primitives' buffer.
pub(super) fn vertices_of<'a>(
    record: &PrimitiveRecord,
    keys: &'a [KeyRecord],
    first_texel: usize,
) -> impl Iterator<Item = [Vec3; 3]> + use<'a> {
    let DeformingRecord { intervals, first_key, .. } = bytemuck::cast(*record);
    let first = (first_key as usize - first_texel) / KEY_TEXELS;
    keys[first..=first + intervals as usize].iter().map(|key| [key.vertex0, key.vertex1, key.vertex2].map(Vec3::from))
}
