//! Programs: textures that are computed. A front end's textures become a [`graph::Graph`], whose operations have constants
//! folded and equal parts joined as they are added; [`schedule::schedule`] makes the list of instructions of it that kernels
//! run. `src/encode/textures/programs.rs` writes the words, `glsl/include/texture/program.glsl` reads them.

pub mod graph;
pub mod operation;
pub mod schedule;

pub use operation::Operation;
pub use schedule::{Instruction, Place, Program};
