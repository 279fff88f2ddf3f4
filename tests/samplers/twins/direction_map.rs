//! Maps of directions on the CPU, tested against known results.

use glam::dvec2;
use lodestar::math::direction_map::{bin_center, map_to_sphere};
use lodestar::settings::DirectionMap;
use support::twins::direction_map::{map_antipode, sphere_to_map};

const MAPS: [DirectionMap; 2] = [DirectionMap::EqualArea, DirectionMap::Cylindrical];

#[test]
fn the_maps_are_invertible_and_unit() {
    let points = (0..10_000_u32).map(|i| (f64::from(i % 100), f64::from(i / 100)));
    for p in points.map(|(x, y)| dvec2((x + 0.37) / 50.0 - 1.0, (y + 0.61) / 50.0 - 1.0)) {
        for map in MAPS {
            let w = map_to_sphere(map, p);
            assert!((w.length() - 1.0).abs() < 1e-12);
            assert!((sphere_to_map(map, w) - p).length() < 1e-9, "{p} became {}", sphere_to_map(map, w));
            assert!((map_to_sphere(map, map_antipode(map, p)) + w).length() < 1e-12);
        }
    }
}

#[test]
fn equal_areas_have_equal_moments() {
    // The mean of z^2 over the sphere is 1/3, and that of every odd power is 0. Both fail for a map that is not
    // equal-area.
    let n = 400;
    for map in MAPS {
        let mut moments = [0.0; 3];
        for i in 0..n * n {
            let w = bin_center(map, i, n);
            moments = [moments[0] + w.z * w.z, moments[1] + w.x.powi(3), moments[2] + w.x * w.x];
        }
        let mean = moments.map(|m| m / f64::from(n * n));
        assert!((mean[0] - 1.0 / 3.0).abs() < 1e-4 && mean[1].abs() < 1e-10 && (mean[2] - 1.0 / 3.0).abs() < 1e-4);
    }
}
