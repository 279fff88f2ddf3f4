//! Small scenes, each with one feature or a pair, against pictures of Mitsuba 3.9.1 or closed forms.
//!
//! The table of scenes is in `table/`. `references.tsv` has the means of blocks of Mitsuba's pictures, which `make.py` renders.
//! A scene whose right picture follows from another scene's, or from arithmetic, has no row there.
//!
//! The quick tier renders every scene once, with few samples and with kernels that many scenes share. Samplers, with and
//! without emitter sampling, take turns. The full tier (`tests/long.sh features`) renders every scene in all four ways, with
//! 4096 samples per pixel and with its own kernels.
//!
//! Each class has a twin: one of its scenes with a fault. The albedo, the radiance, the size or the field of view is 2 % off, or
//! paths have a vertex too many, which adds 2 % to the mean. The full tier must reject the twin with emitter sampling. In the
//! quick tier, and without emitter sampling, the fault is larger: see `table::twin`.
//!
//! A picture agrees unless a deviation of its mean, of a block, or of all blocks together has a probability below [`ALPHA`]
//! over all pictures of the run (Sidak 1967). So a right renderer fails once in 10,000 runs.
//!
//! Probabilities of this kind hold for errors that are normally distributed. With few samples of a rare bright path, such as a caustic's,
//! errors are not: a picture that has missed the path takes itself for exact. So the verdict on a picture that deviates is that on another picture, with
//! [`MORE`] times the samples and another seed. A fault stands out more clearly there. Twins are judged alike.
//!
//! `LODESTAR_FEATURES=WORD` renders only the scenes whose names contain the word, `LODESTAR_PART=K/N` every N-th scene from the
//! K-th on. `LODESTAR_FEATURES_TABLE=FILE` writes the
//! table of all deviations. `LODESTAR_FEATURES_SAMPLES=N` sets the samples per pixel. `LODESTAR_FEATURES_SCENES=DIR` writes the
//! scenes as files.

mod assets;
mod kernels;
mod references;
mod table;
mod verdict;

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::{env, fs};

use lodestar::Error;
use lodestar::encode::bvh::Bvh;
use lodestar::encode::surfaces::Surfaces;
use lodestar::generated::kernels::{Registry, Variant};
use lodestar::gpu::{Context, ContextOptions};
use lodestar::renderer::{Renderer, variant_for};
use lodestar::scene::{LoadOptions, Scene, load};
use lodestar::settings::{SamplePattern, Sampler, Settings};
use references::References;
use support::significance::sidak;
use support::tier;
use table::{Case, Class};
use verdict::{Blocks, Verdict};

/// Probability that a run fails with a right renderer.
const ALPHA: f64 = 1.0e-4;

/// Probability of a picture below which the difference of a listed scene still shows. A scene whose difference is gone stays
/// listed in one of 1,000 runs. The probability is that of one picture, because other pictures do not make a difference smaller.
const SHOWN: f64 = 1.0e-3;

/// Samples per pixel of the quick tier and of the full tier.
const FEW: u32 = 64;
const MANY: u32 = 4096;

/// Samples of the picture that decides on a scene whose first picture deviates, over those of the first one.
const MORE: u32 = 16;

/// Seeds of first pictures are below this number.
const SEEDS: u32 = 1 << 16;

/// Least number of scenes for which the quick tier builds the kernels of another method.
const LEAST_SHARED: usize = 8;

/// Number of groups that are rendered at a time.
const WORKERS: usize = 2;

/// Way to render a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Method {
    name: &'static str,
    sampler: Sampler,
    nee: bool,
}

/// All methods. Where a scene is rendered in one way only, it is the first.
const METHODS: [Method; 4] = [
    Method { name: "bsdf, emitters on", sampler: Sampler::Bsdf, nee: true },
    Method { name: "product, emitters on", sampler: Sampler::Product, nee: true },
    Method { name: "bsdf, emitters off", sampler: Sampler::Bsdf, nee: false },
    Method { name: "product, emitters off", sampler: Sampler::Product, nee: false },
];

/// Picture to render.
struct Job<'a> {
    case: &'a Case,
    method: Method,
    scene: Scene,
    settings: Settings,
    bvh: Bvh,
    variant: Variant,
}

impl<'a> Job<'a> {
    /// Reads the scene of a case. In a twin, `fault` names a `<default>` and a wrong value for it.
    fn new(folder: &Path, case: &'a Case, method: Method, fault: Option<(&'static str, &'static str)>) -> Self {
        let defines = fault.iter().map(|&(name, value)| (name.into(), value.into())).collect();
        let path = folder.join(&case.name).with_extension("xml");
        let scene = load(&path, &LoadOptions { defines, ..LoadOptions::default() })
            .unwrap_or_else(|error| panic!("{}: {error}", case.name));
        // The kernels contain the number of cells, so scenes share kernels only where each has one cell.
        let of_scene = Settings::for_scene(&scene);
        let settings = Settings {
            grid: Some(if tier::is_full() { 8 } else { 1 }),
            sampler: method.sampler,
            nee: method.nee,
            seed: case.number,
            pattern: SamplePattern::Independent,
            ..of_scene
        };
        let bvh = Bvh::of_scene(&scene);
        let variant = variant_for(&settings, &scene, &bvh);
        Self { case, method, scene, settings, bvh, variant }
    }

    /// Renders the picture. Where a driver ends the loops of long paths, the render begins again with fewer samples per
    /// dispatch, as the program's does.
    fn render(&self, context: &Arc<Context>, registry: &Registry, spp: u32, seed: u32) -> Blocks {
        let surfaces = Surfaces::new(&self.scene);
        let settings = Settings { seed, ..self.settings.clone() };
        let mut renderer = Renderer::with_surfaces(context, &self.scene, surfaces, &self.bvh, &settings, registry)
            .unwrap_or_else(|error| panic!("{}: {error}", self.case.name));
        let mut at_once = self.settings.samples_per_dispatch;
        while renderer.samples_done() < spp {
            let samples = renderer.samples_of_next_step().min(spp - renderer.samples_done());
            let again = match renderer.step(samples, &|| false) {
                Ok(report) => {
                    assert_eq!((report.counts.nonfinite, report.counts.overruns), (0, 0), "{}", self.case.name);
                    continue;
                }
                Err(Error::LoopCut(_)) if at_once > 1 => {
                    at_once /= 2;
                    println!("{}: begins again with {at_once} samples per dispatch", self.case.name);
                    renderer.begin_again(at_once, None)
                }
                Err(error) => Err(error),
            };
            again.unwrap_or_else(|error| panic!("{}: {error}", self.case.name));
        }
        Blocks::of(&renderer.picture().expect("a picture"))
    }

    /// Whether all light can be found: lights that rays never hit, or hardly ever, need emitter sampling.
    fn can_find_light(&self) -> bool {
        self.method.nee || self.scene.delta_emitters.is_empty() && !self.case.is_hard_to_hit
    }
}

/// Jobs that may share kernels.
fn grouped(jobs: impl IntoIterator<Item = Job<'static>>) -> Vec<Vec<Job<'static>>> {
    let mut groups: Vec<Vec<Job>> = Vec::new();
    for job in jobs {
        let rest = kernels::rest(&job.variant);
        match groups.iter_mut().find(|group| kernels::rest(&group[0].variant) == rest) {
            Some(group) => group.push(job),
            None => groups.push(vec![job]),
        }
    }
    groups
}

/// All jobs of this run, in groups.
fn jobs(folder: &Path, cases: &'static [Case]) -> Vec<Vec<Job<'static>>> {
    let job = |case, method: usize| Job::new(folder, case, METHODS[method], None);
    if tier::is_full() {
        let all = cases.iter().flat_map(|case| (0..METHODS.len()).map(move |method| job(case, method)));
        return grouped(all.filter(Job::can_find_light));
    }
    // Large groups are divided among the methods.
    let divide = |group: Vec<Job<'static>>| {
        let methods = (group.len() / LEAST_SHARED).clamp(1, METHODS.len());
        let method = |(at, first): (usize, Job<'static>)| {
            let is_special = first.case.known.is_some() || table::twin(first.case.class).scene == first.case.name;
            let found = if is_special || at % methods == 0 { first } else { job(first.case, at % methods) };
            if found.can_find_light() { found } else { job(found.case, 0) }
        };
        group.into_iter().enumerate().map(method).collect::<Vec<_>>()
    };
    grouped(grouped(cases.iter().map(|case| job(case, 0))).into_iter().flat_map(divide))
}

/// Line of the table.
struct Row {
    case: &'static Case,
    verdict: Verdict,
}

/// Everything that a run needs.
struct Run {
    folder: tempfile::TempDir,
    references: References,
    spp: u32,
    /// Number of pictures, over which the probabilities are corrected.
    count: usize,
    rows: Mutex<Vec<Row>>,
    failures: Mutex<Vec<String>>,
}

impl Run {
    /// Whether a picture this improbable is wrong.
    fn rejects(&self, verdict: &Verdict) -> bool {
        sidak(verdict.p, self.count) < ALPHA
    }

    fn fail(&self, message: String) {
        self.failures.lock().expect("no panic").push(message);
    }

    /// Renders groups until none is left. One driver compiles on one core only, so that two workers are faster.
    fn work(&self, groups: &Mutex<Vec<Vec<Job<'static>>>>) {
        let next = || groups.lock().expect("no panic").pop();
        while let Some(group) = next() {
            let context = Context::new(&ContextOptions { device: None, validate: false }).expect("a Vulkan device");
            self.group(&context, group);
        }
    }

    /// Renders a group of jobs, and the twins among them.
    fn group(&self, context: &Arc<Context>, jobs: Vec<Job<'static>>) {
        let joined = jobs.iter().skip(1).fold(jobs[0].variant, |joined, job| kernels::joined(&joined, &job.variant));
        let registry = if tier::is_full() { Registry::built_in() } else { kernels::fixed(&joined) };
        for job in jobs {
            let verdict = self.verdict(context, &registry, &job);
            self.judge(&job, &verdict);
            self.twin(context, &job, &registry);
            self.rows.lock().expect("no panic").push(Row { case: job.case, verdict });
        }
    }

    /// Verdict on a job's picture; where that deviates, on one with more samples. What is known of a scene holds for its first picture.
    fn verdict(&self, context: &Arc<Context>, registry: &Registry, job: &Job) -> Verdict {
        let reference = self.references.of(job.case);
        let seed = job.settings.seed;
        let first = Verdict::new(&job.render(context, registry, self.spp, seed), &reference);
        if !self.rejects(&first) || job.case.known.is_some() {
            return first;
        }
        println!("{} ({}): {first}; again with more samples", job.case.name, job.method.name);
        Verdict::new(&job.render(context, registry, MORE * self.spp, seed + SEEDS), &reference)
    }

    fn judge(&self, job: &Job, verdict: &Verdict) {
        let figures = format!("{} ({}): {verdict}", job.case.name, job.method.name);
        match (self.rejects(verdict), job.case.known) {
            (true, None) => self.fail(figures.clone()),
            (true, Some(known)) if !known.explains(verdict) => {
                self.fail(format!("{figures}: differs by more than is known: {}", known.reason));
            }
            (false, Some(known)) if job.method.nee && known.shows() && verdict.p > SHOWN => {
                self.fail(format!("{figures}: agrees, but is listed: {}", known.reason));
            }
            _ => {}
        }
        let reason = job.case.known.map_or_else(String::new, |known| format!(" (known: {})", known.reason));
        println!("{figures}{reason}");
    }

    /// Renders the twin of the job's class, if the job's scene has it. It must be rejected. With few samples, or where light
    /// is found by chance, 2 % are less than the noise, and the fault is larger.
    fn twin(&self, context: &Arc<Context>, job: &Job<'static>, registry: &Registry) {
        let twin = table::twin(job.case.class);
        if job.case.name != twin.scene {
            return;
        }
        let wrong = if tier::is_full() && job.method.nee { twin.wrong } else { twin.far };
        let faulty = Job::new(self.folder.path(), job.case, job.method, Some((twin.parameter, wrong)));
        // Shared kernels have the depth of the right scene.
        let is_shared = tier::is_full() || kernels::rest(&faulty.variant) == kernels::rest(&job.variant);
        let own = (!is_shared).then(|| kernels::fixed(&faulty.variant));
        let verdict = self.verdict(context, own.as_ref().unwrap_or(registry), &faulty);
        println!("{} with `{}` {wrong}: {verdict}", job.case.name, twin.parameter);
        if !self.rejects(&verdict) {
            self.fail(format!("the twin of the class {} is not found: {verdict}", job.case.class));
        }
    }

    /// Table in Markdown: a line per scene, with the figures of the first method and the largest deviations of all.
    fn table(&self) -> String {
        let mut text = "| scene | ratio | z of the mean | worst block | its z |\n|---|---|---|---|---|\n".to_owned();
        let mut class = None;
        let mut names = BTreeSet::new();
        let rows = self.rows.lock().expect("no panic");
        for row in rows.iter() {
            names.insert((row.case.class, &row.case.name));
        }
        for (own, name) in names {
            if class.replace(own) != Some(own) {
                let _ = writeln!(text, "| **{own}** | | | | |");
            }
            let of = || rows.iter().filter(|row| row.case.name == *name);
            let Some(mean) = of().max_by(|a, b| a.verdict.z.abs().total_cmp(&b.verdict.z.abs())) else { continue };
            let Some(block) = of().max_by(|a, b| a.verdict.worst.0.abs().total_cmp(&b.verdict.worst.0.abs())) else {
                continue;
            };
            let (ratio, z) = (mean.verdict.ratio, mean.verdict.z);
            let (worst_z, worst) = block.verdict.worst;
            let mark = if mean.case.known.is_some() { " (known)" } else { "" };
            let _ = writeln!(text, "| {name}{mark} | {ratio:.4} | {z:+.1} | {worst:.3} | {worst_z:+.1} |");
        }
        text
    }
}

/// All scenes of this run, for ever: jobs borrow them.
fn cases() -> &'static [Case] {
    let word = env::var("LODESTAR_FEATURES").unwrap_or_default();
    let is_wanted = |(at, case): &(usize, Case)| case.name.contains(&word) && tier::has_case(*at);
    let cases: Vec<Case> = table::all().into_iter().enumerate().filter(is_wanted).map(|(_, case)| case).collect();
    Box::leak(cases.into_boxed_slice())
}

/// Samples per pixel of this run.
fn samples() -> u32 {
    let of_tier = if tier::is_full() { MANY } else { FEW };
    env::var("LODESTAR_FEATURES_SAMPLES").map_or(of_tier, |number| number.parse().expect("a number of samples"))
}

/// Writes the scenes and what they name.
fn write_to(folder: &Path, cases: &[Case]) {
    assets::write(folder);
    for case in cases {
        fs::write(folder.join(&case.name).with_extension("xml"), &case.xml).expect("a scene written");
    }
}

#[test]
fn every_scene_agrees_and_faults_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases = cases();
    write_to(folder.path(), cases);
    let groups = jobs(folder.path(), cases);
    let run = Run {
        folder,
        references: References::read(),
        spp: samples(),
        count: groups.iter().map(Vec::len).sum(),
        rows: Mutex::default(),
        failures: Mutex::default(),
    };
    println!("{} pictures in {} groups, {} samples per pixel", run.count, groups.len(), run.spp);
    let groups = Mutex::new(groups);
    std::thread::scope(|scope| {
        for _ in 0..WORKERS {
            scope.spawn(|| run.work(&groups));
        }
    });
    if let Some(path) = env::var_os("LODESTAR_FEATURES_TABLE") {
        fs::write(path, run.table()).expect("a table written");
    }
    let failures = run.failures.into_inner().expect("no panic");
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// The parts of the long tier have every scene once.
#[test]
fn every_scene_is_in_one_part() {
    for index in 0..table::all().len() {
        let parts = (1..=6).filter(|part| tier::is_in_part(&format!("{part}/6"), index));
        assert_eq!(parts.count(), 1, "{index}");
    }
}

#[test]
fn names_differ_and_classes_are_full() {
    let all = table::all();
    let names: BTreeSet<&str> = all.iter().map(|case| case.name.as_str()).collect();
    assert!(names.len() == all.len() && all.len() >= 120, "{} of {}", names.len(), all.len());
    use Class::{Bsdfs, Cameras, Curves, Emitters, Extremes, Media, Passages, Paths, Shapes};
    for class in [Shapes, Bsdfs, Emitters, Cameras, Paths, Extremes, Curves, Passages, Media] {
        assert!(names.contains(table::twin(class).scene), "{class}");
    }
    assert!(all.iter().all(|case| case.xml.contains("max_depth")));
}

/// The documents give the number of scenes.
#[test]
fn the_documents_count_the_scenes() {
    let all = table::all();
    let of_mitsuba = all.iter().filter(|case| case.reference == table::Reference::Mitsuba).count();
    let page = include_str!("../../docs/lab-notes/features.md");
    let sentence = format!("renders {} scenes of 24 x 18 pixels. {of_mitsuba} have a picture of Mitsuba", all.len());
    assert!(page.contains(&sentence), "docs/lab-notes/features.md lacks: {sentence}");
    for (name, document) in [
        ("CONTRIBUTING.md", include_str!("../../CONTRIBUTING.md")),
        ("docs/correctness.md", include_str!("../../docs/correctness.md")),
        ("docs/lab-notes/README.md", include_str!("../../docs/lab-notes/README.md")),
    ] {
        assert!(
            document.contains(&format!(" {} small", all.len())),
            "{name} lacks the number of scenes, {}",
            all.len()
        );
    }
}

/// Writes the scenes into the folder `LODESTAR_FEATURES_SCENES`, where that is set, for `make.py` and for people.
#[test]
fn write_scenes() {
    let Some(folder) = env::var_os("LODESTAR_FEATURES_SCENES").map(PathBuf::from) else { return };
    fs::create_dir_all(&folder).expect("a folder");
    let cases = table::all();
    write_to(&folder, &cases);
    let likes = cases.iter().filter(|case| case.reference != table::Reference::Mitsuba);
    let names: String = likes.map(|case| case.name.clone() + "\n").collect();
    fs::write(folder.join("likes.txt"), names).expect("a list written");
}
