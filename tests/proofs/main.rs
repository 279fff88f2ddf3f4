//! Proofs that no sampler is biased: what is claimed of every sampler, learner and scattering function, tested at once, and
//! a proof that the tests find what they are for: known faults, each in kernels of its own. See `docs/proofs.md`.

mod billion;
mod claims;
mod evidence;
mod renders;
mod rows;
mod subject;
mod tables;
mod tampering;
