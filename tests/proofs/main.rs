//! Proofs that no sampler is biased. Every claim is tested for all samplers, learners and scattering functions. Another
//! test proves that the claims are sharp: each known fault, in kernels of its own, must be found. See `docs/proofs.md`.

mod billion;
mod claims;
mod evidence;
mod renders;
mod rows;
mod subject;
mod tables;
mod tampering;
