//! The paper's twelve scenes against pictures of another renderer, for `bsdf` and `rejection-mix`, without and with
//! emitter sampling.
//!
//! Scenes and pictures are too large for this repository. `LODESTAR_SCENES` names the folder of the scenes, and
//! `LODESTAR_REFERENCES` that of the pictures, `NAME.mean.exr` and `NAME.var.exr`. Without them, the test prints that
//! nothing is tested.
//!
//! `cargo test --release --test references -- SCENE...` renders the scenes with these names. With `LODESTAR_FULL=1` and no
//! names, it renders all. In the quick tier, the test is skipped. If `LODESTAR_REFERENCE_SECONDS` is set, it renders until the mean luminance is known to
//! 0.5 %, or for so many seconds per picture. Every form writes every picture beside its reference, with the signed
//! difference, and a contact sheet to `target/references`.

mod agreement;
mod sheet;

use std::env;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use agreement::{Agreement, Estimate};
use lodestar::encode::bvh::Bvh;
use lodestar::film::Picture;
use lodestar::gpu::{Context, ContextOptions};
use lodestar::image::{Image, exr};
use lodestar::renderer::Renderer;
use lodestar::scene::{Bsdf, LoadOptions, MaterialKind, ReconstructionFilter, Scene, load};
use lodestar::settings::{SamplePattern, Sampler, Settings, Words};
use support::{mutated, tier};

/// A scene, and the samples per pixel of the short test without and with emitter sampling.
struct Case {
    name: &'static str,
    spp: [u32; 2],
}

const CASES: [Case; 12] = [
    Case { name: "bathroom", spp: [16, 16] },
    Case { name: "bathroom2", spp: [16, 16] },
    Case { name: "cornell-box", spp: [64, 16] },
    Case { name: "cornell-box-hard", spp: [64, 64] },
    Case { name: "kitchen", spp: [16, 16] },
    Case { name: "living-room", spp: [16, 16] },
    Case { name: "living-room-2", spp: [16, 32] },
    Case { name: "living-room-3", spp: [16, 16] },
    Case { name: "staircase", spp: [16, 16] },
    Case { name: "staircase2", spp: [16, 16] },
    Case { name: "veach-ajar", spp: [64, 64] },
    Case { name: "veach-ajar-2", spp: [64, 256] },
];

/// Scene on which faults must be found, and the samples per pixel for it.
const FAULTY_SCENE: &str = "cornell-box";
const FAULTY_SPP: u32 = 64;

/// Scene in whose reference light leaks. Mitsuba 3's shadow rays end 0.09 % before a light, and a wall stands closer than
/// that to the lamp of this scene (`docs/differences.md`).
const LEAKING: &str = "bathroom2";
/// Samples per pixel that show the leak: 0.1 % of the picture's luminance.
const LEAK_SPP: u32 = 256;

/// Standard error of the mean luminance that ends a long render.
const TARGET_ERROR: f64 = 0.005;

fn main() -> ExitCode {
    // A test runner asks for the list of tests. There is one test, named below.
    let arguments: Vec<String> = env::args().skip(1).collect();
    if arguments.iter().any(|argument| argument == "--list") {
        println!("references: test");
        return ExitCode::SUCCESS;
    }
    agreement::check_itself();
    let folder = |variable| env::var_os(variable).map(PathBuf::from);
    let (Some(scenes), Some(references)) = (folder("LODESTAR_SCENES"), folder("LODESTAR_REFERENCES")) else {
        println!("references: skipped, for LODESTAR_SCENES and LODESTAR_REFERENCES are not both set");
        return ExitCode::SUCCESS;
    };
    let only: Vec<&String> =
        arguments.iter().filter(|argument| CASES.iter().any(|case| case.name == **argument)).collect();
    if only.is_empty() && tier::is_skipped("the pictures that the proofs compare") {
        return ExitCode::SUCCESS;
    }
    let mut run = Run::new(scenes, references);
    let is_wanted = |case: &Case| only.is_empty() || only.iter().any(|name| *name == case.name);
    for (_, case) in CASES.iter().enumerate().filter(|&(at, case)| is_wanted(case) && tier::has_case(at)) {
        run.check(case);
    }
    run.finish()
}

struct Run {
    scenes: PathBuf,
    references: PathBuf,
    context: Arc<Context>,
    /// Folder for pictures.
    out: PathBuf,
    strips: Vec<Image>,
    failures: Vec<String>,
}

impl Run {
    fn new(scenes: PathBuf, references: PathBuf) -> Self {
        let context = Context::new(&ContextOptions { device: None, validate: false }).expect("a Vulkan device");
        let out = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("references");
        std::fs::create_dir_all(&out).expect("a folder for the pictures");
        Self { scenes, references, context, out, strips: Vec::new(), failures: Vec::new() }
    }

    fn check(&mut self, case: &Case) {
        let scene = load(&self.scenes.join(case.name).join("scene.xml"), &LoadOptions::default()).expect("a scene");
        let read = |kind| exr::read_rgb(&self.references.join(format!("{}.{kind}.exr", case.name))).expect("a picture");
        let (mean, variance) = (read("mean"), read("var"));
        let reference = Estimate::new(&mean, &variance);
        let bvh = Bvh::of_scene(&scene);
        let mut shown = None;
        for (seed, (sampler, nee)) in METHODS.into_iter().enumerate() {
            let settings = settings(&scene, &mean, sampler, nee, seed as u32 + 1);
            let begin = Instant::now();
            // Only with the leak of the reference can a picture agree with it.
            let leak = (nee && case.name == LEAKING).then_some(mutated::SHORT_OF_LIGHT);
            let renderer = mutated::renderer(&self.context, &scene, &bvh, &settings, leak);
            let (picture, spp) = render(renderer, settings.spp_per_step, &reference, case.spp[usize::from(nee)]);
            let agreement = Agreement::new(&estimate(&picture), &reference);
            let verdict = if agreement.holds() { "ok" } else { "FAILED" };
            let method = format!("{} {} nee {}", case.name, name(sampler), if nee { "on" } else { "off" });
            let kernels = leak.map_or_else(String::new, |leak| format!(" ({leak})"));
            println!("{method}{kernels}: {verdict}, {agreement}; {spp} spp in {:.1} s", begin.elapsed().as_secs_f64());
            let strip = sheet::strip(&picture.image(), &mean);
            let path = self.out.join(method.replace(' ', "-")).with_extension("png");
            sheet::write(&path, &strip).expect("a picture written");
            if !agreement.holds() {
                self.failures.push(format!("{method}: see {}", path.display()));
            }
            shown = Some(strip);
        }
        self.strips.extend(shown);
        if case.name == FAULTY_SCENE {
            self.check_faults(&scene, &bvh, &mean, &reference);
        }
        if case.name == LEAKING {
            self.check_leak(&scene, &bvh, &mean, &reference);
        }
    }

    /// Checks that planted faults are found: a density 5 % off, and albedos 3 % off.
    fn check_faults(&mut self, scene: &Scene, bvh: &Bvh, mean: &Image, reference: &Estimate) {
        let darker = with_albedo_scaled(scene, 0.97);
        let faults = [("density", scene, Some(mutated::DENSITIES)), ("albedo", &darker, None)];
        for (seed, (fault, scene, mutation)) in (11..).zip(faults) {
            let settings = settings(scene, mean, Sampler::RejectionMix, true, seed);
            let renderer = mutated::renderer(&self.context, scene, bvh, &settings, mutation);
            let (picture, _) = render(renderer, settings.spp_per_step, reference, FAULTY_SPP);
            let agreement = Agreement::new(&estimate(&picture), reference);
            println!("{FAULTY_SCENE} with a wrong {fault}: {agreement}");
            if agreement.holds() {
                self.failures.push(format!("{FAULTY_SCENE}: a wrong {fault} was not noticed"));
            }
        }
    }

    /// Checks that the shipped shadow rays do not leak: a picture with emitter sampling agrees with one whose paths find
    /// the lamp by chance. Its luminance is more than three standard errors below the reference's.
    fn check_leak(&mut self, scene: &Scene, bvh: &Bvh, mean: &Image, reference: &Estimate) {
        let shipped = |seed, nee| {
            let settings = settings(scene, mean, Sampler::Product, nee, seed);
            let renderer = Renderer::new(&self.context, scene, bvh, &settings).expect("a renderer");
            estimate(&render(renderer, settings.spp_per_step, reference, LEAK_SPP).0)
        };
        let (connected, found) = (shipped(21, true), shipped(22, false));
        let (own, other) = (Agreement::new(&connected, &found), Agreement::new(&connected, reference));
        println!("{LEAKING}, emitters sampled or found by chance: {own}");
        println!("{LEAKING}, emitters sampled without the leak, beside the reference: {other}");
        if !own.holds() {
            self.failures.push(format!("{LEAKING}: emitter sampling changes the picture"));
        }
        if other.ratio - 1.0 > -3.0 * other.error {
            self.failures.push(format!("{LEAKING}: the leak of the reference was not noticed"));
        }
    }

    fn finish(self) -> ExitCode {
        let path = self.out.join("contact-sheet.png");
        sheet::write(&path, &sheet::below(&self.strips, 2)).expect("a contact sheet written");
        println!("contact sheet: {} (ours, reference, difference)", path.display());
        for failure in &self.failures {
            println!("failed: {failure}");
        }
        if self.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}

/// Samplers, each without and with emitter sampling. The contact sheet shows the last one.
const METHODS: [(Sampler, bool); 4] =
    [(Sampler::Bsdf, false), (Sampler::Bsdf, true), (Sampler::RejectionMix, false), (Sampler::RejectionMix, true)];

fn name(sampler: Sampler) -> String {
    sampler.word().to_owned()
}

/// Settings with which the references were rendered.
fn settings(scene: &Scene, reference: &Image, sampler: Sampler, nee: bool, seed: u32) -> Settings {
    Settings {
        width: reference.width,
        height: reference.height,
        filter: ReconstructionFilter::Box,
        max_depth: 16,
        rr_depth: 8,
        sampler,
        nee,
        seed,
        pattern: SamplePattern::Independent,
        ..Settings::for_scene(scene)
    }
}

/// Scene with every diffuse albedo multiplied.
fn with_albedo_scaled(scene: &Scene, factor: f32) -> Scene {
    let mut scene = scene.clone();
    for material in &mut scene.materials {
        if let MaterialKind::Surface(surface) = &mut material.kind
            && let Bsdf::Diffuse { reflectance } = &mut surface.bsdf
        {
            reflectance.value *= factor;
        }
    }
    scene
}

fn estimate(picture: &Picture) -> Estimate {
    Estimate::new(&picture.image(), &picture.variance_image())
}

/// Renders `spp` samples per pixel or, in the long test, as many as needed.
fn render(mut renderer: Renderer, spp_per_step: u32, reference: &Estimate, spp: u32) -> (Picture, u32) {
    let step = |renderer: &mut Renderer, until: u32| {
        while renderer.samples_done() < until {
            renderer.step(spp_per_step, &|| false).expect("a step");
        }
    };
    step(&mut renderer, spp);
    if let Some(seconds) = env::var("LODESTAR_REFERENCE_SECONDS").ok().and_then(|text| text.parse::<f64>().ok()) {
        let begin = Instant::now();
        // The number of samples only doubles, so that the moment of stopping depends on the picture as little as
        // possible.
        while begin.elapsed().as_secs_f64() < 0.5 * seconds
            && Agreement::new(&estimate(&renderer.picture().expect("a picture")), reference).error > TARGET_ERROR
        {
            let until = 2 * renderer.samples_done();
            step(&mut renderer, until);
        }
    }
    (renderer.picture().expect("a picture"), renderer.samples_done())
}
