//! Ranks of a session. The first rank uses the session as a render without other ranks does. The others do what it names.

use std::sync::Arc;

use crate::fleet::team::{Member, Team};
use crate::session::options::Options;
use crate::session::prepared::Prepared;
use crate::{Error, Result};

/// Makes a prepared render known to the other ranks, if there are some. Where one rank cannot render, none does.
pub(super) fn join(options: &Options, prepared: Result<Prepared>) -> Result<Prepared> {
    let Some(exchange) = &options.exchange else { return prepared };
    let member = |prepared: &Prepared| Member {
        machine: exchange.machine(),
        process: std::process::id(),
        devices: prepared.devices().to_vec(),
        facts: prepared.facts(),
    };
    let (prepared, own) = match prepared {
        Ok(prepared) => {
            let own = member(&prepared);
            (Some(prepared), Ok(own))
        }
        Err(error) => (None, Err(error)),
    };
    let team = Arc::new(Team::gather(Arc::clone(exchange), own)?);
    let Some(prepared) = prepared else {
        return Err(Error::Render("this rank cannot render, but the others go on".into()));
    };
    // A rank that fails here must not leave the others waiting.
    team.close(prepared.join(&team))
}

impl Options {
    /// Whether the caller is the first rank, or the only one.
    pub(super) fn leads(&self) -> bool {
        self.exchange.as_ref().is_none_or(|exchange| exchange.rank() == 0)
    }
}
