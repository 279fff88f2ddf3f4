//! Whole pictures against closed forms, against each other, against another renderer, and against themselves.
//!
//! Every statistical test has fixed seeds, so that it always passes or always fails, and a twin with a planted fault
//! that must fail.

mod analytic;
mod another_scene;
mod another_view;
mod blue_noise;
mod cells;
mod choices;
mod closed;
mod closed_forms;
mod deforming;
mod determinism;
mod device;
mod differences;
mod drivers;
mod execution;
mod facing;
mod grids;
mod guide_from;
mod guide_set;
mod hair;
mod instances;
mod layers;
mod learning;
mod light_selection;
mod media;
mod motion;
mod nee;
mod noise;
mod passages;
mod pattern;
mod profile;
mod ranks;
mod relief;
mod resume;
mod retry;
mod roulette;
mod scales;
mod significance;
mod teams;
mod traversal;
mod unseen;
mod variance;
mod weights;
mod ztest;
