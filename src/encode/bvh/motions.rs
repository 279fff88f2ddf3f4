//! Motions as the kernels read them, behind all primitives.

use crate::generated::layout::{MotionRecord, PrimitiveRecord, TEXEL_BYTES};
use crate::scene::Motion;
use crate::scene::motion::Segment;

/// Texels of a segment, and of a primitive.
const SEGMENT_TEXELS: usize = size_of::<MotionRecord>() / TEXEL_BYTES;
const PRIMITIVE_TEXELS: usize = size_of::<PrimitiveRecord>() / TEXEL_BYTES;

/// Motions of instances, and that of the camera.
#[derive(Default)]
pub struct Motions {
    /// Segments of all motions, in the order in which they follow the primitives.
    pub records: Vec<MotionRecord>,
    /// The motions, as instances refer to them.
    pub all: Vec<Motion>,
    /// First texel of each, and its number of segments.
    places: Vec<[u32; 2]>,
    /// First texel of the camera's motion, and its number of segments.
    pub of_camera: Option<[u32; 2]>,
}

impl Motions {
    /// Motions that follow so many primitives.
    pub(super) fn new(motions: &[Motion], primitive_count: usize) -> Self {
        let mut made = Self { all: motions.to_vec(), ..Self::default() };
        made.places = motions.iter().map(|motion| made.add(motion, primitive_count)).collect();
        made
    }

    /// Adds the camera's motion, behind so many primitives and the motions of instances.
    pub(super) fn add_camera(&mut self, motion: &Motion, primitive_count: usize) {
        self.of_camera = Some(self.add(motion, primitive_count));
    }

    /// The motion whose segments begin at that texel.
    pub fn at(&self, first: u32) -> Option<&Motion> {
        self.all.get(self.places.iter().position(|place| place[0] == first)?)
    }

    /// First texel of a motion, and its number of segments.
    pub(super) fn place(&self, motion: u32) -> [u32; 2] {
        self.places[motion as usize]
    }

    /// Largest number of segments of an instance's motion; 0 where none moves.
    pub fn most_segments(&self) -> u32 {
        self.places.iter().map(|[_, count]| *count).max().unwrap_or(0)
    }

    fn add(&mut self, motion: &Motion, primitive_count: usize) -> [u32; 2] {
        let first = primitive_count * PRIMITIVE_TEXELS + self.records.len() * SEGMENT_TEXELS;
        self.records.extend(motion.segments().iter().map(record));
        [first as u32, motion.segments().len() as u32]
    }
}

fn record(segment: &Segment) -> MotionRecord {
    let [stretch_x, stretch_y, stretch_z] = segment.stretch.map(Into::into);
    let [growth_x, growth_y, growth_z] = segment.growth.map(Into::into);
    MotionRecord {
        origin: segment.origin.into(),
        start: segment.start,
        travel: segment.travel.into(),
        per_time: segment.per_time,
        axis: segment.axis.into(),
        turns: segment.turns,
        stretch_x,
        stretch_y,
        stretch_z,
        growth_x,
        growth_y,
        growth_z,
        ..bytemuck::Zeroable::zeroed()
    }
}
