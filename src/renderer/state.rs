//! The state that a renderer keeps to go on later as if it had never stopped.

use serde::{Deserialize, Serialize};

/// Everything that complete steps have left behind.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RenderState {
    /// Samples per pixel so far.
    pub samples_done: u32,
    /// Memory of the device, in the order in which a renderer of the same settings expects it, then sums of the host.
    pub parts: Vec<StatePart>,
}

/// One part of a state, in the device's (little-endian) byte order.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StatePart {
    /// Name of the memory.
    pub name: String,
    /// Contents of the memory.
    pub bytes: Vec<u8>,
}
