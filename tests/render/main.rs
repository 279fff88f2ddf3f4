//! Whole pictures against closed forms, against each other, against another renderer, and against themselves.
//!
//! Every statistical test is made with fixed seeds, so that it comes out the same every time, and has a twin with a fault
//! that it must find.

mod analytic;
mod blue_noise;
mod cells;
mod choices;
mod closed;
mod determinism;
mod device;
mod drivers;
mod execution;
mod guide_set;
mod learning;
mod nee;
mod noise;
mod pattern;
mod relief;
mod resume;
mod roulette;
mod significance;
mod variance;
mod weights;
mod ztest;
