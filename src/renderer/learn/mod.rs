//! Learning between two steps.

pub(super) mod quadtrees;
