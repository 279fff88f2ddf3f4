//! The plan of a render: what was asked, once the scene is known. Bad input and files that cannot be written are found before the
//! render begins.

use crate::film::ranges::SampleRanges;
use crate::image::Image;
use crate::renderer::PictureWork;
use crate::scene::Scene;
use crate::session::checkpoint::Record;
use crate::session::files::{OutputFiles, PictureFiles, read_reference};
use crate::session::guide_file::GuideFile;
use crate::session::identity::Identity;
use crate::session::kernel_files::KernelFiles;
use crate::session::length::Length;
use crate::session::options::Options;
use crate::session::progress::{Event, Watch};
use crate::session::saved::{SavedCheckpoint, SavedState};
use crate::session::start::Resumed;
use crate::settings::Settings;
use crate::{Error, Result};

/// Settings and length of a render whose scene is known, and the part of it that a checkpoint holds.
pub(super) struct Plan {
    pub settings: Settings,
    pub length: Length,
    pub earlier: Option<Earlier>,
}

/// The part of a render that a checkpoint holds.
pub(super) struct Earlier {
    pub record: Record,
    pub device: String,
    pub state: SavedState,
}

/// Files and kernels of a render. They are read and tried before the render begins.
pub(super) struct Inputs {
    pub wanted: OutputFiles,
    pub pictures: PictureFiles,
    pub kernels: KernelFiles,
    /// The picture that errors are measured against.
    pub reference: Option<Image>,
}

impl Plan {
    pub fn new(
        scene: &Scene,
        scene_hash: &str,
        resumed: Option<Resumed>,
        guide: Option<&GuideFile>,
        options: &Options,
        watch: &Watch<'_>,
    ) -> Result<Self> {
        let mut plan = match resumed {
            None => Self::anew(scene, options)?,
            Some(resumed) if resumed.is_asked => Self::resumed(resumed, options, scene_hash)?,
            Some(found) => Self::anew(scene, options)?.going_on(found, scene_hash, guide, watch)?,
        };
        plan.complete(options)?;
        if plan.earlier.is_none() {
            options.depth_warning(scene).iter().for_each(|warning| watch.warn(warning));
        }
        Ok(plan)
    }

    fn anew(scene: &Scene, options: &Options) -> Result<Self> {
        let settings = options.settings_for(scene)?;
        let length = options.length_for(scene, &settings);
        Ok(Self { settings, length, earlier: None })
    }

    /// This new render, which goes on from the checkpoint that it has found in its file. It must be the checkpoint of this render.
    fn going_on(self, found: Resumed, scene_hash: &str, guide: Option<&GuideFile>, watch: &Watch<'_>) -> Result<Self> {
        let Self { mut settings, length, .. } = self;
        let Resumed { file, checkpoint: SavedCheckpoint { scene, settings: theirs, device, record, state }, .. } =
            found;
        // Where a driver ends loops early, a render goes on with a half, a quarter, ... of the samples per dispatch.
        let halves = std::iter::successors(Some(settings.samples_per_dispatch), |samples| Some(samples / 2));
        if halves.take_while(|&samples| samples > 0).any(|samples| samples == theirs.samples_per_dispatch) {
            settings.samples_per_dispatch = theirs.samples_per_dispatch;
        }
        let (there, here) = (Identity::of_render(&scene.hash, &theirs), Identity::of_render(scene_hash, &settings));
        let named = |ranges: &SampleRanges| if ranges.first().is_some() { ranges.to_string() } else { "none".into() };
        let guide_samples = guide.map(GuideFile::samples).unwrap_or_default();
        let of_guide = (guide_samples != record.guide_samples).then(|| {
            let [there, here] = [&record.guide_samples, &guide_samples].map(named);
            format!("samples of the guide that it began with ({there} there, {here} here)")
        });
        let differences: Vec<_> = there.difference(&here).into_iter().chain(of_guide).collect();
        let done = state.samples_done;
        if !differences.is_empty() {
            let differences = differences.join(", ");
            let message =
                format!("it is the checkpoint of another render: {differences}; give another name or remove it");
            return Err(Error::checkpoint(file, message));
        }
        if length.spp.is_some_and(|spp| spp < done) {
            let message = format!(
                "it holds {done} samples per pixel of this render already, and --spp asks for less; give another name or \
                 remove it"
            );
            return Err(Error::checkpoint(file, message));
        }
        let file = file.display();
        watch.tell(Event::Note(&format!(
            "{file} holds {done} samples per pixel of this render; it goes on with them (remove the file to begin anew)"
        )));
        // The caller names the pictures.
        let record = Record { outputs: PictureFiles::none(), ..record };
        Ok(Self { settings, length, earlier: Some(Earlier { record, device, state }) })
    }

    fn resumed(resumed: Resumed, options: &Options, scene_hash: &str) -> Result<Self> {
        let Resumed { file, checkpoint: SavedCheckpoint { scene, settings, device, record, state }, .. } = resumed;
        if scene.hash != scene_hash {
            let message = format!(
                "the scene has changed since the render began: scene_hash ({} there, {scene_hash} here); undo the changes \
                 to {} and to the files that it reads",
                scene.hash, scene.path
            );
            return Err(Error::checkpoint(file, message));
        }
        let length = match options.length {
            asked if asked.is_given() => {
                let seconds = asked.seconds.map(|seconds| record.history.seconds + seconds);
                Length { spp: asked.spp, seconds }
            }
            _ => record.length,
        };
        if length.spp.is_some_and(|spp| spp < state.samples_done) {
            let message = format!("it holds {} samples per pixel already; ask for more with --spp", state.samples_done);
            return Err(Error::checkpoint(file, message));
        }
        if options.leads() && options.files.as_ref().is_none_or(|files| files.pictures.is_empty()) {
            record.outputs.check_place(&file)?;
        }
        Ok(Self { settings, length, earlier: Some(Earlier { record, device, state }) })
    }

    /// Sets the settings that do not decide what the picture is, and checks all settings.
    fn complete(&mut self, options: &Options) -> Result<()> {
        options.complete(&mut self.settings, &self.length)
    }
}

impl Inputs {
    pub fn new(plan: &Plan, scene: &Scene, options: &Options, watch: &Watch<'_>) -> Result<Self> {
        let earlier = plan.earlier.as_ref().map(|earlier| &earlier.record.outputs);
        let pictures = match &options.files {
            Some(wanted) => PictureFiles::new(wanted, earlier, scene)?,
            None => earlier.cloned().unwrap_or_else(PictureFiles::none),
        };
        let kernels = KernelFiles::load(options.kernel_folder.as_deref())?;
        kernels.warnings().iter().for_each(|warning| watch.warn(warning));
        let wanted = options.files.clone().unwrap_or_default();
        let reference = wanted.reference.as_deref().map(|path| read_reference(path, &plan.settings)).transpose()?;
        Ok(Self { wanted, pictures, kernels, reference })
    }

    /// Work on the picture besides writing it.
    pub fn picture_work(&self) -> PictureWork {
        PictureWork {
            is_denoised: self.wanted.denoise.is_some(),
            is_compared: self.reference.is_some(),
            has_auto_exposure: self.pictures.chooses_exposure(),
        }
    }
}
