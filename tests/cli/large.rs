//! Large pictures, which are read back some rows at a time, and the formats of files.

use lodestar::film::read_picture;
use lodestar::image::color;

use crate::support::Folder;

/// Bytes of a pixel on the device, which a copy of the picture takes in the host's memory, too.
const PIXEL_BYTES: f64 = 64.0;
/// Just above the size up to which pictures are read back whole.
const SIZE: [&str; 4] = ["--width", "2112", "--height", "2000"];

/// Memory that a render takes besides the buffers on its device. It has a cache of kernels that no other test uses.
fn besides(folder: &Folder, arguments: &[&str]) -> Option<f64> {
    let all = [&["render", "scene.xml", "--quiet", "--stats", "stats.json"], arguments].concat();
    let output = folder.command(&all).env("XDG_CACHE_HOME", folder.path("cache")).output().unwrap();
    // A warning may tell of pixels without a sample.
    assert!(output.status.success(), "{output:?}");
    let totals = &folder.read_json("stats.json")["totals"];
    Some(totals["peak_resident_bytes"].as_f64()? - totals["peak_bytes"].as_f64()?)
}

/// Memory that the render of a small picture takes besides. Another one before it leaves its kernels in the cache, so none of those that are
/// compared compiles any.
fn besides_small(folder: &Folder) -> Option<f64> {
    let small = ["--spp", "1", "--sampler", "bsdf", "--width", "64", "--height", "64", "-o", "small.exr"];
    besides(folder, &small);
    besides(folder, &small)
}

/// A whole copy of the large picture would be twice the bound. Its rows have the bits of a window that is read back whole.
#[test]
fn a_large_picture_is_written_without_a_copy_of_it() {
    let folder = Folder::new();
    let common = ["--spp", "1", "--sampler", "bsdf"];
    let [width, height] = [2112, 2000];
    let small = besides_small(&folder);
    let large = besides(&folder, &[&common[..], &SIZE, &["-o", "large.exr"]].concat());
    if let (Some(small), Some(large)) = (small, large) {
        let copy = PIXEL_BYTES * f64::from(width * height);
        assert!(large - small < copy / 2.0, "{} of {copy} bytes besides the film", large - small);
    }
    folder.render(&[&common[..], &SIZE, &["--crop", "0%,50%,100%,25%", "-o", "window.exr"]].concat());
    let [large, window] = ["large.exr", "window.exr"].map(|name| read_picture(&folder.path(name)).unwrap().0);
    assert_eq!([window.offset, [window.width, window.height]], [[0, 1000], [2112, 500]]);
    let first = 1000 * width as usize;
    let rows = first..first + window.radiance.len();
    assert!(large.radiance[rows.clone()] == window.radiance && large.variance[rows.clone()] == window.variance);
    assert!(large.albedo()[rows.clone()] == *window.albedo() && large.depth()[rows] == *window.depth());
    assert_eq!((large.offset, large.full_size, large.view), ([0, 0], [2112, 2000], window.view));
}

/// A denoiser's memory is told with the rest. It takes more than the film.
#[test]
fn memory_of_a_denoiser_is_told() {
    let Some(library) = support::denoiser_folder() else { return };
    let folder = Folder::new();
    let small = besides_small(&folder);
    let size = ["--width", "640", "--height", "512"];
    let denoised = ["--spp", "1", "--sampler", "bsdf", "--denoise", "--oidn", library.to_str().unwrap()];
    let denoised = besides(&folder, &[&denoised[..], &size, &["-o", "denoised.exr"]].concat());
    if let (Some(small), Some(denoised)) = (small, denoised) {
        let told = 32.0e6 + f64::from(640 * 512) * (2.0 * 64.0 + 96.0 + 720.0);
        let taken = denoised - small;
        assert!(taken < 1.5 * told && taken > 0.5 * told, "{taken} bytes are taken, {told} are told");
    }
    let large =
        ["render", "scene.xml", "--spp", "1", "--width", "65536", "--height", "65536", "--denoise", "-o", "a.exr"];
    let output = folder.command(&large).env("LODESTAR_OIDN", &library).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && message.contains("denoising it 416 GB (none without --denoise)"), "{message}");
}

/// A render that ends early touches the film's memory only where it has samples.
#[test]
fn memory_that_no_sample_reaches_is_not_touched() {
    let folder = Folder::new();
    let small = besides_small(&folder);
    let large = ["--sampler", "bsdf", "--width", "2112", "--height", "4200", "--time", "0.01", "-o", "large.png"];
    if let (Some(small), Some(large)) = (small, besides(&folder, &large)) {
        let film = PIXEL_BYTES * f64::from(2112 * 4200);
        assert!(large < small - film / 4.0, "{small} and {large} bytes beside the buffers, {film} of the film");
    }
}

#[test]
fn pictures_have_the_format_that_their_names_ask_for() {
    let folder = Folder::new();
    let names = ["a.exr", "a.png", "a.jpg", "a.hdr", "a.tif"];
    let outputs: Vec<_> = names.iter().flat_map(|name| ["-o", name]).collect();
    folder.render(&[&["--width", "32", "--height", "32", "--spp", "8", "--tone", "agx"], &outputs[..]].concat());
    let read = |name: &str| color::read(&folder.path(name)).unwrap();
    let (exr, note) = read("a.exr");
    assert_eq!(note, None);
    let (hdr, note) = read("a.hdr");
    assert_eq!(note, None);
    for (hdr, exr) in hdr.pixels.iter().zip(&exr.pixels) {
        let largest = exr.iter().copied().fold(0.0, f32::max);
        assert!(hdr.iter().zip(exr).all(|(hdr, exr)| (hdr - exr).abs() <= largest / 64.0), "{hdr:?}, {exr:?}");
    }
    let (png, jpeg) = (read("a.png"), read("a.jpg"));
    assert!([&png.1, &jpeg.1].iter().all(|note| note.as_ref().is_some_and(|note| note.contains("8 bits per channel"))));
    let mean = |pixels: &[[f32; 3]]| pixels.iter().map(|pixel| pixel[1]).sum::<f32>() / pixels.len() as f32;
    assert!((mean(&png.0.pixels) - mean(&jpeg.0.pixels)).abs() < 0.02);
    let tiff = read("a.tif");
    assert!(tiff.1.is_some_and(|note| note.contains("16 bits per channel")));
    for (tiff, png) in tiff.0.pixels.as_flattened().iter().zip(png.0.pixels.as_flattened()) {
        // Half a level of 8 bits is at most 0.0045 at white.
        assert!((tiff - png).abs() < 0.005, "{tiff} and {png}");
    }
    // `compare` takes any of them.
    let output = folder.run(&["compare", "a.hdr", "a.png", "a.exr"]);
    assert!(output.status.success(), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("a.png: 8 bits per channel, taken as sRGB"));
}
