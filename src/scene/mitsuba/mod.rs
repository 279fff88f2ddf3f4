//! Mitsuba's formats: XML and dictionaries, which become a description, and the writer of XML.

mod budget;
pub(in crate::scene) mod convert;
pub mod dictionary;
mod document;
mod element;
pub(in crate::scene) mod entries;
mod mesh_arrays;
mod old_files;
mod values;
pub(in crate::scene) mod xml;
