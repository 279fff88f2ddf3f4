//! Memory of the device that outlives a step.

use std::ops::Range;

use crate::Result;
use crate::gpu::Buffer;

/// Spans of buffers that hold, one after the other, something that outlives a step.
pub(super) struct Persistent<'a> {
    pub name: &'static str,
    pub spans: Vec<Span<'a>>,
}

/// A range of a buffer's bytes.
pub(super) struct Span<'a> {
    pub buffer: &'a Buffer,
    pub bytes: Range<u64>,
}

impl<'a> From<&'a Buffer> for Span<'a> {
    /// All of the buffer.
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
    pub fn len_bytes(&self) -> u64 {
        self.spans.iter().map(Span::len_bytes).sum()
    }

    pub fn read(&self) -> Result<Vec<u8>> {
        let spans: Vec<Vec<u8>> = self.spans.iter().map(Span::read).collect::<Result<_>>()?;
        Ok(spans.concat())
    }

    /// Fills the memory with zeros, as it was when it was made.
    pub fn clear(&self) -> Result<()> {
        let is_blank = self.spans.iter().all(|span| span.buffer.is_blank());
        if is_blank { Ok(()) } else { self.write(&vec![0; self.len_bytes() as usize]) }
    }

    /// # Panics
    /// Where the bytes are fewer than the spans'.
    pub fn write(&self, mut bytes: &[u8]) -> Result<()> {
        for span in &self.spans {
            let (of_span, rest) = bytes.split_at(span.len_bytes() as usize);
            span.buffer.upload(span.bytes.start, of_span)?;
            bytes = rest;
        }
        Ok(())
    }
}
