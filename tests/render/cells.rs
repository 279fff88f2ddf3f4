//! Grid whose resolution the renderer chooses for the scene.

use lodestar::settings::{AUTO_GRID, Sampler, Settings};
use support::scenes::{ours, settings};
use support::tier;

use crate::device::Device;

/// Pixels along each side of a picture, and the most bytes of its guide: the first of 8, 16, 32 and 64 MiB that has 128 bytes for each
/// pixel, or the last.
const BUDGETS: [(u32, u64); 4] = [(16, 8 << 20), (300, 16 << 20), (400, 32 << 20), (800, 64 << 20)];

/// A chosen grid is as fine as its memory allows. The quick tier has one scene.
#[test]
fn a_chosen_grid_is_as_fine_as_its_memory_allows() {
    let device = Device::new();
    for scene in tier::some_of(&["cornell-box/scene.xml", "door-ajar/scene.xml", "furnace/scene.xml"], 1) {
        let scene = ours(scene, &[]);
        for (side, budget) in BUDGETS {
            let settings = settings(&scene, [side, side], Sampler::Product, 1);
            let bytes = |grid| device.renderer(&scene, &Settings { grid, ..settings.clone() }).guide_bytes();
            let chosen = bytes(None);
            assert!(chosen <= budget && chosen > budget / 2, "{chosen} bytes for {side} pixels a side");
            assert_eq!(bytes(Some(AUTO_GRID)), chosen);
            // The twin must fail: the finest grid fits no picture.
            assert!(bytes(Some(32)) > budget);
        }
    }
}

/// A plain path tracer keeps no cells, because nothing is guided.
#[test]
fn a_plain_path_tracer_has_no_cells() {
    let scene = ours("cornell-box/scene.xml", &[]);
    let settings = settings(&scene, [16, 16], Sampler::Bsdf, 1);
    assert_eq!(Device::new().renderer(&scene, &settings).guide_bytes(), 0);
}
