//! Layers besides the radiance.

use lodestar::film::Picture;
use lodestar::settings::Sampler;
use support::scenes::{SAMPLERS, ours, settings};
use support::significance::{ALPHA, sidak, two_sided};
use support::tier;

use crate::device::Device;

const SEEDS: u32 = 32;

/// Spread of the radiance over several pictures (an unbiased variance) and mean of the variance layer, per pixel and
/// channel.
pub fn spread_and_claim(pictures: &[Picture]) -> Vec<(f64, f64)> {
    let count = pictures.len() as f64;
    let one = |at: usize, channel: usize| {
        let mean_of =
            |value: &dyn Fn(&Picture) -> f32| pictures.iter().map(|p| f64::from(value(p))).sum::<f64>() / count;
        let mean = mean_of(&|p| p.radiance[at][channel]);
        let squares = pictures.iter().map(|p| (f64::from(p.radiance[at][channel]) - mean).powi(2));
        (squares.sum::<f64>() / (count - 1.0), mean_of(&|p| p.variance[at][channel]))
    };
    (0..pictures[0].radiance.len()).flat_map(|at| [0, 1, 2].map(|channel| one(at, channel))).collect()
}

/// Spread over variance layer, and the ratio's deviation from 1 in standard errors. The layer is first multiplied by
/// `fault`. Both are unbiased, so their differences have mean 0. Pixels are independent. Channels are not, so they are
/// summed first.
pub fn ratio_and_deviation(pixels: &[(f64, f64)], fault: f64) -> (f64, f64) {
    let of_pixel = |channels: &[(f64, f64)]| {
        channels.iter().fold((0.0, 0.0), |sum, (spread, claim)| (sum.0 + spread, sum.1 + claim * fault))
    };
    let sums: Vec<_> = pixels.chunks(3).map(of_pixel).collect();
    let (spread, claim) = sums.iter().fold((0.0, 0.0), |sum, pixel| (sum.0 + pixel.0, sum.1 + pixel.1));
    let error = sums.iter().map(|(spread, claim)| (spread - claim).powi(2)).sum::<f64>().sqrt();
    (spread / claim, (spread - claim) / error)
}

/// The variance layer is the spread of pictures over seeds. The quick tier has one sampler.
#[test]
fn the_variance_layer_is_the_spread_over_seeds() {
    let device = Device::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    for &sampler in tier::some_of(&SAMPLERS, 1) {
        let picture = |seed| device.render(&scene, &settings(&scene, [32, 32], sampler, 1000 + seed), 32);
        let pixels = spread_and_claim(&(0..SEEDS).map(picture).collect::<Vec<_>>());
        for (fault, is_right) in [(1.0, true), (1.3, false), (1.0 / 1.3, false)] {
            let (ratio, z) = ratio_and_deviation(&pixels, fault);
            println!("{sampler:?} claims x {fault:.2}: spread / claim = {ratio:.4}, z = {z:.2}");
            assert_eq!(sidak(two_sided(z), SAMPLERS.len()) > ALPHA, is_right, "{sampler:?} {fault}");
        }
    }
}

#[test]
fn features_are_those_of_the_first_hit() {
    let device = Device::new();
    let mut scene = ours("furnace/scene.xml", &[("albedo", "0.25, 0.5, 0.75")]);
    scene.camera.world_from_camera.w_axis = glam::Vec4::W;
    for sampler in SAMPLERS {
        let picture = device.render(&scene, &settings(&scene, [24, 16], sampler, 3), 20);
        assert!(picture.sample_count.iter().all(|&count| count == 20));
        for at in 0..24 * 16 {
            let normal = glam::Vec3::from(picture.normal()[at]);
            let (x, y) = ((at % 24) as f32 + 0.5, (at / 24) as f32 + 0.5);
            let screen = glam::vec3(1.0 - x / 12.0, (1.0 - y / 8.0) * 16.0 / 24.0, 1.0);
            let towards = scene.camera.world_from_camera.transform_vector3(screen).normalize();
            // The sphere has radius 1 and normals that point to the eye. A pixel averages many normals.
            assert!((picture.depth()[at] - 1.0).abs() < 1.0e-5, "{}", picture.depth()[at]);
            assert!(normal.length() < 1.0 + 1.0e-5 && normal.length() > 0.999, "{normal}");
            assert!(normal.dot(towards) < -0.999, "{normal} {towards}");
            assert!(glam::Vec3::from(picture.albedo()[at]).distance(glam::vec3(0.25, 0.5, 0.75)) < 1.0e-5);
        }
    }
}

#[test]
fn flat_walls_have_unit_normals() {
    let device = Device::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    let picture = device.render(&scene, &settings(&scene, [32, 32], Sampler::Bsdf, 3), 8);
    // The back wall is visible between the tops of the blocks and the ceiling.
    let at = 32 * 9 + 16;
    assert!(glam::Vec3::from(picture.normal()[at]).distance(glam::Vec3::NEG_Z) < 1.0e-5, "{:?}", picture.normal()[at]);
    assert!((picture.depth()[at] - 1378.0).abs() < 30.0, "{}", picture.depth()[at]);
    assert!((picture.albedo()[at][0] - 0.725).abs() < 1.0e-5);
}

#[test]
fn one_sample_has_no_variance_and_a_miss_no_depth() {
    let device = Device::new();
    let mut scene = ours("furnace/scene.xml", &[]);
    scene.primitives.clear();
    let picture = device.render(&scene, &settings(&scene, [8, 8], Sampler::Bsdf, 3), 1);
    assert!(picture.sample_count.iter().all(|&count| count == 1));
    assert!(picture.variance.iter().flatten().all(|&variance| variance == 0.0));
    assert!(picture.depth().iter().all(|depth| depth.is_infinite()));
    assert!(picture.albedo().iter().chain(picture.normal()).flatten().all(|&value| value == 0.0));
}
