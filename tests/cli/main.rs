//! Command line as scripts see it: exit codes, files, standard output and standard error.

mod bad_input;
mod compare;
mod denoise;
mod devices;
mod faults;
mod files;
mod full_disk;
mod headers;
mod help;
mod info;
mod inspect;
mod kernel_dir;
mod kills;
mod length;
mod log;
mod merge;
mod newcomer;
mod profile;
mod radiance;
mod reproduce;
mod resume;
mod signals;
mod statistics;
mod streams;
mod support;
mod writes;
