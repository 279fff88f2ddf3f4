//! Errors with and without denoising, of plain and of guided renders, at 8, 32 and 128 samples per pixel.
//!
//! `cargo bench --bench denoising [-- SCENE...]` needs the shared scenes and references (`LODESTAR_SCENES`,
//! `LODESTAR_REFERENCES`), and Open Image Denoise (`LODESTAR_OIDN`, or what `setup.sh --oidn` unpacks). The size is that of the
//! references, or with `LODESTAR_DIVISOR=N` that over N: each pixel of the reference is then the mean of N x N. Both methods sample emitters as the default does. `LODESTAR_OUT=DIR` also writes files: `denoising.csv`, and for each
//! scene a sheet `SCENE.jpg` with a row for each number of samples: plain, plain denoised, guided, guided denoised, reference.
//!
//! The error is the mean absolute error of the displayed image, as in the paper. The CSV has those of the linear values and FLIP, too.

use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use lodestar::denoise::{DenoiseOptions, Denoiser};
use lodestar::gpu::Context;
use lodestar::image::comparison::Comparison;
use lodestar::image::{Image, exr};
use lodestar::settings::{Sampler, Settings};
use support::bench::pictures::{out_folder, write_jpeg};
use support::bench::{SHARED_SCENES, context, load, renderer, settings};

const SAMPLES: [u32; 3] = [8, 32, 128];
const METHODS: [(&str, Sampler); 2] = [("plain", Sampler::Bsdf), ("guided", Sampler::Product)];
/// Columns of the tables and sheets.
const COLUMNS: [&str; 4] = ["plain", "plain, denoised", "guided", "guided, denoised"];

/// Errors of one scene: for each number of samples, one for each column.
type Errors = [[Comparison; COLUMNS.len()]; SAMPLES.len()];

fn main() {
    let Some(references) = std::env::var_os("LODESTAR_REFERENCES").map(PathBuf::from) else {
        println!("skipped: LODESTAR_REFERENCES names no folder with reference images");
        return;
    };
    let unpacked = PathBuf::from("target/oidn");
    let named = std::env::var_os("LODESTAR_OIDN").is_some_and(|value| !value.is_empty());
    let folder = (!named && unpacked.exists()).then_some(unpacked);
    let denoiser = match Denoiser::open(&DenoiseOptions { folder, ..DenoiseOptions::default() }) {
        Ok(denoiser) => denoiser,
        Err(error) => {
            println!("skipped: {error}");
            return;
        }
    };
    println!("denoiser: {} on {}", denoiser.version(), denoiser.device());
    let divisor = std::env::var("LODESTAR_DIVISOR").ok().and_then(|text| text.parse().ok()).unwrap_or(1).max(1);
    let asked: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let context = context();
    let out = out_folder();
    let mut all = Vec::new();
    for name in SHARED_SCENES.iter().filter(|name| asked.is_empty() || asked.iter().any(|asked| asked == *name)) {
        let reference = exr::read_rgb(&references.join(format!("{name}.mean.exr"))).expect("a reference");
        let reference = smaller(&reference, divisor);
        let (errors, sheet) = measure(&context, &denoiser, name, &reference);
        for (samples, row) in SAMPLES.iter().zip(&errors) {
            let cells: Vec<_> = COLUMNS.iter().zip(row).map(|(c, e)| format!("{c} {:.5}", e.metrics.mae_ldr)).collect();
            println!("{name}, {samples} samples: {}", cells.join("; "));
        }
        if let Some(folder) = &out {
            write_jpeg(&folder.join(format!("{name}.jpg")), &sheet);
        }
        all.push((*name, errors));
    }
    if let Some(folder) = &out {
        let head = format!("# {} on {}\n", denoiser.version(), denoiser.device());
        std::fs::write(folder.join("denoising.csv"), head + &csv(&all)).expect("the table's file");
    }
    println!("{}", table(&all));
}

/// The image with one pixel for `divisor` x `divisor` of its pixels. Pixels that are left over at the edges are cut off.
fn smaller(image: &Image, divisor: u32) -> Image {
    let (width, height) = (image.width / divisor, image.height / divisor);
    let pixel = |at: u32| {
        let mut sum = [0.0; 3];
        for y in 0..divisor {
            for x in 0..divisor {
                let from = (at / width * divisor + y) * image.width + at % width * divisor + x;
                (0..3).for_each(|c| sum[c] += f64::from(image.pixels[from as usize][c]));
            }
        }
        sum.map(|sum| (sum / f64::from(divisor * divisor)) as f32)
    };
    Image { width, height, pixels: (0..width * height).map(pixel).collect() }
}

/// Errors of both methods on one scene, and a sheet of their pictures.
fn measure(context: &Arc<Context>, denoiser: &Denoiser, name: &str, reference: &Image) -> (Errors, Image) {
    let scene = load(name);
    let size = [reference.width, reference.height];
    let mut pictures: Vec<Vec<Image>> = vec![Vec::new(); SAMPLES.len()];
    for (method, sampler) in METHODS {
        let own = settings(&scene, size, sampler);
        let settings = Settings { nee: Settings::for_scene(&scene).nee, learner: sampler.default_learner(), ..own };
        let mut renderer = renderer(context, &scene, &settings, 0);
        let begin = Instant::now();
        let mut denoising = 0.0;
        for (end, row) in SAMPLES.into_iter().zip(&mut pictures) {
            while renderer.samples_done() < end {
                let samples = settings.samples_of_step(renderer.samples_done()).min(end - renderer.samples_done());
                renderer.step(samples, &|| false).expect("a step");
            }
            let picture = renderer.picture().expect("the picture");
            let denoising_began = Instant::now();
            let denoised = denoiser.denoise_picture(&picture).expect("a denoised picture").pixels;
            denoising += denoising_began.elapsed().as_secs_f64();
            row.extend([picture.image(), Image { pixels: denoised, ..picture.image() }]);
        }
        println!("{name}, {method}: {:.1} s, of which denoising {denoising:.1} s", begin.elapsed().as_secs_f64());
    }
    let compare = |image: &Image| Comparison::new(image, reference).expect("errors").0;
    let errors = std::array::from_fn(|row| std::array::from_fn(|column| compare(&pictures[row][column])));
    (errors, sheet(&pictures, reference))
}

/// Pictures of all rows beside each other, and the reference at the end of each row.
fn sheet(rows: &[Vec<Image>], reference: &Image) -> Image {
    let (width, height) = (reference.width as usize, reference.height as usize);
    let mut pixels = Vec::new();
    for row in rows {
        for y in 0..height {
            for picture in row.iter().chain([reference]) {
                pixels.extend_from_slice(&picture.pixels[y * width..(y + 1) * width]);
            }
        }
    }
    let columns = COLUMNS.len() + 1;
    Image { width: (columns * width) as u32, height: (rows.len() * height) as u32, pixels }
}

fn csv(all: &[(&str, Errors)]) -> String {
    let mut text = "scene,samples per pixel,method,MAE displayed,MAE,FLIP\n".to_owned();
    for (name, errors) in all {
        for (samples, row) in SAMPLES.iter().zip(errors) {
            for (column, errors) in COLUMNS.iter().zip(row) {
                let Comparison { metrics, flip, .. } = errors;
                // Writing to a string cannot fail.
                let _ =
                    writeln!(text, "{name},{samples},\"{column}\",{:.6},{:.6},{flip:.6}", metrics.mae_ldr, metrics.mae);
            }
        }
    }
    text
}

/// Table in Markdown: a row for each scene, and the geometric means.
fn table(all: &[(&str, Errors)]) -> String {
    let mut text = "| scene |".to_owned();
    for samples in SAMPLES {
        COLUMNS.iter().for_each(|column| text += &format!(" {column}, {samples} |"));
    }
    text += &format!("\n|---|{}\n", "---|".repeat(SAMPLES.len() * COLUMNS.len()));
    let row = |name: &str, value: &dyn Fn(usize, usize) -> f64| {
        let cells = (0..SAMPLES.len()).flat_map(|row| (0..COLUMNS.len()).map(move |column| (row, column)));
        let cells: String = cells.map(|(row, column)| format!(" {:.4} |", value(row, column))).collect();
        format!("| {name} |{cells}\n")
    };
    for (name, errors) in all {
        text += &row(name, &|row, column| errors[row][column].metrics.mae_ldr);
    }
    let mean = |row: usize, column: usize| {
        let logs: f64 = all.iter().map(|(_, errors)| errors[row][column].metrics.mae_ldr.ln()).sum();
        (logs / all.len() as f64).exp()
    };
    text + &row("geometric mean", &mean)
}
