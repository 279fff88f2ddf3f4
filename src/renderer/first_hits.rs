//! First hits of camera rays, for the layers that compositors read. Paths end there: nothing is learned, and no light is gathered.

use std::ops::Range;
use std::sync::Arc;

use crate::encode::bvh::Bvh;
use crate::encode::lights::Lights;
use crate::encode::media;
use crate::encode::surfaces::{Shading, Surfaces};
use crate::generated::constants::FEATURE_TANGENTS;
use crate::generated::kernels::{Registry, Variant};
use crate::generated::layout::{FirstHitRecord, FirstHitsPush};
use crate::gpu::{Buffer, BufferKind, Context, Kernel};
use crate::renderer::guide_cells::cells_of;
use crate::renderer::memory_needs::PictureWork;
use crate::renderer::sets::{Sets, Shown};
use crate::renderer::setup::back_end_for;
use crate::renderer::trace::execution::{self, Plan};
use crate::renderer::variants;
use crate::scene::Scene;
use crate::settings::{Execution, Settings};
use crate::{Error, Result};

/// Most samples of a dispatch.
pub const MOST_SAMPLES: u32 = 1 << 17;
/// Bytes of their records.
const RECORD_BYTES: u64 = MOST_SAMPLES as u64 * size_of::<FirstHitRecord>() as u64;

/// A scene on a device, ready for first hits.
pub struct FirstHits {
    context: Arc<Context>,
    kernel: Kernel,
    workgroup_size: u32,
    sets: Sets,
    records: Arc<Buffer>,
    /// Copy of the records that the host can read.
    records_read: Arc<Buffer>,
    width: u32,
}

impl FirstHits {
    /// Uploads the scene and builds the kernel.
    ///
    /// # Errors
    /// Where a setting is out of range or the device cannot hold the scene.
    pub fn new(context: &Arc<Context>, scene: &Scene, bvh: &Bvh, settings: &Settings) -> Result<Self> {
        let plain = Settings { execution: Execution::Megakernel, noise: None, ..settings.clone().without_guide() };
        plain.validate()?;
        let shading = Shading { surfaces: Surfaces::new(scene), lights: Lights::new(scene, bvh, false) };
        let cells = cells_of(&plain, bvh, &media::boxes(scene), 0);
        let plan = execution::resolve(context.device(), &plain, &shading, bvh, &cells, PictureWork::default())?;
        let Plan { settings, needs } = plan;
        let registry = Registry::built_in();
        let kernels = registry.kernels(back_end_for(context, &shading, bvh, &cells, &settings));
        let build = || {
            let records = Buffer::new(context, "first hits", RECORD_BYTES, BufferKind::Storage)?;
            let records_read = Buffer::new(context, "first hits for the host", RECORD_BYTES, BufferKind::Readback)?;
            let variant = variants::variant(&settings, scene, &shading, bvh);
            // Surfaces have texture coordinates, whether or not anything in the scene reads them.
            let variant = Variant { surface_features: variant.surface_features | FEATURE_TANGENTS, ..variant };
            let kernel = Kernel::new(context, &kernels.first_hits, &variant.entries())?;
            let shown = Shown { scene, shading: &shading, bvh, cells, uploaded: None };
            let sets = Sets::new(context, kernels, &shown, &settings, Some(Arc::clone(&records)))?;
            let (context, width) = (Arc::clone(context), settings.window().width);
            Ok(Self { context, kernel, workgroup_size: variant.workgroup_size, sets, records, records_read, width })
        };
        build().map_err(|error| needs.explain(error))
    }

    /// Takes `samples` samples of each pixel of the window's `rows`, at most [`MOST_SAMPLES`]. Hands the number of each pixel, counted
    /// from the first of these rows, to `each`, with the pixel's records.
    ///
    /// # Errors
    /// Where the device is lost, or a ray meets more surfaces with holes than the kernel follows.
    pub fn of_rows(
        &self,
        rows: &Range<u32>,
        samples: u32,
        each: &mut dyn FnMut(usize, &[FirstHitRecord]),
    ) -> Result<()> {
        let [begin, end] = [rows.start, rows.end].map(|row| row * self.width);
        let at_a_time = (MOST_SAMPLES / samples).max(1);
        for first in (begin..end).step_by(at_a_time as usize) {
            let pixels = at_a_time.min(end - first);
            let records = self.trace(first, pixels, samples)?;
            for (pixel, records) in (first - begin..).zip(records.chunks(samples as usize)) {
                each(pixel as usize, records);
            }
        }
        Ok(())
    }

    /// Traces samples of some pixels, which are counted row by row.
    fn trace(&self, first_pixel: u32, pixel_count: u32, sample_count: u32) -> Result<Vec<FirstHitRecord>> {
        let count = pixel_count * sample_count;
        let push = FirstHitsPush { first_pixel, pixel_count, sample_count };
        let groups = [count.div_ceil(self.workgroup_size), 1, 1];
        let bytes = u64::from(count) * size_of::<FirstHitRecord>() as u64;
        let (frame, sets) = (&self.sets.frame, self.sets.without_film());
        self.context.submit(self.kernel.name(), |recorder| {
            frame.clear_counts(recorder);
            recorder.dispatch(&self.kernel, &sets, bytemuck::bytes_of(&push), groups);
            frame.hand_over_counts(recorder);
            recorder.copy(&self.records, 0, &self.records_read, 0, bytes);
        })?;
        if frame.read_counts()?.overruns > 0 {
            let message =
                "a ray of the camera meets too many surfaces with holes in a row, or the driver has ended a loop";
            return Err(Error::Render(message.into()));
        }
        self.records_read.read(0, count as usize)
    }
}
