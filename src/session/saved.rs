//! Checkpoints in their files. A checkpoint may come from somebody else, so its hashes say only that it is whole. Everything in it is
//! checked before it is used, and its state is read into memory once it is known to be what the render needs.

use std::path::Path;

use crate::renderer::RenderState;
use crate::session::checkpoint::{CHECKPOINT, Checkpoint, Header, Record, SceneSource};
use crate::session::sealed::{Reader, SavedParts};
use crate::settings::Settings;
use crate::{Error, Result};

/// Least bytes of a state for each pixel: those of the film.
const FILM_BYTES: u64 = 64;

/// A checkpoint whose state is still in its file.
#[derive(Debug)]
pub struct SavedCheckpoint {
    /// File and fingerprint of the scene.
    pub scene: SceneSource,
    /// The settings. They are valid.
    pub settings: Settings,
    /// Device and driver on which the render began.
    pub device: String,
    /// Length, files and steps of the render.
    pub record: Record,
    /// The state.
    pub state: SavedState,
}

/// State of a render in the file of a checkpoint.
#[derive(Debug)]
pub struct SavedState {
    /// Samples per pixel so far.
    pub samples_done: u32,
    parts: SavedParts,
}

impl SavedCheckpoint {
    /// Opens a checkpoint of this version, and checks everything but whether its state suits a render.
    ///
    /// # Errors
    /// [`Error::Read`], or [`Error::Checkpoint`] if the file is no checkpoint, is of another version, was cut short or was
    /// altered.
    pub fn open(path: &Path) -> Result<Self> {
        let mut reader = Reader::open(path, &CHECKPOINT)?;
        let header: Header = reader.header()?;
        header.settings.validate().map_err(|error| Error::checkpoint(path, error.to_string()))?;
        check(&header).map_err(|fault| Error::checkpoint(path, format!("{fault}; go on from another copy")))?;
        let Header { scene, settings, device, record, samples_done, parts, .. } = header;
        check_film(path, reader.check_lengths(&parts)?, &settings)?;
        let state = SavedState { samples_done, parts: reader.into_parts(parts)? };
        Ok(Self { scene, settings, device, record, state })
    }
}

impl Checkpoint {
    /// Reads a checkpoint of this version with all of its state.
    ///
    /// # Errors
    /// Where [`SavedCheckpoint::open`] fails.
    pub fn read(path: &Path) -> Result<Self> {
        let SavedCheckpoint { scene, settings, device, record, state } = SavedCheckpoint::open(path)?;
        let state = state.read(|_, _| true)?;
        Ok(Self { scene, settings, device, record, state })
    }
}

impl SavedState {
    /// The parts whose names and lengths in bytes are `wanted`.
    ///
    /// # Errors
    /// Where the file cannot be read, or was altered since it was opened.
    pub fn read(&self, wanted: impl Fn(&str, u64) -> bool) -> Result<RenderState> {
        Ok(RenderState { samples_done: self.samples_done, parts: self.parts.read(wanted)? })
    }

    /// The whole state, if its parts have these names and lengths in bytes.
    ///
    /// # Errors
    /// Where the state has other parts, or where [`SavedState::read`] fails.
    pub fn read_as(&self, shape: &[(String, u64)]) -> Result<RenderState> {
        let theirs = self.parts.shape();
        if theirs != shape {
            let list = |parts: &[(String, u64)]| {
                let parts = parts.iter().map(|(name, bytes)| format!("{name:?}: {bytes} bytes"));
                parts.collect::<Vec<_>>().join(", ")
            };
            let message = format!("its state has {}, but this render has {}", list(&theirs), list(shape));
            return Err(Error::checkpoint(self.parts.path(), message));
        }
        self.read(|_, _| true)
    }
}

/// Checks values that the settings' own rules do not cover. The error is a clause.
fn check(header: &Header) -> Result<(), &'static str> {
    let Header { scene, settings, device, record, samples_done, .. } = header;
    let is_text = |text: &String| !text.chars().any(char::is_control);
    let is_time = |seconds: f64| seconds >= 0.0;
    let offset = settings.sample_offset.unwrap_or(0);
    match () {
        () if !is_text(device)
            || !is_text(&scene.hash)
            || !is_text(&scene.world_hash)
            || !record.kernels.iter().all(is_text) =>
        {
            Err("it names its device, scene or kernels by control characters")
        }
        () if !is_time(record.history.seconds) || !record.length.seconds.is_none_or(is_time) => {
            Err("it has a negative time")
        }
        () if offset.checked_add(*samples_done).is_none() || !record.guide_samples.is_sound() => {
            Err("it has sample numbers that no render takes")
        }
        () => Ok(()),
    }
}

/// Refuses a state that cannot hold a film of the settings' size, by its length in bytes.
fn check_film(path: &Path, bytes: u64, settings: &Settings) -> Result<()> {
    let window = settings.window();
    if u64::from(window.width) * u64::from(window.height) <= bytes / FILM_BYTES {
        return Ok(());
    }
    let (width, height) = (window.width, window.height);
    let message =
        format!("it lacks {FILM_BYTES} bytes per pixel for {width} x {height} pixels; go on from another copy");
    Err(Error::checkpoint(path, message))
}
