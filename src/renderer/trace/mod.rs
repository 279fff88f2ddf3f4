//! Tracing paths: by one kernel that follows each path to its end, or as waves.

pub(super) mod execution;
pub(super) mod slices;
pub(super) mod tracer;
pub(super) mod wave_memory;
pub(super) mod wavefront;
