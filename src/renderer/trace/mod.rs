//! Tracing paths: by one kernel that follows each path to its end, or as waves.

pub(super) mod dispatch;
pub(super) mod slices;
pub(super) mod wavefront;
