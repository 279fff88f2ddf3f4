//! The paper's tables and figures, measured on any device: every method renders every scene for the same time, by turns, and
//! what it comes to stands beside what the paper states.
//!
//! [`Plan::run`] is all of it. A method is a line of [`methods::METHODS`], or of a target of its own, a scene one of [`paper::SCENES`], and a result a
//! JSON file in the output folder: what is there already under the same conditions is not measured again.

pub mod ablation;
pub mod changes;
pub mod contest;
pub mod error_map;
pub mod figure1;
pub mod figure6;
pub mod figure7;
mod files;
pub mod methods;
pub mod paper;
mod plan;
pub mod plot;
pub mod protocol;
pub mod record;
pub mod resolution;
pub mod results;
mod run;
pub mod sheet;
mod stage;
pub mod table1;
pub mod table2;
#[cfg(test)]
mod testing;

pub use plan::{Plan, Target};
pub use run::{Status, Watch};
