//! placeholder
pub mod interface;
