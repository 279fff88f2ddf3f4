//! What a method changes of its settings besides the sampler and how it learns.

use crate::settings::Settings;

/// Settings in place of others; `None` leaves what is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Changes {
    /// [`Settings::grid`].
    pub grid: Option<u32>,
    /// [`Settings::directions`].
    pub directions: Option<u32>,
}

impl Changes {
    /// Leaves everything.
    pub const NONE: Self = Self { grid: None, directions: None };

    /// The end of a method's name: `-g4-d32`.
    pub fn name(&self) -> String {
        let parts = [self.grid.map(|grid| format!("-g{grid}")), self.directions.map(|count| format!("-d{count}"))];
        parts.into_iter().flatten().collect()
    }

    /// Changes the settings.
    pub fn apply(&self, settings: &mut Settings) {
        settings.grid = self.grid.unwrap_or(settings.grid);
        settings.directions = self.directions.unwrap_or(settings.directions);
    }
}
