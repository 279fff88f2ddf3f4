//! Reproduction of the paper's tables and figures on any device. Every method renders every scene for the same time;
//! the methods take turns. The results stand beside the numbers of the paper.
//!
//! [`Plan::run`] does all of it. [`methods::METHODS`] lists the methods of Tables 1 and 2, each other target lists its
//! own, and [`paper::SCENES`] lists the scenes. Each result is a JSON file in the output folder. A result that exists
//! already under the same conditions is not measured again.

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
