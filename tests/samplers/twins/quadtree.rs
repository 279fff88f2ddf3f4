//! Twin of `glsl/include/guide/samplers/quadtree.glsl`, tested against known results.

use support::twins::quadtree::{FLUX_SHARE, Square};

fn tree() -> Square {
    let bright = Square::of([0.0, 1.0, 2.0, 30.0].map(Square::leaf));
    Square::of([Square::leaf(5.0), bright, Square::leaf(0.0), Square::leaf(1.0)]).refined()
}

#[test]
fn probabilities_add_up_and_densities_are_theirs() {
    let leaves = tree().leaves();
    assert!((leaves.iter().map(|leaf| leaf.2).sum::<f64>() - 1.0).abs() < 1.0e-12);
    for (corner, side, probability) in leaves {
        let density = tree().density(corner + 0.3 * side);
        assert!((density * side * side - probability).abs() < 1.0e-12, "{corner} {side}");
    }
}

#[test]
fn words_are_the_tree() {
    let words = tree().words();
    assert_eq!(words.len(), tree().node_count());
    assert!(Square::of_words(&words, tree().flux).is_near(&tree(), 1.0e-6));
    assert!(!Square::of_words(&words, 1.02 * tree().flux).is_near(&tree(), 1.0e-3));
}

/// Refinement bounds shares: every square without a node has at most a hundredth of the flux, and every square with a
/// node has more.
#[test]
fn refinement_bounds_shares() {
    let refined = tree();
    assert!(refined.leaves().iter().all(|leaf| leaf.2 <= FLUX_SHARE));
    assert!(refined.refined().is_near(&refined, 1.0e-12));
    assert_eq!(Square::leaf(0.0).refined().node_count(), 1);
}
