//! The Python module `lodestar`: scenes, renders, pictures and guides of the library, in Python's habits.
//!
//! The interpreter is released while the library works. The library's errors become `lodestar.Error` with the same sentences,
//! and its warnings become Python's warnings.
#![deny(missing_docs)]

mod arrays;
mod command;
mod compare;
mod devices;
mod dictionary;
mod errors;
mod guide;
mod merge;
mod options;
mod picture;
mod renderer;
mod scene;
mod shared;
mod transform;

/// Compiled part of the package `lodestar`.
#[pyo3::pymodule]
mod _lodestar {
    /// Version of the package and of the library.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
    #[pymodule_export]
    use crate::command::run_command;
    #[pymodule_export]
    use crate::compare::compare;
    #[pymodule_export]
    use crate::devices::devices;
    #[pymodule_export]
    use crate::errors::Error;
    #[pymodule_export]
    use crate::guide::Guide;
    #[pymodule_export]
    use crate::merge::merge;
    #[pymodule_export]
    use crate::options::options;
    #[pymodule_export]
    use crate::picture::Picture;
    #[pymodule_export]
    use crate::renderer::{Renderer, render, resume};
    #[pymodule_export]
    use crate::scene::{Scene, convert, load};
    #[pymodule_export]
    use crate::transform::ScalarTransform4f;
}
