//! Constants that both sides know, numbers of bindings, and the specialization constants: what `build.rs` writes from
//! `glsl/include/shared`. Knows nothing of the device.

include!(concat!(env!("OUT_DIR"), "/constants.rs"));
include!(concat!(env!("OUT_DIR"), "/variant.rs"));
