//! A session before its first step: what it begins with, once the other ranks are known.

use crate::encode::cells::Cells;
use crate::session::checkpoint::Record;
use crate::session::checkpoints::{CheckpointFile, Checkpoints};
use crate::session::guide_file::GuideFile;
use crate::session::progress::{Beginning, Event, Watch};
use crate::session::run::Session;
use crate::session::saved::SavedState;
use crate::{Error, Result};

/// The part of a render that a checkpoint holds.
pub(super) struct Earlier {
    pub record: Record,
    pub device: String,
    pub state: SavedState,
}

/// A session that the other ranks do not know yet.
pub(super) struct Prepared {
    pub session: Session,
    /// Names of the devices with their drivers, of all ranks once these are known.
    pub devices: Vec<String>,
    pub earlier: Option<Earlier>,
    /// Guide that begins the render, with its cells.
    pub guide: Option<(GuideFile, Cells)>,
    pub checkpoint: Option<CheckpointFile>,
    /// Whether tiles are dealt out to devices by their measured speed.
    pub deals_by_speed: bool,
}

impl Prepared {
    /// The session with the state and the guide that it begins with.
    pub fn begin(self, watch: &Watch<'_>) -> Result<Session> {
        let Self { mut session, devices, earlier, guide, checkpoint, deals_by_speed } = self;
        if !session.fleet.leads() {
            return Ok(session);
        }
        warn_of_mix(&devices, watch);
        if deals_by_speed && devices.len() > 1 {
            let weights = session.fleet.deal_by_speed()?;
            watch.tell(Event::Note(&dealt(&devices, &weights)));
        }
        let samples_written = earlier.map(|earlier| session.go_on_from(earlier, watch)).transpose()?;
        if let Some((guide, cells)) = guide {
            guide.begin(cells, &mut session)?;
        }
        if let Some(file) = checkpoint {
            session.checkpoints = Some(Checkpoints::new(file, session.template()?, samples_written));
        }
        session.tell_beginning(watch);
        Ok(session)
    }
}

impl Session {
    fn tell_beginning(&self, watch: &Watch<'_>) {
        watch.tell(Event::Begun(&Beginning {
            scene: &self.subject.scene_path,
            scene_hash: &self.subject.scene_hash,
            device: &self.device_name(),
            settings: &self.settings,
            length: self.length,
            samples: self.fleet.first().samples_done(),
            files: &self.output.pictures.paths,
        }));
    }

    /// Restores the state of a checkpoint and returns its number of samples per pixel.
    fn go_on_from(&mut self, earlier: Earlier, watch: &Watch<'_>) -> Result<u32> {
        let Earlier { record: Record { kernels, history, guide_samples, .. }, device, state, .. } = earlier;
        self.check_kernels(&kernels)?;
        let own_device = self.device_name();
        if device != own_device {
            watch.warn(&format!("the render began on {device}; on {own_device}, the last bits may differ"));
        }
        let state = state.read_as(&self.fleet.first().state_shape())?;
        self.fleet.restore(&state)?;
        self.fleet.set_guide_samples(guide_samples);
        let samples = state.samples_done;
        self.origin.checkpoint = Some((state, history.clone()));
        self.history = history;
        Ok(samples)
    }

    /// Refuses to go on with other kernels than before, because the bits would differ.
    fn check_kernels(&self, before: &[String]) -> Result<()> {
        let kernels = &self.subject.kernels;
        if before == kernels {
            return Ok(());
        }
        let list = |kernels: &[String]| match kernels {
            [] => "the built-in kernels".to_owned(),
            kernels => kernels.join(", "),
        };
        Err(Error::Settings(format!(
            "the render began with {}, but would go on with {}: give the same --kernel-dir",
            list(before),
            list(kernels)
        )))
    }
}

/// How tiles were dealt out, in one sentence.
fn dealt(devices: &[String], weights: &[u32]) -> String {
    let all: u32 = weights.iter().sum();
    let of_device = |(device, weight): (&String, &u32)| format!("{weight} of {all} to {device}");
    format!("tiles by measured speed: {}", devices.iter().zip(weights).map(of_device).collect::<Vec<_>>().join(", "))
}

/// Warns where devices of several kinds render one picture.
fn warn_of_mix(devices: &[String], watch: &Watch<'_>) {
    if devices.iter().any(|device| *device != devices[0]) {
        watch.warn(
            "devices of different kinds render this picture: it is unbiased, but its last bits depend on the devices and \
             their order",
        );
    }
}
