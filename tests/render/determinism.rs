//! Equal seeds give equal bits, however the work is cut.

use std::path::Path;
use std::process::Command;

use lodestar::film::Picture;
use lodestar::film::layers::{Layer, Values};
use lodestar::image::exr::{read_layer, read_rgb};
use lodestar::scene::{Crop, Scene};
use lodestar::settings::{Sampler, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::rows::{Held, combinations, held_to, row, samplers};
use support::scenes::{SAMPLERS, ours, settings};
use support::tier;

use crate::device::Device;

/// Bits of every number of the picture.
pub fn bits(picture: &Picture) -> Vec<u32> {
    let bits = |layer: Layer<'_>| match layer.values {
        Values::Floats(values) => values.iter().map(|value| value.to_bits()).collect(),
        Values::Counts(counts) => counts.to_vec(),
    };
    picture.layers().into_iter().flat_map(bits).collect()
}

/// Size that is not a whole number of tiles. The samples take several steps.
const SIZE: [u32; 2] = [100, 61];
const SPP: u32 = 36;

fn scene() -> Scene {
    ours("cornell-box/scene.xml", &[])
}

fn changed(scene: &Scene, sampler: Sampler, change: impl FnOnce(&mut Settings)) -> Settings {
    let mut settings = settings(scene, SIZE, sampler, 11);
    change(&mut settings);
    settings
}

#[test]
fn no_way_of_cutting_the_work_changes_a_bit() {
    let device = Device::validated();
    let scene = scene();
    for sampler in SAMPLERS {
        let render = |change: &dyn Fn(&mut Settings)| {
            let settings = changed(&scene, sampler, change);
            bits(&device.render(&scene, &settings, SPP))
        };
        let first = render(&|_| {});
        assert!(first == render(&|_| {}), "{sampler:?}: a second time");
        assert!(first == render(&|s| s.slice_milliseconds = Some(1.0)), "{sampler:?}: slices of 1 ms");
        assert!(first == render(&|s| s.slice_milliseconds = Some(500.0)), "{sampler:?}: slices of 500 ms");
        assert!(first == render(&|s| s.film_page_pixels = Some(256)), "{sampler:?}: film pages");
        assert!(first != render(&|s| s.seed = 12), "{sampler:?}: another seed");
    }
}

/// Learned sums do not depend on the order of their targets, for all samplers and learners.
#[test]
fn every_way_to_follow_a_guide_gives_the_same_bits() {
    let device = Device::validated();
    let scene = scene();
    let check = |name: &str, set: &dyn Fn(&mut Settings)| {
        let render = |milliseconds| {
            let settings = changed(&scene, Sampler::RejectionMix, |s| {
                set(s);
                s.slice_milliseconds = milliseconds;
            });
            bits(&device.render(&scene, &settings, 20))
        };
        assert!(render(None) == render(Some(1.0)), "{name}: slices of 1 ms");
    };
    held_to(Held::Guided).iter().for_each(|row| check(row.name, &|s| row.set(s)));
    for (sampler, learner) in combinations().into_iter().filter(|_| tier::is_full()) {
        check(&format!("{sampler:?} and {learner:?}"), &|s| (s.sampler, s.learner) = (sampler, learner));
    }
}

/// Samples per dispatch change the picture by rounding only, because they change how moments are merged.
#[test]
fn samples_per_dispatch_change_no_more_than_rounding() {
    let device = Device::validated();
    let scene = scene();
    for sampler in SAMPLERS {
        let render = |samples_per_dispatch| {
            let settings = changed(&scene, sampler, |s| s.samples_per_dispatch = samples_per_dispatch);
            device.render(&scene, &settings, SPP)
        };
        let (a, b) = (render(8), render(3));
        assert_eq!(a.sample_count, b.sample_count);
        for (a, b) in a.radiance.iter().flatten().zip(b.radiance.iter().flatten()) {
            assert!((a - b).abs() <= 1.0e-5 * a.abs().max(1.0e-3), "{sampler:?}: {a} {b}");
        }
    }
}

/// Reads through texel buffers and through storage buffers give equal bits.
#[test]
fn storage_reads_change_no_bit() {
    let device = Device::validated();
    let scene = scene();
    for &sampler in tier::some_of(&samplers(), 2) {
        let render =
            |storage_reads| device.render(&scene, &changed(&scene, sampler, |s| s.storage_reads = storage_reads), SPP);
        let (texels, storage) = (render(false), render(true));
        let differing = bits(&texels).iter().zip(bits(&storage)).filter(|(a, b)| **a != *b).count();
        println!("{sampler:?}: {differing} of {} numbers differ", bits(&texels).len());
        assert!(bits(&texels) == bits(&storage), "{sampler:?}");
    }
}

#[test]
fn a_crop_window_holds_the_whole_picture_s_pixels() {
    let device = Device::validated();
    let scene = scene();
    let whole = device.render(&scene, &changed(&scene, Sampler::Bsdf, |_| {}), SPP);
    let window = Crop { x: 37, y: 5, width: 21, height: 50 };
    let part = device.render(&scene, &changed(&scene, Sampler::Bsdf, |s| s.crop = Some(window)), SPP);
    assert_eq!((part.width, part.height, part.offset, part.full_size), (21, 50, [37, 5], SIZE));
    let whole_image = whole.image().crop([37, 5], 21, 50).expect("a window");
    assert!(whole_image.pixels == part.radiance);
    assert!(whole.variance_image().crop([37, 5], 21, 50).expect("a window").pixels == part.variance);
}

/// A guide that has learned only from a crop window does not change the window's mean.
#[test]
fn a_guided_crop_window_has_the_whole_picture_s_mean() {
    let device = Device::validated();
    let scene = scene();
    let window = Crop { x: 36, y: 4, width: 24, height: 48 };
    let whole = device.render(&scene, &changed(&scene, Sampler::RejectionMix, |_| {}), 128);
    let part = |s: &mut Settings| (s.crop, s.seed) = (Some(window), 12);
    let part = device.render(&scene, &changed(&scene, Sampler::RejectionMix, part), 128);
    let crop = |image: lodestar::image::Image| image.crop([36, 4], 24, 48).expect("a window");
    let whole = Estimate::new(&crop(whole.image()), &crop(whole.variance_image()));
    let comparison = Comparison::new(&whole, &Estimate::of(&part), &[24, WHOLE]);
    assert!(comparison.agrees(), "{comparison:?}");
}

fn render_with_threads(threads: &str, options: &str, output: &Path) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/scene.xml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lodestar"));
    command.arg("render").arg(scene).arg("-o").arg(output);
    command.args(["--width", "100", "--height", "61", "--spp", "24", "--seed", "5", "--quiet"]);
    command.args(options.split(' '));
    let status = command.env("LP_NUM_THREADS", threads).status().expect("a run");
    assert!(status.success());
}

/// One thread and two give equal bits. The driver reads their number when it starts, so each case is a process of its
/// own.
#[test]
fn one_thread_and_two_give_the_same_bits() {
    let folder = tempfile::tempdir().expect("a folder");
    let guided = held_to(Held::Guided).into_iter().chain([row("bsdf")]).filter(|_| tier::is_full());
    for row in [row("grid-auto")].into_iter().chain(guided) {
        let pictures = ["1", "2"].map(|threads| {
            let path = folder.path().join(format!("{}-{threads}.exr", row.name));
            render_with_threads(threads, row.options, &path);
            (read_rgb(&path).expect("a picture"), read_layer(&path, "variance").expect("a layer"))
        });
        assert!(pictures[0] == pictures[1], "{}", row.name);
    }
}
