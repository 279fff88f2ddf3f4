//! Work of all ranks: the first rank names it, and every rank does it in the same way.

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::fleet::failure;
use crate::fleet::team::Team;
use crate::renderer::RenderState;

/// Work that the first rank names.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Command {
    /// One step of a render.
    Step { samples: u32 },
    /// Dealing out tiles by the speed of the devices.
    DealBySpeed,
    /// Gathering the film.
    Film,
    /// Gathering everything that outlives a step.
    State,
    /// Going on from a state.
    Restore(RenderState),
    /// Beginning again with other samples per dispatch.
    BeginAgain { samples_per_dispatch: u32, state: Option<RenderState> },
}

/// Does some work on the first rank, and has the other ranks do it, too. A render without other ranks does it alone.
pub(super) fn lead<T>(
    team: Option<&Team>,
    command: impl FnOnce() -> Command,
    act: impl FnOnce() -> Result<T>,
) -> Result<T> {
    let Some(team) = team else { return act() };
    team.command(&failure::encode(&command()))?;
    team.close(act())
}
