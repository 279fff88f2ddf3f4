//! The command line as scripts see it: exit codes, files, standard output and standard error.

mod bad_input;
mod compare;
mod devices;
mod files;
mod length;
mod signals;
mod statistics;
mod streams;
mod support;
