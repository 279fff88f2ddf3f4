//! One render from its start to its end: checkpoints, identity, where its time goes.

pub mod checkpoint;
pub mod profile;
pub mod radiance_map;

pub use crate::film::identity;
