//! Other ranks than the first one: each does what the first one names until the render ends.

use crate::Result;
use crate::fleet::Fleet;
use crate::fleet::command::Command;
use crate::fleet::failure;

impl Fleet {
    /// Does what the first rank names until the render ends.
    ///
    /// # Errors
    /// Where the first rank is lost. Where work fails, the first rank decides what follows.
    pub fn serve(&mut self) -> Result<()> {
        let Some(team) = self.team.clone() else { return Ok(()) };
        loop {
            let Some(command) = team.next_command()? else { return Ok(()) };
            let done = failure::decode(&command).and_then(|command| self.obey(command));
            // The error has reached the first rank.
            let _ = team.close(done);
        }
    }

    fn obey(&mut self, command: Command) -> Result<()> {
        match command {
            // The first rank's orders to stop are looked for while paths are traced.
            Command::Step { samples } => self.take_step(samples, &|| false).map(drop),
            Command::DealBySpeed => self.measure_and_deal().map(drop),
            Command::Film => self.gather_film(),
            Command::State => self.gather_state(),
            Command::Restore(state) => self.go_on_from(&state),
            Command::BeginAgain { samples_per_dispatch, state } => {
                self.start_over(samples_per_dispatch, state.as_ref())
            }
        }
    }
}
