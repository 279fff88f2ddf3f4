//! Reports of a render that has begun: its progress, its statistics, and its unfinished picture.

use crate::Result;
use crate::film::ranges::SampleRanges;
use crate::film::strips::{SampleCounts, Strips};
use crate::film::{Denoised, Picture};
use crate::image::metrics::Metrics;
use crate::session::devices::device_name;
use crate::session::identity;
use crate::session::progress::{Beginning, Event, Progress, Watch};
use crate::session::running::Running;
use crate::session::statistics::{Statistics, StepStatistics, Totals, Versions, peak_resident_bytes};
use crate::session::subject::Subject;
use crate::settings::Settings;

impl Running {
    /// Tells `watch` that the render begins.
    pub fn tell_beginning(&self, watch: &Watch<'_>) {
        watch.tell(Event::Begun(&Beginning {
            scene: &self.subject.scene_path,
            scene_hash: &self.subject.scene_hash,
            device: &device_name(&self.context),
            settings: &self.settings,
            length: self.length,
            samples: self.samples_done(),
            files: &self.output.pictures.paths,
        }));
        self.renderer().memory_note().iter().for_each(|note| watch.tell(Event::Note(note)));
    }

    /// Progress of the render.
    pub fn progress(&self) -> Progress {
        let samples = self.samples_done();
        Progress {
            samples,
            seconds: self.history.seconds,
            paths: self.history.paths,
            light_hit_rate: self.history.steps.last().map_or(0.0, |step| step.light_hit_rate),
            noise: self.renderer().noise(),
            fraction: self.length.fraction(samples, self.history.seconds),
            length: self.length,
        }
    }

    /// Number of pixels of the rendered window.
    pub fn pixels(&self) -> u64 {
        let window = self.settings.window();
        u64::from(window.width) * u64::from(window.height)
    }

    /// Names and values that the header of a picture's file holds.
    pub fn attributes(&self, picture: &Picture) -> Vec<(String, String)> {
        self.attributes_of(picture.sample_count.iter().copied().max().unwrap_or(0))
    }

    /// Names and values for a picture of which no pixel has more samples.
    fn attributes_of(&self, most_samples: u32) -> Vec<(String, String)> {
        let Subject { scene_hash, scene_path, kernels, .. } = &self.subject;
        // Where the device has chosen the traversal, the picture names the one that it has.
        let settings = Settings { traversal: self.renderer().traversal(), ..self.settings.clone() };
        let mut attributes = identity::attributes(scene_hash, &settings);
        attributes.extend([
            ("sample_ranges".into(), SampleRanges::of_picture(most_samples, &self.settings).to_string()),
            ("spp".into(), most_samples.to_string()),
            ("seconds".into(), format!("{:.3}", self.history.seconds)),
            ("device".into(), device_name(&self.context)),
            ("scene".into(), scene_path.display().to_string()),
        ]);
        if !kernels.is_empty() {
            attributes.push(("replaced_kernels".into(), kernels.join(", ")));
        }
        attributes
    }

    /// Writes the picture's files.
    pub fn write_pictures(&self, picture: &dyn Strips, watch: &Watch<'_>) -> Result<()> {
        self.write_counted(picture, SampleCounts::of(picture)?, None, watch)
    }

    /// Writes like [`Running::write_pictures`] a picture whose samples are counted, with a denoised layer if there is one.
    pub fn write_counted(
        &self,
        picture: &dyn Strips,
        counts: SampleCounts,
        denoised: Option<&Denoised>,
        watch: &Watch<'_>,
    ) -> Result<()> {
        self.output.write(picture, denoised, &self.attributes_of(counts.most), watch)
    }

    /// Writes the unfinished picture if its interval has passed.
    pub fn write_if_due(&mut self, watch: &Watch<'_>) -> Result<()> {
        if !self.output.is_due() || self.is_done(watch) {
            return Ok(());
        }
        let written = self.write_pictures(&self.source()?, watch);
        self.output.note_writing(&written, watch);
        Ok(())
    }

    /// All numbers about the render so far.
    pub fn statistics(&self) -> Statistics {
        self.statistics_with(self.history.steps.last().and_then(|step| step.errors))
    }

    /// All numbers about the render so far; `errors` is the error of the last picture.
    pub fn statistics_with(&self, errors: Option<Metrics>) -> Statistics {
        let device = self.context.device().clone();
        let spp = self.samples_done().into();
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
                noise: self.renderer().noise(),
                sharing: self.fleet.sharing_times(),
                peak_bytes: self.fleet.peak_device_bytes(),
                peak_resident_bytes: peak_resident_bytes(),
            },
            steps,
        }
    }
}
