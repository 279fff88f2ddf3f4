//! Grid whose resolution the renderer chooses for the scene.

use lodestar::settings::{AUTO_GRID, Sampler, Settings};
use support::scenes::{ours, settings};
use support::tier;

use crate::device::Device;

const BUDGET: u64 = 8 << 20;

/// A chosen grid is as fine as its memory allows. The quick tier has one scene.
#[test]
fn a_chosen_grid_is_as_fine_as_its_memory_allows() {
    let device = Device::new();
    for scene in tier::some_of(&["cornell-box/scene.xml", "door-ajar/scene.xml", "furnace/scene.xml"], 1) {
        let scene = ours(scene, &[]);
        let settings = Settings { fallback: Some(4.0), ..settings(&scene, [16, 16], Sampler::Product, 1) };
        let bytes = |grid| device.renderer(&scene, &Settings { grid, ..settings.clone() }).guide_bytes();
        let chosen = bytes(AUTO_GRID);
        println!("{chosen} bytes, {} of 8 cells a side", bytes(8));
        assert!(chosen <= BUDGET && chosen > BUDGET / 2, "{chosen}");
        // The twin must fail: a finer grid does not fit.
        assert!(bytes(32) > BUDGET);
    }
}

/// A plain path tracer keeps no cells, because nothing is guided.
#[test]
fn a_plain_path_tracer_has_no_cells() {
    let scene = ours("cornell-box/scene.xml", &[]);
    let settings = settings(&scene, [16, 16], Sampler::Bsdf, 1);
    assert_eq!(Device::new().renderer(&scene, &settings).guide_bytes(), 0);
}
