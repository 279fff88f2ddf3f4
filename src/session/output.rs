//! Files of a running render: its pictures, and when the unfinished one is written.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::Result;
use crate::denoise::Denoiser;
use crate::film::Denoised;
use crate::film::strips::{Strips, each};
use crate::image::Image;
use crate::image::metrics::{Comparison, Metrics};
use crate::session::files::{OutputFiles, PictureFiles};
use crate::session::progress::{Event, Watch};
use crate::session::safety_copy::SafetyCopy;

/// Files of the picture, of the guide and of the statistics, and the time of the last writing.
pub(super) struct Output {
    pub pictures: PictureFiles,
    pub guide: Option<PathBuf>,
    pub statistics: Option<PathBuf>,
    pub safety_copy: SafetyCopy,
    /// The picture that errors are measured against.
    reference: Option<Image>,
    /// The denoiser of the last picture, if one is wanted.
    denoiser: Option<Denoiser>,
    /// Seconds between two writings of the unfinished picture.
    write_every: Option<f64>,
    last_write: Instant,
    /// Whether the last writing succeeded.
    is_writable: bool,
}

impl Output {
    /// Files that the caller has `wanted`. The state of the device is read back at least every `checkpoint_every`.
    pub fn new(
        wanted: &OutputFiles,
        pictures: PictureFiles,
        reference: Option<Image>,
        denoiser: Option<Denoiser>,
        checkpoint_every: Option<Duration>,
    ) -> Self {
        let intervals = wanted.write_interval().into_iter().chain(checkpoint_every);
        Self {
            pictures,
            reference,
            write_every: wanted.write_every,
            guide: wanted.guide.clone(),
            statistics: wanted.statistics.clone(),
            denoiser,
            safety_copy: SafetyCopy::new(intervals),
            last_write: Instant::now(),
            is_writable: true,
        }
    }

    /// Begins with another picture. One that `shows_another_view` is no longer measured against the reference.
    pub fn begin_anew(&mut self, shows_another_view: bool) {
        self.safety_copy.take();
        self.last_write = Instant::now();
        if shows_another_view {
            self.reference = None;
        }
    }

    /// Error of `picture`, if there is a reference.
    pub fn measure(&self, picture: &dyn Strips) -> Result<Option<Metrics>> {
        let Some(reference) = &self.reference else { return Ok(None) };
        let mut comparison = Comparison::new(reference);
        each(picture, &mut |strip| comparison.add(&strip.picture.radiance[strip.within.clone()]))?;
        comparison.finish().map(Some)
    }

    /// Whether errors are measured against a reference.
    pub fn measures(&self) -> bool {
        self.reference.is_some()
    }

    /// Whether the last picture is denoised.
    pub fn denoises(&self) -> bool {
        self.denoiser.is_some()
    }

    /// The picture without noise, if a denoiser is wanted. A denoiser needs a whole picture.
    pub fn denoise(&self, picture: &dyn Strips) -> Result<Option<Denoised>> {
        let denoiser = self.denoiser.as_ref().zip(picture.whole());
        denoiser.map(|(denoiser, picture)| denoiser.denoise_picture(picture)).transpose()
    }

    /// Whether the interval between two writings of the unfinished picture has passed.
    pub fn is_due(&self) -> bool {
        let elapsed = self.last_write.elapsed().as_secs_f64();
        self.write_every.is_some_and(|every| elapsed >= every)
    }

    /// Writes the picture's files.
    pub fn write(
        &self,
        picture: &dyn Strips,
        denoised: Option<&Denoised>,
        attributes: &[(String, String)],
        watch: &Watch<'_>,
    ) -> Result<()> {
        let tell = |path: &Path, share| {
            watch.tell(if share < 1.0 { Event::Writing(path, share) } else { Event::Written(path) });
        };
        self.pictures.write(picture, denoised, attributes, &tell)
    }

    /// Notes how writing the unfinished picture went. Of several failures in a row, `watch` is told the first.
    pub fn note_writing(&mut self, written: &Result<()>, watch: &Watch<'_>) {
        if let (Err(error), true) = (written, self.is_writable) {
            // The render goes on, because the folder may be back or the disk may have room when it ends.
            watch.warn(&format!("{error}; the render goes on"));
        }
        (self.last_write, self.is_writable) = (Instant::now(), written.is_ok());
    }
}
