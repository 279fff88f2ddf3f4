//! The end of a render, also after an error: pictures, checkpoint, statistics and profile are written.

use crate::film::Picture;
use crate::film::strips::{SampleCounts, Strips};
use crate::image::metrics::Metrics;
use crate::session::profile::Summary;
use crate::session::progress::{Event, Watch};
use crate::session::running::Running;
use crate::session::safety_copy::CopiedPicture;
use crate::settings::MAX_DEPTH_LIMIT;
use crate::{Error, Result, files};

/// What a render has left besides its files.
pub(super) struct Finished {
    /// Last safety copy of the picture, if the device was lost.
    rescued: Option<Picture>,
    /// Times of all dispatches, if a trace of them was written.
    profile: Option<Summary>,
}

impl Finished {
    /// Writes all files after a render with the result `rendered`. The result is the first failure of rendering and writing.
    pub fn of(running: &mut Running, rendered: Result<()>, watch: &Watch<'_>) -> (Self, Result<()>) {
        let (rescued, written) = write_files(running, rendered, watch);
        let profiled = running.write_profile();
        warn_of_nonfinite(running.history().counts.nonfinite, watch);
        let cut = warning_of_cut_shadow_rays(running.history().counts.cut_shadow_rays);
        let cut = cut.into_iter().chain(warning_of_cut_flights(running.history().counts.cut_flights));
        cut.for_each(|warning| watch.warn(&warning));
        let validated = tell_validation(running, watch);
        let (profile, profiled) = match profiled {
            Ok(profile) => (profile, Ok(())),
            Err(error) => (None, Err(error)),
        };
        (Self { rescued, profile }, written.and(profiled).and(validated))
    }

    pub fn rescued(&self) -> Option<&Picture> {
        self.rescued.as_ref()
    }

    pub fn profile(&self) -> Option<&Summary> {
        self.profile.as_ref()
    }
}

/// Writes picture, checkpoint and statistics. Returns the picture where the device is lost.
fn write_files(running: &mut Running, rendered: Result<()>, watch: &Watch<'_>) -> (Option<Picture>, Result<()>) {
    let is_lost = rendered.as_ref().is_err_and(Error::is_loss);
    let Written { rescued, errors, rendered, written } = write_last(running, rendered, watch);
    let kept = running.keep_last(is_lost);
    let guided = if rendered.is_ok() { write_guide(running, watch) } else { Ok(()) };
    let statistics = running.output().statistics.as_ref();
    let statistics = statistics.map_or(Ok(()), |path| files::write_json(path, &running.statistics_with(errors)));
    (rescued, rendered.and(written).and(kept).and(guided).and(statistics))
}

/// What became of the last picture.
struct Written {
    /// The safety copy, if the device was lost.
    rescued: Option<Picture>,
    /// Errors against the reference.
    errors: Option<Metrics>,
    /// Result of the render.
    rendered: Result<()>,
    /// Result of writing.
    written: Result<()>,
}

/// Writes the last picture: the device's, or the safety copy if the device is lost, perhaps only when it is read.
fn write_last(running: &mut Running, rendered: Result<()>, watch: &Watch<'_>) -> Written {
    let mut errors = None;
    let lost = match rendered {
        // The picture would be wrong, so the files of an earlier moment are kept.
        Err(Error::Render(_) | Error::LoopCut(_)) => {
            return Written { rescued: None, errors, rendered, written: Ok(()) };
        }
        Err(error) if error.is_loss() => error,
        rendered => {
            let source = running.source();
            let written =
                source.and_then(|source| write_measured(running, &source, rendered.is_ok(), &mut errors, watch));
            match (written, rendered) {
                (Err(error), Ok(())) if error.is_loss() => error,
                (written, rendered) => return Written { rescued: None, errors, rendered, written },
            }
        }
    };
    let copied = running.take_safety_copy();
    let clause = match &copied {
        Some(CopiedPicture { samples, .. }) => {
            format!("the picture has the {samples} samples per pixel that were last read back from the device")
        }
        None => "there is no picture, because none had been read back from the device".to_owned(),
    };
    let written =
        copied.as_ref().map_or(Ok(()), |copied| write_measured(running, &copied.picture, false, &mut errors, watch));
    let rescued = copied.map(|copied| copied.picture);
    Written { rescued, errors, rendered: Err(lost.noting(&clause)), written }
}

/// Measures a picture's errors and writes it.
fn write_measured(
    running: &Running,
    picture: &dyn Strips,
    is_rendered: bool,
    errors: &mut Option<Metrics>,
    watch: &Watch<'_>,
) -> Result<()> {
    if running.output().measures() {
        watch.tell(Event::Finishing("measuring the errors against the reference"));
    }
    let measured = running.output().measure(picture).map(|measured| *errors = measured);
    errors.iter().for_each(|errors| watch.tell(Event::Note(&error_sentence(errors))));
    write_sampled(running, picture, is_rendered, watch).and(measured)
}

/// Writes a picture, unless it has no samples at all.
fn write_sampled(running: &Running, picture: &dyn Strips, is_rendered: bool, watch: &Watch<'_>) -> Result<()> {
    let counts = SampleCounts::of(picture)?;
    let SampleCounts { pixels: all, empty, .. } = counts;
    if empty < all {
        if empty > 0 {
            watch.warn(&format!("{empty} of {all} pixels are black: the render ended before their first sample"));
        }
        running.output().pictures.half_warning(picture)?.iter().for_each(|warning| watch.warn(warning));
        if running.output().denoises() {
            watch.tell(Event::Finishing("denoising the picture"));
        }
        let denoised = running.output().denoise(picture);
        // A picture that cannot be denoised is still written.
        let layer = denoised.as_ref().ok().and_then(Option::as_ref);
        let exposure = running.output().pictures.exposure_line(picture, layer)?;
        exposure.iter().for_each(|line| watch.tell(Event::Note(line)));
        let written = running.write_counted(picture, counts, layer, watch);
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

/// Writes the guide of a render that has not failed, if the caller wants it. A render without samples has none.
fn write_guide(running: &Running, watch: &Watch<'_>) -> Result<()> {
    let Some(path) = running.output().guide.as_ref().filter(|_| running.samples_done() > 0) else {
        return Ok(());
    };
    running.write_guide(path)?;
    watch.tell(Event::Written(path));
    Ok(())
}

/// Line about the errors against the reference.
fn error_sentence(errors: &Metrics) -> String {
    let Metrics { mae, relmse, mean_ratio, .. } = errors;
    format!("against the reference: MAE {mae:.4}, relMSE {relmse:.4}, mean {mean_ratio:.4} of its mean")
}

/// Tells `watch` the validation layer's messages. Any message makes the render fail.
fn tell_validation(running: &Running, watch: &Watch<'_>) -> Result<()> {
    let messages = running.context().validation_messages();
    messages.iter().for_each(|message| watch.tell(Event::Validation(message)));
    match messages.len() {
        0 => Ok(()),
        count => Err(Error::Render(format!("the validation layer reported {count} problems"))),
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

/// Warning of shadow rays through more surfaces than the kernels follow, which make the picture too dark.
fn warning_of_cut_shadow_rays(count: u64) -> Option<String> {
    (count > 0).then(|| {
        format!(
            "{count} shadow rays crossed so many holes or sheets of glass that their paths had more than {MAX_DEPTH_LIMIT} edges: \
             their light is missing"
        )
    })
}

/// Warning of rays through more of a medium's grid than the kernels follow, which make the picture too dark.
fn warning_of_cut_flights(count: u64) -> Option<String> {
    (count > 0).then(|| {
        format!(
            "{count} rays met more blocks and particles of a medium's grid than kernels follow: their light is missing; \
             a smaller `scale` of the medium helps"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::{warning_of_cut_flights, warning_of_cut_shadow_rays};

    #[test]
    fn cut_flights_are_told() {
        assert_eq!(warning_of_cut_flights(0), None);
        assert!(warning_of_cut_flights(8).is_some_and(|warning| warning.starts_with("8 rays met")));
    }

    #[test]
    fn cut_shadow_rays_are_told() {
        assert_eq!(warning_of_cut_shadow_rays(0), None);
        assert!(warning_of_cut_shadow_rays(8).is_some_and(|warning| warning.starts_with("8 shadow rays crossed")));
    }
}
