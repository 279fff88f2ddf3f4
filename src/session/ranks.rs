//! Ranks of a session. The first rank uses the session as a render without other ranks does. The others do what it names.

use std::sync::Arc;

use crate::fleet::exchange::Exchange;
use crate::fleet::team::{Member, Team};
use crate::session::options::Options;
use crate::session::prepared::Prepared;
use crate::session::progress::Watch;
use crate::session::run::Session;
use crate::session::start::Start;
use crate::{Error, Result};

impl Session {
    /// Renders on another rank than the first one until the render ends. It writes no files. The first rank reports all errors.
    ///
    /// # Errors
    /// Where this rank or another one cannot render, or the first rank is lost.
    #[doc(hidden)]
    pub fn serve(start: Start<'_>, options: &Options, watch: &Watch<'_>) -> Result<()> {
        let mut options = options.clone();
        (options.files, options.checkpoint, options.guide_from) = (None, None, None);
        Self::start(start, &options, watch)?.fleet.serve()
    }
}

impl Options {
    /// Whether the caller is the first rank, or the only one.
    pub(super) fn leads(&self) -> bool {
        self.exchange.as_ref().is_none_or(|exchange| exchange.rank() == 0)
    }
}

/// Makes a prepared session known to the other ranks. Where one rank cannot render, none does.
pub(super) fn join(exchange: &Arc<dyn Exchange>, prepared: Result<Prepared>) -> Result<Prepared> {
    let member = |prepared: &Prepared| Member {
        machine: exchange.machine(),
        process: std::process::id(),
        devices: prepared.devices.clone(),
        facts: prepared.session.facts(),
    };
    let (prepared, own) = match prepared {
        Ok(prepared) => {
            let own = member(&prepared);
            (Some(prepared), Ok(own))
        }
        Err(error) => (None, Err(error)),
    };
    let team = Arc::new(Team::gather(Arc::clone(exchange), own)?);
    let Some(mut prepared) = prepared else {
        return Err(Error::Render("this rank cannot render, but the others go on".into()));
    };
    // A rank that fails here must not leave the others waiting.
    team.close(prepared.session.fleet.join(&team))?;
    prepared.devices = team.members().iter().flat_map(|member| member.devices.clone()).collect();
    Ok(prepared)
}

impl Session {
    /// Facts in which all ranks must agree.
    fn facts(&self) -> Vec<(String, String)> {
        let facts = [
            ("version".into(), env!("CARGO_PKG_VERSION").into()),
            ("scene_hash".into(), self.subject.scene_hash.clone()),
            ("kernels".into(), self.subject.kernels.join(", ")),
        ];
        facts.into_iter().chain(self.settings.named()).collect()
    }
}
