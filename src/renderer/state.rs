//! What a renderer must keep to go on later as if it had never stopped: the memory that outlives a step.

use std::ops::Range;

use super::Renderer;
use super::film_store::sums::FilmSums;
use crate::gpu::Buffer;
use crate::{Error, Result};

/// Everything that complete steps have left behind.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RenderState {
    /// Samples per pixel so far.
    pub samples_done: u32,
    /// The device's memory, in the order in which a renderer of the same settings expects it.
    pub parts: Vec<StatePart>,
}

/// One part of it, in the device's (little-endian) byte order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatePart {
    /// What it holds.
    pub name: String,
    /// The bytes.
    pub bytes: Vec<u8>,
}

/// Parts of buffers that hold, one after the other, something that outlives a step.
pub(super) struct Persistent<'a> {
    pub name: &'static str,
    pub spans: Vec<Span<'a>>,
}

/// A part of a buffer.
pub(super) struct Span<'a> {
    pub buffer: &'a Buffer,
    pub bytes: Range<u64>,
}

impl<'a> From<&'a Buffer> for Span<'a> {
    /// All of it.
    fn from(buffer: &'a Buffer) -> Self {
        Self { buffer, bytes: 0..buffer.len_bytes() }
    }
}

impl Span<'_> {
    fn len_bytes(&self) -> u64 {
        self.bytes.end - self.bytes.start
    }

    fn read(&self) -> Result<Vec<u8>> {
        self.buffer.read(self.bytes.start, self.len_bytes() as usize)
    }
}

impl<'a> Persistent<'a> {
    /// One buffer.
    pub fn whole(name: &'static str, buffer: &'a Buffer) -> Self {
        Self { name, spans: vec![buffer.into()] }
    }
}

impl Persistent<'_> {
    fn len_bytes(&self) -> u64 {
        self.spans.iter().map(Span::len_bytes).sum()
    }

    fn read(&self) -> Result<StatePart> {
        let pages: Vec<Vec<u8>> = self.spans.iter().map(Span::read).collect::<Result<_>>()?;
        Ok(StatePart { name: self.name.into(), bytes: pages.concat() })
    }

    fn write(&self, mut bytes: &[u8]) -> Result<()> {
        for span in &self.spans {
            let (page, rest) = bytes.split_at(span.len_bytes() as usize);
            span.buffer.upload(span.bytes.start, page)?;
            bytes = rest;
        }
        Ok(())
    }
}

impl Renderer {
    /// Reads back what complete steps have left. How the film is cut into pages has no part in it.
    ///
    /// # Errors
    /// Where the device is lost, or a step was stopped: some pixels then have samples of it that others lack.
    pub fn state(&self) -> Result<RenderState> {
        if self.stopped {
            return Err(Error::Render("a step that was stopped cannot be gone on with later".into()));
        }
        let parts: Result<Vec<_>> = self.persistent().iter().map(Persistent::read).collect();
        let parts = parts?.into_iter().chain(self.host_part()).collect();
        Ok(RenderState { samples_done: self.samples_done, parts })
    }

    /// Goes on from where a renderer of the same scene and settings has been: from here on both do the same to the last bit.
    ///
    /// # Errors
    /// Where the state does not fit the settings, or the device is lost.
    pub fn restore(&mut self, state: &RenderState) -> Result<()> {
        let persistent = self.persistent();
        let shape = |parts: &[(&str, u64)]| {
            parts.iter().map(|(name, bytes)| format!("{name}: {bytes} bytes")).collect::<Vec<_>>().join(", ")
        };
        let host_part = self.host_part();
        let of_host = host_part.iter().map(|part| (&part.name[..], part.bytes.len() as u64));
        let ours: Vec<_> = persistent.iter().map(|part| (part.name, part.len_bytes())).chain(of_host).collect();
        let theirs: Vec<_> = state.parts.iter().map(|part| (&part.name[..], part.bytes.len() as u64)).collect();
        if ours != theirs {
            let (theirs, ours) = (shape(&theirs), shape(&ours));
            return Err(Error::Render(format!("the saved state holds {theirs}, but this render has {ours}")));
        }
        persistent.iter().zip(&state.parts).try_for_each(|(part, saved)| part.write(&saved.bytes))?;
        if let (Some(sums), Some(saved)) = (&mut self.film_sums, state.parts.last()) {
            sums.restore(&saved.bytes);
        }
        (self.samples_done, self.stopped, self.at_step_end) = (state.samples_done, false, true);
        self.judge()
    }

    /// What is kept beside the device's memory.
    fn host_part(&self) -> Option<StatePart> {
        let part = |sums: &FilmSums| StatePart { name: "film sums".into(), bytes: sums.bytes().to_vec() };
        self.film_sums.as_ref().map(part)
    }

    /// What outlives a step. A complete one leaves no sums in a radiance grid: it has learned from them.
    fn persistent(&self) -> Vec<Persistent<'_>> {
        let film = self.frame.persistent().into_iter();
        film.chain(self.radiance_grid.persistent()).chain(self.normalization_grid.persistent()).collect()
    }
}
