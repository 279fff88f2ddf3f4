//! The command line as scripts see it: exit codes, files, standard output and standard error.

mod bad_input;
mod compare;
mod devices;
mod files;
mod inspect;
mod kernel_dir;
mod length;
mod profile;
mod signals;
mod statistics;
mod streams;
mod support;
