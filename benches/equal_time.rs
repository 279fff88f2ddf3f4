//! Equal-time comparison: errors of this renderer's methods and of Mitsuba 3 after the same time on the paper's scenes.
//!
//! `cargo bench --bench equal_time [-- SCENE...]` needs the shared scenes and references (`LODESTAR_SCENES`,
//! `LODESTAR_REFERENCES`). Each method renders each scene for `LODESTAR_SECONDS` (40). The methods take turns, so that
//! a slow minute affects all of them. After each turn the errors are measured, for the curve over time.
//! `LODESTAR_METHODS='product;quadtree'` selects methods. `LODESTAR_OUT=DIR` also writes files: `errors.csv`, the plot
//! `error-over-time.svg`, the plot `error-ratios.svg`, and the pictures of all methods at the end, `SCENE-METHOD.jpg`.
//!
//! The error is that of the paper, the mean absolute error of the displayed image. If the noise of the reference
//! exceeds a quarter of the smaller error of two methods, their ratio is that of the mean squared errors, minus the
//! variance of the reference.
//!
//! A step or a pass that has begun in time is finished, so a method uses more seconds than asked for. Ratios are of errors after exactly
//! the time asked for, see [`at_equal_time`].

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use lodestar::gpu::Context;
use lodestar::image::{Image, exr, metrics, tone};
use lodestar::renderer::Renderer;
use lodestar::reproduce::plot::{Axis, Plot, Series};
use lodestar::settings::{Learner, Sampler, Settings};
use support::bench::pictures::{file_name, out_folder, write_jpeg};
use support::bench::{SHARED_SCENES, context, load, run_for, scene_path, settings};

/// Ends of the turns, as shares of the time.
const TURN_ENDS: [f64; 6] = [0.05, 0.1, 0.25, 0.5, 0.75, 1.0];
const SECONDS: f64 = 40.0;

const MITSUBA: &str = "Mitsuba path";

/// Method: its name, and this renderer's sampler and emitter sampling; `None` for Mitsuba.
const METHODS: [(&str, Option<(Sampler, bool)>); 7] = [
    ("bsdf", Some((Sampler::Bsdf, false))),
    ("rejection-mix", Some((Sampler::RejectionMix, false))),
    ("product", Some((Sampler::Product, false))),
    ("product, emitters sampled", Some((Sampler::Product, true))),
    (MITSUBA, None),
    ("quadtree", Some((Sampler::Quadtree, false))),
    ("bsdf, emitters sampled", Some((Sampler::Bsdf, true))),
];
/// Pairs of methods whose errors are compared, as indices into `METHODS`.
const RATIOS: [(usize, usize); 6] = [(2, 0), (2, 1), (2, 5), (3, 2), (3, 4), (3, 6)];

/// Picture of another renderer, and the variance of its pixels.
struct Reference {
    mean: Image,
    variance: Image,
}

#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    mae: f64,
    mse: f64,
    spp: u32,
    /// Seconds that were used. A step or pass that has begun in time is finished.
    seconds: f64,
}

fn main() {
    let Some(references) = std::env::var_os("LODESTAR_REFERENCES").map(PathBuf::from) else {
        println!("skipped: LODESTAR_REFERENCES names no folder with reference images");
        return;
    };
    let seconds = std::env::var("LODESTAR_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(SECONDS);
    let asked: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    for asked in std::env::var("LODESTAR_METHODS").unwrap_or_default().split(';').filter(|asked| !asked.is_empty()) {
        let names = METHODS.map(|(name, _)| name);
        assert!(names.contains(&asked), "LODESTAR_METHODS names `{asked}`; there are {names:?}");
    }
    let context = context();
    // The indices are the turn, the pair of methods, and the scene.
    let mut ratios = vec![vec![Vec::new(); RATIOS.len()]; TURN_ENDS.len()];
    let out = out_folder();
    let mut curves = Vec::new();
    for name in SHARED_SCENES.iter().filter(|name| asked.is_empty() || asked.iter().any(|asked| asked == *name)) {
        let read = |layer: &str| exr::read_rgb(&references.join(format!("{name}.{layer}.exr"))).expect("a reference");
        let reference = Reference { mean: read("mean"), variance: read("var") };
        let curve = measure(&context, name, &reference, seconds, out.as_deref());
        for ((errors, end), ratios) in curve.iter().zip(TURN_ENDS).zip(&mut ratios) {
            let at = format!("{name} at {} s", end * seconds);
            let at_time = at_equal_time(&curve, end * seconds);
            for ((method, _), e) in METHODS.iter().zip(errors).filter(|((method, _), _)| is_asked(method)) {
                println!("{at}, {method}: {} spp in {:.2} s, MAE {:.5}, MSE {:.3e}", e.spp, e.seconds, e.mae, e.mse);
            }
            let asked = |(a, b): (usize, usize)| is_asked(METHODS[a].0) && is_asked(METHODS[b].0);
            for (ratios, &(a, b)) in ratios.iter_mut().zip(&RATIOS).filter(|(_, pair)| asked(**pair)) {
                let (ratio, by) = ratio(&reference, at_time[a], at_time[b]);
                println!("{at}: {} / {} = {ratio:.3} ({by})", METHODS[a].0, METHODS[b].0);
                ratios.push((ratio, at_time[a].mae / at_time[b].mae));
            }
        }
        curves.push((*name, curve));
    }
    if let Some(folder) = out {
        let write = |name: &str, text: String| std::fs::write(folder.join(name), text).expect("a file");
        write("errors.csv", table(&curves, seconds, &context));
        write("error-over-time.svg", plot(&curves).svg().expect("a plot"));
        write("error-ratios.svg", plot_of_ratios(&curves, seconds).svg().expect("a plot"));
    }
    for (ratios, end) in ratios.iter().zip(TURN_ENDS) {
        let known = ratios.iter().zip(&RATIOS).filter(|(ratios, _)| !ratios.is_empty());
        known.for_each(|(ratios, &pair)| summarize(ratios, pair, end * seconds));
    }
}

/// Errors of all scenes, turns and methods as CSV, after a comment that names the device.
fn table(curves: &[(&str, Vec<Vec<Errors>>)], seconds: f64, context: &Context) -> String {
    let device = context.device();
    let mut text = format!("# device: {} ({})\n", device.name, device.driver_info);
    text += "scene,method,seconds asked for,seconds,samples per pixel,MAE,MSE\n";
    for (scene, curve) in curves {
        for (errors, end) in curve.iter().zip(TURN_ENDS) {
            for ((method, _), e) in METHODS.iter().zip(errors).filter(|(_, e)| e.mae.is_finite()) {
                let asked = end * seconds;
                // Writing to a string cannot fail.
                let _ = writeln!(
                    text,
                    "{scene},\"{method}\",{asked},{:.3},{},{:.6},{:.6e}",
                    e.seconds, e.spp, e.mae, e.mse
                );
            }
        }
    }
    text
}

/// Plot of the mean absolute error over time: geometric means over the scenes, for each method that all scenes have.
fn plot(curves: &[(&str, Vec<Vec<Errors>>)]) -> Plot {
    let mean = |values: &mut dyn Iterator<Item = f64>| (values.map(f64::ln).sum::<f64>() / curves.len() as f64).exp();
    let point = |method: usize, turn: usize| {
        let errors = || curves.iter().map(|(_, curve)| curve[turn][method]);
        [mean(&mut errors().map(|e| e.seconds)), mean(&mut errors().map(|e| e.mae))]
    };
    let series = METHODS.iter().enumerate().map(|(method, (name, _))| Series {
        name: (*name).to_owned(),
        points: (0..TURN_ENDS.len()).map(|turn| point(method, turn)).collect(),
    });
    Plot {
        title: format!("Error over time, geometric mean of {} scenes", curves.len()),
        x: Axis::logarithmic("seconds"),
        y: Axis::logarithmic("mean absolute error of the displayed picture"),
        series: series.filter(|series| series.points.iter().flatten().all(|value| value.is_finite())).collect(),
    }
}

/// Plot of the error of `product` over that of other methods at equal time, both with emitter sampling or both without: the geometric
/// mean of the scenes, by mean absolute error.
fn plot_of_ratios(curves: &[(&str, Vec<Vec<Errors>>)], seconds: f64) -> Plot {
    let ratio = |turn: usize, (a, b): (usize, usize)| {
        let errors = curves.iter().map(|(_, curve)| at_equal_time(curve, TURN_ENDS[turn] * seconds));
        let logs = errors.map(|errors| (errors[a].mae / errors[b].mae).ln());
        (logs.sum::<f64>() / curves.len() as f64).exp()
    };
    let emitters = |method: usize| METHODS[method].1.is_none_or(|(_, sampled)| sampled);
    let pairs = RATIOS.into_iter().filter(|&(a, b)| emitters(a) == emitters(b));
    let series = pairs.map(|pair| Series {
        name: format!("{}{}", METHODS[pair.1].0, if emitters(pair.1) { "" } else { ", emitters not sampled" }),
        points: (0..TURN_ENDS.len()).map(|turn| [seconds * TURN_ENDS[turn], ratio(turn, pair)]).collect(),
    });
    Plot {
        title: format!("Error of product over that of another method, mean of {} scenes", curves.len()),
        x: Axis::linear("seconds"),
        y: Axis::linear("error ratio (below 1, product is better)"),
        series: series.filter(|series| series.points.iter().flatten().all(|value| value.is_finite())).collect(),
    }
}

/// Prints the mean ratios over all scenes, by the measure that suits each scene and by the mean absolute error alone.
fn summarize(ratios: &[(f64, f64)], (a, b): (usize, usize), seconds: f64) {
    let mean_and_worst = |ratios: &mut dyn Iterator<Item = f64>| {
        let known: Vec<f64> = ratios.filter(|ratio| ratio.is_finite()).collect();
        let mean = (known.iter().map(|ratio| ratio.ln()).sum::<f64>() / known.len() as f64).exp();
        (mean, known.iter().copied().fold(0.0, f64::max), known.len())
    };
    let (mean, worst, count) = mean_and_worst(&mut ratios.iter().map(|ratio| ratio.0));
    let (mae, worst_mae, _) = mean_and_worst(&mut ratios.iter().map(|ratio| ratio.1));
    println!(
        "{} / {} at {seconds} s: geometric mean {mean:.3} of {count}, largest {worst:.3}; by MAE {mae:.3}, largest {worst_mae:.3}",
        METHODS[a].0, METHODS[b].0
    );
}

/// Errors of all methods on one scene after each turn; NaN for methods that are not available. The pictures after the last
/// turn are written to the folder `out`.
fn measure(
    context: &Arc<Context>,
    name: &str,
    reference: &Reference,
    seconds: f64,
    out: Option<&Path>,
) -> Vec<Vec<Errors>> {
    let scene = load(name);
    let size = [reference.mean.width, reference.mean.height];
    let renderer = |&(name, method): &(&str, Option<(Sampler, bool)>)| {
        let (sampler, nee) = method.filter(|_| is_asked(name))?;
        let mut settings = Settings { nee, ..settings(&scene, size, sampler) };
        if sampler == Sampler::Quadtree {
            settings.learner = Learner::MonteCarlo;
        }
        Some((support::bench::renderer(context, &scene, &settings, 0), settings))
    };
    let mut renderers: Vec<Option<(Renderer, Settings)>> = METHODS.iter().map(renderer).collect();
    let (mut parts, mut elapsed) = (Vec::new(), [0.0; METHODS.len()]);
    let mut turn = |(seed, end): (u32, f64)| {
        for ((renderer, elapsed), (method, _)) in renderers.iter_mut().zip(&mut elapsed).zip(METHODS) {
            let seconds = (end * seconds - *elapsed).max(0.0);
            *elapsed += match renderer {
                Some((renderer, settings)) => run_for(renderer, seconds, settings).1,
                None if method != MITSUBA || !is_asked(method) => f64::NAN,
                None => mitsuba(&scene_path(name), size, seconds, seed).map_or(f64::NAN, |(part, seconds)| {
                    parts.push(part);
                    seconds
                }),
            };
        }
        let picture = |renderer: &Option<(Renderer, Settings)>| {
            let (renderer, _) = renderer.as_ref()?;
            Some((renderer.picture().expect("the picture").image(), renderer.samples_done()))
        };
        let of_mitsuba = |method| if method == MITSUBA { average(&parts) } else { None };
        let pictures = renderers.iter().zip(METHODS);
        let pictures = pictures.map(|(renderer, (method, _))| picture(renderer).or_else(|| of_mitsuba(method)));
        let pictures: Vec<_> = pictures.collect();
        if let Some(folder) = out.filter(|_| end == 1.0) {
            write_pictures(folder, name, &pictures);
        }
        let measured = pictures.into_iter().map(|picture| errors(picture, reference)).zip(elapsed);
        measured.map(|(errors, seconds)| Errors { seconds, ..errors }).collect()
    };
    (0..).step_by(1_000_000).zip(TURN_ENDS).map(&mut turn).collect()
}

fn write_pictures(folder: &Path, scene: &str, pictures: &[Option<(Image, u32)>]) {
    for ((method, _), picture) in METHODS.iter().zip(pictures) {
        let path = folder.join(format!("{scene}-{}.jpg", file_name(method)));
        if let Some((image, _)) = picture {
            write_jpeg(&path, image);
        }
    }
}

/// Whether a method is selected.
fn is_asked(method: &str) -> bool {
    std::env::var("LODESTAR_METHODS").map_or(true, |asked| asked.split(';').any(|asked| asked == method))
}

fn errors(picture: Option<(Image, u32)>, reference: &Reference) -> Errors {
    let Some((image, spp)) = picture else { return Errors { mae: f64::NAN, mse: f64::NAN, ..Errors::default() } };
    let found = metrics::compare(&image, &reference.mean).expect("the same size");
    let variances = reference.variance.pixels.iter().flatten().map(|&v| f64::from(v));
    let noise = variances.sum::<f64>() / (3 * reference.variance.pixels.len()) as f64;
    Errors { mae: found.mae_ldr, mse: (found.mse - noise).max(0.0), spp, seconds: 0.0 }
}

/// Errors of all methods on a scene after exactly `seconds`. The mean absolute error lies on the line through the two nearest turns, in
/// logarithms of time and error. The mean squared error, which may be 0, is the nearest later turn's, and falls with the time.
fn at_equal_time(curve: &[Vec<Errors>], seconds: f64) -> Vec<Errors> {
    let of_method = |method: usize| {
        let mut turns: Vec<Errors> = curve.iter().map(|errors| errors[method]).collect();
        turns.dedup_by_key(|errors| errors.seconds.to_bits());
        let later = turns.iter().position(|errors| errors.seconds >= seconds).unwrap_or(turns.len() - 1);
        let nearest = turns[later];
        let mae = match turns[later.max(1) - 1..].first_chunk() {
            Some([a, b]) => {
                let slope = (b.mae / a.mae).ln() / (b.seconds / a.seconds).ln();
                a.mae * (seconds / a.seconds).powf(slope)
            }
            None => nearest.mae,
        };
        Errors { mae, mse: nearest.mse * nearest.seconds / seconds, seconds, ..nearest }
    };
    (0..METHODS.len()).map(of_method).collect()
}

/// Ratio of the error of `a` to that of `b`, and the measure that was used.
fn ratio(reference: &Reference, a: Errors, b: Errors) -> (f64, &'static str) {
    if reference_noise(reference) <= 0.25 * a.mae.min(b.mae) {
        return (a.mae / b.mae, "MAE");
    }
    (a.mse / b.mse, "MSE")
}

/// Mean absolute error of the displayed reference, estimated from the variance of its pixels.
fn reference_noise(reference: &Reference) -> f64 {
    let pixels = reference.mean.pixels.iter().zip(&reference.variance.pixels);
    let difference = |(mean, variance): (&[f32; 3], &[f32; 3])| {
        let shown = tone::paper(mean.map(f64::from));
        let off = tone::paper(std::array::from_fn(|c| f64::from(mean[c]) + f64::from(variance[c]).sqrt()));
        (0..3).map(|c| (off[c] - shown[c]).abs()).sum::<f64>()
    };
    // This is the mean of |x| for a standard normal x.
    let mean_absolute = (2.0 / std::f64::consts::PI).sqrt();
    mean_absolute * pixels.map(difference).sum::<f64>() / (3 * reference.mean.pixels.len()) as f64
}

/// Picture by Mitsuba with its samples per pixel, and the time in seconds; `None` if Mitsuba is not installed.
fn mitsuba(scene: &Path, [width, height]: [u32; 2], seconds: f64, seed: u32) -> Option<((Image, u32), f64)> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/mitsuba_render.py");
    let out = std::env::temp_dir().join(format!("lodestar-equal-time-{}.exr", std::process::id()));
    let numbers = [width.to_string(), height.to_string(), seconds.to_string(), seed.to_string()];
    let output = Command::new("python3").arg("-B").arg(script).arg(scene).args(numbers).arg(&out).output().ok()?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        println!("Mitsuba is left out: {}", message.lines().last().unwrap_or("it gives no reason"));
        return None;
    }
    let text = String::from_utf8(output.stdout).ok()?;
    let (spp, seconds) = text.trim().split_once(' ')?;
    let image = exr::read_rgb(&out).ok()?;
    let _ = std::fs::remove_file(&out);
    Some(((image, spp.parse().ok()?), seconds.parse().ok()?))
}

/// Mean of pictures, weighted by their samples.
fn average(parts: &[(Image, u32)]) -> Option<(Image, u32)> {
    let total: u32 = parts.iter().map(|part| part.1).sum();
    let mut mean = parts.first()?.0.clone();
    for (i, pixel) in mean.pixels.iter_mut().enumerate() {
        *pixel = std::array::from_fn(|c| {
            let weighted = |(image, spp): &(Image, u32)| f64::from(image.pixels[i][c]) * f64::from(*spp);
            (parts.iter().map(weighted).sum::<f64>() / f64::from(total)) as f32
        });
    }
    Some((mean, total))
}
