//! Samplers on the device against their own densities and against their twins on the host.

mod device;
mod rejection_mix;
