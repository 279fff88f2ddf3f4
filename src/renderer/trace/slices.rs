//! Cuts work into dispatches of about equal duration, so that no watchdog fires and a stop is answered soon. The cuts change no
//! bit of the picture: a pixel's samples belong to one invocation, and sums do not depend on order.

use std::cell::Cell;
use std::ops::Range;
use std::time::Duration;

use crate::generated::constants::TILE_PIXELS;
use crate::gpu::{DeviceInfo, DeviceKind};
use crate::renderer::film_store::pages::FilmPage;
use crate::settings::Settings;

/// Target duration of a dispatch on a GPU, in seconds; watchdogs bite at some 2 s.
const GPU_SLICE: f64 = 0.05;
/// Target duration of a dispatch on a CPU, in seconds. No watchdog waits there, and at the end of every dispatch cores wait for
/// the last one.
const CPU_SLICE: f64 = 0.15;
/// Workgroups of the first, unmeasured dispatch.
const FIRST_GROUPS: u32 = 64;
/// Most cells or tiles of a dispatch.
const CELLS_PER_DISPATCH: u32 = 4096;

/// A range of a page's workgroups and the stride in which they are visited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Slice {
    pub first: u32,
    pub count: u32,
    pub stride: u32,
}

impl Slice {
    pub fn end(self) -> u32 {
        self.first + self.count
    }
}

/// Sizes slices by the time the last ones took.
pub(crate) struct Slicer {
    target_seconds: f64,
    workgroup_size: u32,
    max_groups: u32,
    spreads: bool,
    groups: Cell<u32>,
}

impl Slicer {
    /// A slicer for dispatches of at most `most_groups` workgroups.
    pub fn new(device: &DeviceInfo, settings: &Settings, workgroup_size: u32, most_groups: u32) -> Self {
        let is_cpu = device.kind == DeviceKind::Cpu;
        let default = if is_cpu { CPU_SLICE } else { GPU_SLICE };
        Self {
            target_seconds: settings.slice_milliseconds.map_or(default, |ms| ms / 1000.0),
            workgroup_size,
            max_groups: max_groups(device).min(most_groups),
            spreads: is_cpu,
            groups: Cell::new(FIRST_GROUPS),
        }
    }

    /// The slice that begins at workgroup `first`, if the page goes that far.
    pub fn slice(&self, page: &FilmPage, first: u32) -> Option<Slice> {
        let left = self.workgroups(page).checked_sub(first).filter(|&left| left > 0)?;
        // The last two slices share what is left, so that none is tiny.
        let wanted = self.groups.get().min(self.max_groups);
        let count = if left < 2 * wanted && left > wanted { left.div_ceil(2) } else { left.min(wanted) };
        Some(self.spread(first, count))
    }

    /// A slice of one workgroup.
    pub fn smallest_slice(&self, page: &FilmPage) -> Option<Slice> {
        (self.workgroups(page) > 0).then(|| self.spread(0, 1))
    }

    /// Adapts the size of the next slices to how long one took.
    pub fn measured(&self, slice: Slice, elapsed: Duration) {
        let ratio = self.target_seconds / elapsed.as_secs_f64().max(1.0e-6);
        let groups = f64::from(slice.count) * ratio.clamp(0.25, 4.0);
        self.groups.set(groups.clamp(1.0, f64::from(self.max_groups)) as u32);
    }

    /// Cuts a range of cells or tiles that have a workgroup each.
    pub fn ranges(&self, cells: Range<u32>) -> impl Iterator<Item = Range<u32>> {
        let most = CELLS_PER_DISPATCH.min(self.max_groups);
        let end = cells.end;
        cells.step_by(most as usize).map(move |first| first..end.min(first + most))
    }

    fn workgroups(&self, page: &FilmPage) -> u32 {
        (page.sampled_tiles() * TILE_PIXELS).div_ceil(self.workgroup_size)
    }

    /// A slice with its stride. CPU drivers deal out contiguous parts of a dispatch to their threads; a stride near the golden
    /// section gives every thread its share of bright and dark regions.
    fn spread(&self, first: u32, count: u32) -> Slice {
        let golden = (f64::from(count) * 0.618_034) as u32;
        let stride = if self.spreads { (golden..count).find(|&s| coprime(s, count)).unwrap_or(1) } else { 1 };
        Slice { first, count, stride: stride.max(1) }
    }
}

/// Most workgroups of a dispatch: the product of a workgroup's index and the stride may not pass 2^32.
fn max_groups(device: &DeviceInfo) -> u32 {
    device.limits.max_workgroup_count[0].min(65_535)
}

fn coprime(a: u32, b: u32) -> bool {
    let (mut a, mut b) = (a, b);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a == 1
}
