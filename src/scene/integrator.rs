//! Integrator of a scene.

/// Settings of the scene file's `integrator`; `None` where it leaves them open.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct IntegratorDescription {
    /// Longest path in edges; `Some(-1)` is Mitsuba's "unlimited".
    pub max_depth: Option<i32>,
    /// Depth from which Russian roulette is played.
    pub rr_depth: Option<i32>,
    /// Whether directly seen emission is left out, including the environment's.
    pub hide_emitters: bool,
}
