//! The devices of a session.

use std::sync::Arc;

use crate::Result;
use crate::gpu::Context;
use crate::session::options::DeviceChoice;

/// Name of a device with its driver, as checkpoints and pictures have it.
pub(super) fn device_name(context: &Context) -> String {
    let device = context.device();
    format!("{} ({})", device.name, device.driver_info)
}

impl DeviceChoice {
    /// Opens the devices: at least one. Ranks on one machine take its devices in turn.
    pub(super) fn open(&self, local_rank: Option<usize>) -> Result<Vec<Arc<Context>>> {
        match self {
            Self::Open(options) => match local_rank {
                Some(local_rank) if options.device.is_none() => Ok(vec![Context::of_local_rank(options, local_rank)?]),
                _ => Context::all(options),
            },
            Self::Opened(context) => Ok(vec![Arc::clone(context)]),
        }
    }
}
