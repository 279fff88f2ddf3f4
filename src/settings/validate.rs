//! Checks of settings as a whole.

use super::flat::Settings;
use super::options;
use super::run::Execution;
use crate::Result;

impl Settings {
    /// Refuses a value that is out of its range and a combination that cannot be rendered, by the table of [`options`].
    ///
    /// # Errors
    /// [`crate::Error::Settings`], naming the option and the values that it may have.
    pub fn validate(&self) -> Result<()> {
        options::check(self)?;
        self.check_crop()
    }

    /// Refuses settings whose paths cannot be traced as waves.
    pub(crate) fn check_wavefront(&self) -> Result<()> {
        options::check(&Self { execution: Execution::Wavefront, ..self.clone() })
    }
}
