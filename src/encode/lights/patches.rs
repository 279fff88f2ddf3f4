//! How many patches the lights of a scene are cut into, so that the cells of a guide can learn to choose among them.

use super::groups::{ONE_NODE, group_count};
use crate::encode::bvh::Bvh;
use crate::generated::constants;
use crate::scene::Scene;

/// How many lights there are, and into how many patches they are cut.
pub(super) struct Patches {
    /// Patches along each side of an area light.
    pub area_side: usize,
    /// Patches along each side of the environment.
    pub environment_side: usize,
    /// Number of all lights, each patch counted.
    pub light_count: usize,
    /// Number of groups among which cells learn to choose; 0 where lights are drawn in proportion to their power.
    pub group_count: usize,
    has_environment: bool,
}

impl Patches {
    /// Patches of a scene with so many area lights. If cells learn which lights to draw, all flat lights are cut into as many patches
    /// as have a group each, and not at all if one of the lights is a sphere.
    pub fn new(scene: &Scene, bvh: &Bvh, area_count: usize, learned: bool) -> Self {
        let has_environment = scene.environment.is_some();
        let with_sides = |area_side: usize, environment_side: usize| {
            let of_environment = if has_environment { environment_side * environment_side } else { 0 };
            let light_count = area_count * area_side * area_side + scene.delta_emitters.len() + of_environment;
            let group_count = if learned { group_count(light_count) } else { 0 };
            Self { area_side, environment_side, light_count, group_count, has_environment }
        };
        let environment_side = constants::ENVIRONMENT_PATCHES as usize;
        let whole = with_sides(1, environment_side);
        // Samples of spheres depend on the point that is lit, so they have no patches.
        let sides = if bvh.has_emitting_spheres() { [1; 3] } else { [4, 2, 1] };
        let cut = sides.map(|side| with_sides(side, environment_side)).into_iter().find(|cut| {
            let most = if whole.group_count == 0 { ONE_NODE } else { whole.group_count };
            learned && cut.light_count <= most
        });
        let patches = cut.unwrap_or(whole);
        if patches.group_count == 0 { with_sides(1, 1) } else { patches }
    }

    /// Number of patches of the environment; 0 without one.
    pub fn environment_patches(&self) -> usize {
        if self.has_environment { self.environment_side * self.environment_side } else { 0 }
    }
}
