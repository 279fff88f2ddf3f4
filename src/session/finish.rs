//! The end of a render, also after an error: pictures, checkpoint, statistics and profile are written.

use crate::film::Picture;
use crate::image::metrics::Metrics;
use crate::session::progress::{Event, Watch};
use crate::session::run::Session;
use crate::session::safety_copy::CopiedPicture;
use crate::session::statistics::{Statistics, StepStatistics, Totals, Versions, peak_resident_bytes};
use crate::{Error, Result, files};

impl Session {
    /// Writes all files after a render with the result `rendered`, and returns the first failure of the two.
    pub(super) fn finish(&mut self, rendered: Result<()>, watch: &Watch<'_>) -> Result<()> {
        let written = self.write_files(rendered, watch);
        let profiled = self.write_profile();
        warn_of_nonfinite(self.history.counts.nonfinite, watch);
        let validated = self.tell_validation(watch);
        written.and(profiled).and(validated)
    }

    /// Writes picture, checkpoint and statistics.
    fn write_files(&mut self, rendered: Result<()>, watch: &Watch<'_>) -> Result<()> {
        let is_lost = rendered.as_ref().is_err_and(Error::is_loss);
        let (copied, rendered) = self.last_picture(rendered);
        let mut errors = None;
        let written = copied.and_then(|copied| {
            let Some(CopiedPicture { picture, .. }) = copied else { return Ok(()) };
            let measured = self.measure(&picture).map(|measured| errors = measured);
            let written = self.write_last(&picture, rendered.is_ok(), watch);
            self.rescued = rendered.as_ref().is_err_and(Error::is_loss).then_some(picture);
            written.and(measured)
        });
        let kept = self.keep(|checkpoints, fleet, history| checkpoints.finish(fleet, history, is_lost));
        let statistics = self.output.statistics.as_ref();
        let statistics = statistics.map_or(Ok(()), |path| files::write_json(path, &self.statistics_with(errors)));
        rendered.and(written).and(kept).and(statistics)
    }

    /// The picture to write, and the result of the render: the device's picture, or the safety copy if the device is lost.
    fn last_picture(&mut self, rendered: Result<()>) -> (Result<Option<CopiedPicture>>, Result<()>) {
        let read = match &rendered {
            // The picture would be wrong, so the files of an earlier moment are kept.
            Err(Error::Render(_) | Error::LoopCut(_)) => return (Ok(None), rendered),
            Err(error) if error.is_loss() => None,
            _ => Some(self.fleet.picture()),
        };
        let lost = match (read, rendered) {
            (Some(Ok(picture)), rendered) => {
                return (Ok(Some(CopiedPicture { picture, samples: self.fleet.first().samples_done() })), rendered);
            }
            (None, Err(error)) => error,
            (Some(Err(error)), Ok(())) if error.is_loss() => error,
            (Some(Err(error)), rendered) => return (Err(error), rendered),
            (None, Ok(())) => return (Ok(None), Ok(())),
        };
        let copied = self.output.safety_copy.take();
        let clause = match &copied {
            Some(CopiedPicture { samples, .. }) => {
                format!("the picture has the {samples} samples per pixel that were last read back from the device")
            }
            None => "there is no picture, because none had been read back from the device".to_owned(),
        };
        (Ok(copied), Err(lost.noting(&clause)))
    }

    /// Writes the last picture, unless it has no samples at all.
    fn write_last(&self, picture: &Picture, is_rendered: bool, watch: &Watch<'_>) -> Result<()> {
        let empty = picture.sample_count.iter().filter(|&&count| count == 0).count();
        if empty < picture.sample_count.len() {
            if empty > 0 {
                let all = self.pixels();
                watch.warn(&format!("{empty} of {all} pixels are black: the render ended before their first sample"));
            }
            self.output.pictures.half_warning(picture).iter().for_each(|warning| watch.warn(warning));
            let denoised = self.output.denoiser.as_ref().map(|denoiser| denoiser.denoise_picture(picture)).transpose();
            // A picture that cannot be denoised is still written.
            let layer = denoised.as_ref().ok().and_then(Option::as_ref);
            let written = self.write_pictures(picture, layer, watch);
            return written.and(denoised.map(drop));
        }
        let message = "the render ended before the first sample, so no picture is written";
        match (watch.stop)() {
            true => watch.warn(message),
            false if is_rendered => return Err(Error::Render(format!("{message}: give it more --time"))),
            false => {}
        }
        Ok(())
    }

    /// Writes the trace of all dispatches if the caller wants one.
    fn write_profile(&mut self) -> Result<()> {
        self.profile = self.profiler.as_ref().map(|profiler| profiler.write()).transpose()?;
        Ok(())
    }

    /// Tells `watch` the validation layer's messages. Any message makes the render fail.
    fn tell_validation(&self, watch: &Watch<'_>) -> Result<()> {
        let messages = self.context.validation_messages();
        messages.iter().for_each(|message| watch.tell(Event::Validation(message)));
        match messages.len() {
            0 => Ok(()),
            count => Err(Error::Render(format!("the validation layer reported {count} problems"))),
        }
    }

    /// All numbers about the render so far, as `--stats` writes them. The error of the picture is measured at the end of a
    /// render only.
    #[doc(hidden)]
    pub fn statistics(&self) -> Statistics {
        self.statistics_with(self.history.steps.last().and_then(|step| step.errors))
    }

    /// All numbers about the render so far; `errors` is the error of the last picture.
    pub(super) fn statistics_with(&self, errors: Option<Metrics>) -> Statistics {
        let device = self.context.device().clone();
        let spp = self.fleet.first().samples_done().into();
        let sums =
            StepStatistics::new(spp, self.history.paths, self.pixels(), self.history.seconds, &self.history.counts);
        let mut steps = self.history.steps.clone();
        if let Some(last) = steps.last_mut() {
            last.errors = errors;
        }
        let times = self.subject.times;
        Statistics {
            scene: self.subject.scene_name.clone(),
            settings: self.settings.clone(),
            versions: Versions::of(&device),
            device,
            times,
            totals: Totals {
                sums: StepStatistics { errors, ..sums },
                primitives: times.primitive_count,
                nonfinite_samples: self.history.counts.nonfinite,
                noise: self.fleet.first().noise(),
                sharing: self.fleet.sharing_times(),
                peak_bytes: self.fleet.peak_device_bytes(),
                peak_resident_bytes: peak_resident_bytes(),
            },
            steps,
        }
    }
}

/// Warns of samples that were dropped, because they make the picture too dark. They come from a scene with infinite or
/// undefined values.
fn warn_of_nonfinite(count: u64, watch: &Watch<'_>) {
    if count > 0 {
        let what = "samples and learning targets were infinite or not a number: such samples count as black";
        watch.warn(&format!("{count} {what}"));
    }
}
