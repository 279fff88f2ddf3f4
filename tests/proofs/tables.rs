//! Radiance tables to test a guide with: made-up ones, and ones learned in a render.

use std::sync::OnceLock;

use glam::DVec3;
use lodestar::settings::{DirectionMap, SamplePattern, Sampler, Settings};
use support::guide_cases;
use support::scenes::ours;

use crate::renders::Studio;
use crate::subject::SHIPPED;

/// Radiance of the cell with the sharpest contrast: after the first step, and after the second.
struct Learned([Vec<f32>; 2]);

/// Named radiance tables of a cell. Tests fill them in one after the other, each over the one before. The last table is
/// one step newer than the table before it.
pub fn tables(map: DirectionMap, nb: DVec3) -> Vec<(&'static str, Vec<f32>)> {
    let [before, after] = learned(map).0.clone();
    let learned = [("learned a step before", before), ("freshly learned", after)];
    guide_cases::tables(map, nb).into_iter().chain(learned).collect()
}

fn learned(map: DirectionMap) -> &'static Learned {
    static LEARNED: [OnceLock<Learned>; 2] = [OnceLock::new(), OnceLock::new()];
    LEARNED[map as usize].get_or_init(|| learn(map))
}

fn learn(map: DirectionMap) -> Learned {
    let scene = ours("cornell-box/scene.xml", &[]);
    let settings = Settings {
        width: 32,
        height: 32,
        sampler: Sampler::RejectionMix,
        directions: guide_cases::DIRECTIONS,
        map,
        seed: 3,
        nee: false,
        pattern: SamplePattern::Independent,
        ..Settings::for_scene(&scene)
    };
    let studio = Studio::new();
    let mut renderer = studio.renderer(&SHIPPED, &scene, settings.clone());
    let mut grids = [16, 8].map(|samples| {
        renderer.step(samples, &|| false).expect("a step");
        renderer.radiance().expect("a table")
    });
    let bins = settings.directions.pow(2) as usize;
    let contrast = |cell: &[f32]| cell.iter().copied().fold(0.0, f32::max) / cell.iter().sum::<f32>();
    let cells = || grids[1].chunks(bins).enumerate().filter(|(_, cell)| cell.iter().filter(|&&l| l > 0.1).count() > 8);
    let (best, _) = cells().max_by(|a, b| contrast(a.1).total_cmp(&contrast(b.1))).expect("a cell");
    Learned(grids.each_mut().map(|grid| grid[best * bins..(best + 1) * bins].to_vec()))
}
