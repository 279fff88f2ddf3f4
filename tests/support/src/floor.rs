//! Radiance of one point of a floor, in closed form, for every kind of light of `scenes/lights/floor.xml`.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};
use lodestar::encode::lights::EnvironmentMap;
use lodestar::scene::{EnvironmentKind, Scene};

use crate::scenes::ours;
use crate::twins::light::environment_radiance;

/// Lights that rays can hit, and lights that no ray can hit.
pub const SPREAD: [&str; 7] = ["rectangle", "textured", "disk", "sphere", "facing", "constant", "envmap"];
pub const DELTA: [&str; 3] = ["point", "spot", "directional"];

/// Reflectance of the floor in `floor.xml`.
pub const ALBEDO: f64 = 0.5;

/// Irradiance at the origin of a plane with normal +y, from a polygon of radiance 1 (Lambert 1760).
fn polygon_irradiance(vertices: &[DVec3]) -> f64 {
    let next = vertices.iter().cycle().skip(1);
    let edge = |(a, b): (&DVec3, &DVec3)| a.angle_between(*b) * a.cross(*b).normalize().y;
    0.5 * vertices.iter().zip(next).map(edge).sum::<f64>().abs()
}

/// Irradiance from a panel of radiance 1 above the origin, between these coordinates.
fn panel_irradiance(x0: f64, x1: f64, z0: f64, z1: f64) -> f64 {
    polygon_irradiance(&[(x0, z0), (x1, z0), (x1, z1), (x0, z1)].map(|(x, z)| dvec3(x, 2.0, z)))
}

/// Irradiance from the hemisphere with this radiance, by the midpoint rule.
fn hemisphere_irradiance(radiance: impl Fn(DVec3) -> DVec3) -> DVec3 {
    const STEPS: u32 = 1500;
    let cell = (0.5 * PI / f64::from(STEPS)) * (2.0 * PI / f64::from(2 * STEPS));
    let direction = |i: u32, j: u32| {
        let theta = 0.5 * PI * (f64::from(i) + 0.5) / f64::from(STEPS);
        let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(2 * STEPS);
        dvec3(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
    };
    let term = |d: DVec3| radiance(d) * d.y * (1.0 - d.y * d.y).sqrt() * cell;
    (0..STEPS).flat_map(|i| (0..2 * STEPS).map(move |j| direction(i, j))).map(term).sum()
}

fn map_irradiance(scene: &Scene) -> DVec3 {
    let Some(EnvironmentKind::Map { image, scale, to_world }) = scene.environment.map(|e| e.kind) else {
        panic!("no map")
    };
    let map = EnvironmentMap::new(&scene.images[image as usize]);
    let local = to_world.transpose().as_dmat3();
    f64::from(scale) * hemisphere_irradiance(|d| environment_radiance(&map, local * d))
}

/// Mean over the channels of the radiance that the point of `floor.xml` sends to the camera.
pub fn floor_radiance(light: &str) -> f64 {
    let up = |position: DVec3| position.normalize().y;
    let irradiance = match light {
        "rectangle" => dvec3(3.0, 2.0, 1.0) * panel_irradiance(0.5, 2.5, -1.5, 0.5),
        "textured" => {
            let colors = [dvec3(6.0, 1.0, 1.0), dvec3(0.0, 0.0, 2.0)];
            colors[0] * (panel_irradiance(0.5, 1.5, -1.5, -0.5) + panel_irradiance(1.5, 2.5, -0.5, 0.5))
                + colors[1] * (panel_irradiance(1.5, 2.5, -1.5, -0.5) + panel_irradiance(0.5, 1.5, -0.5, 0.5))
        }
        "disk" => dvec3(4.0, 3.0, 5.0) * (PI * 0.5625 / (0.5625 + 6.25)),
        "sphere" => {
            let center = dvec3(-1.0, 1.5, 0.5);
            dvec3(12.0, 13.0, 14.0) * (PI * 0.0625 / center.length_squared() * up(center))
        }
        "facing" => {
            let center = dvec3(-1.0, 1.5, 0.5);
            dvec3(5.0, 4.0, 6.0) * (PI * 0.25 / (0.25 + center.length_squared()) * up(center))
        }
        "constant" => dvec3(1.0, 0.75, 0.5) * PI,
        "envmap" => map_irradiance(&ours("lights/floor.xml", &[("light", "envmap")])),
        "point" => {
            let position = dvec3(-1.0, 2.0, 1.5);
            dvec3(9.0, 8.0, 7.0) * (up(position) / position.length_squared())
        }
        "spot" => {
            let (position, target) = (dvec3(-1.0, 3.0, 1.0), dvec3(0.5, 0.0, 0.0));
            let angle = (target - position).angle_between(-position).to_degrees();
            dvec3(19.0, 8.0, 7.0) * (up(position) / position.length_squared() * (30.0 - angle) / 25.0)
        }
        "directional" => dvec3(3.0, 2.0, 1.0) * up(dvec3(1.0, 2.0, 0.5)),
        _ => panic!("{light}"),
    };
    ALBEDO / PI * irradiance.element_sum() / 3.0
}
