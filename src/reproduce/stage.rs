//! Stage for one scene: loads the scene, chooses the pictures' size, measures the methods, and stores records and
//! pictures.

use std::cell::Cell;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use super::contest::{Entrant, Stage};
use super::error_map::error_map;
use super::methods::Method;
use super::plan::Plan;
use super::protocol;
use super::record::{Conditions, Record, settings_value};
use crate::encode::bvh::Bvh;
use crate::film::{self, Picture, identity};
use crate::gpu::Context;
use crate::image::{Image, ToneCurve, exr, metrics, png};
use crate::radiance_map::MappedScene;
use crate::renderer::Renderer;
use crate::scene::{self, LoadOptions, Scene};
use crate::settings::Settings;
use crate::{Error, Result, files};

/// Number of steps that are timed to choose the size. One untimed step before them warms up the device.
const TIMED_STEPS: u32 = 2;

/// Scene of a run, with the data that its methods share.
pub(super) struct SceneStage<'a> {
    plan: &'a Plan,
    name: &'static str,
    context: &'a Arc<Context>,
    scene: Scene,
    bvh: Bvh,
    reference: Image,
    template: Conditions,
}

/// Stored choice of a scene's size. A resumed run uses it, so that all pictures have one size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Size {
    /// Conditions of the choice.
    conditions: Conditions,
    /// Factor by which the reference is averaged down.
    factor: u32,
}

impl<'a> SceneStage<'a> {
    pub fn load(plan: &'a Plan, name: &'static str, context: &'a Arc<Context>) -> Result<Self> {
        let scene = scene::load(&plan.scene_file(name), &LoadOptions::default())?;
        let whole = exr::read_rgb(&plan.reference_file(name))?;
        let device = context.device();
        let template = Conditions {
            version: env!("CARGO_PKG_VERSION").into(),
            device: format!("{} ({})", device.name, device.driver_info),
            scene_hash: scene::fingerprint(&scene)?,
            reference_hash: format!("{:032x}", xxh3_128(bytemuck::cast_slice(&whole.pixels))),
            budget: plan.seconds,
            settings: serde_json::Value::Null,
        };
        let bvh = Bvh::of_scene(&scene);
        let mut stage = Self { plan, name, context, scene, bvh, reference: whole, template };
        create_folder(&stage.folder())?;
        let factor = stage.factor()?;
        stage.reference = protocol::average_down(&stage.reference, factor);
        png::write(&stage.file("reference.png"), &stage.reference, ToneCurve::Paper, 0.0)?;
        film::write_picture(&stage.file("reference.exr"), &picture_of(&stage.reference), &[])?;
        Ok(stage)
    }

    /// Splits the methods into those measured already, with their records, and those that are missing.
    pub fn look_up(&self, methods: &[Method]) -> Result<(Vec<Record>, Vec<Method>)> {
        let (mut found, mut missing) = (Vec::new(), Vec::new());
        for method in methods {
            let conditions = self.conditions(&self.settings(method));
            match Record::read(&self.file(&format!("{}.json", method.name())), &conditions)? {
                Some(record) => found.push(record),
                None => missing.push(*method),
            }
        }
        Ok((found, missing))
    }

    /// Measures these methods. `advanced` is told the current work and the total rendering time so far, in seconds.
    pub fn measure(
        &self,
        missing: &[Method],
        stop: &dyn Fn() -> bool,
        advanced: &dyn Fn(&str, f64),
    ) -> Result<Option<Vec<Record>>> {
        let entering = missing.iter().map(|method| (*method, self.settings(method))).collect();
        self.contest(entering, stop, advanced, &|entrant| self.keep(entrant))
    }

    /// Lets these methods render, as many at once as fit into memory. Returns the results of `keep`.
    pub fn contest<T>(
        &self,
        mut entering: Vec<(Method, Settings)>,
        stop: &dyn Fn() -> bool,
        advanced: &dyn Fn(&str, f64),
        keep: &dyn Fn(&Entrant) -> Result<T>,
    ) -> Result<Option<Vec<T>>> {
        let done = Cell::new(0.0);
        let note = |method: &str, seconds: f64| {
            done.set(done.get() + seconds);
            advanced(method, done.get());
        };
        let stage = Stage {
            context: self.context,
            scene: &self.scene,
            bvh: &self.bvh,
            reference: &self.reference,
            budget: self.plan.seconds,
            stop,
            advanced: &note,
        };
        let mut kept = Vec::new();
        while !entering.is_empty() {
            advanced("building kernels", done.get());
            let Some(entrants) = stage.run(&entering)? else { return Ok(None) };
            entering.drain(..entrants.len());
            for entrant in entrants {
                kept.push(keep(&entrant)?);
            }
        }
        Ok(Some(kept))
    }

    /// Stores a result. The record is written last, because its presence means that the other files are complete.
    fn keep(&self, entrant: &Entrant) -> Result<Record> {
        let picture = entrant.picture()?;
        let image = picture.image();
        let name = entrant.method.name();
        let attributes = identity::attributes(&self.template.scene_hash, &entrant.settings);
        film::write_picture(&self.file(&format!("{name}.exr")), &picture, &attributes)?;
        png::write(&self.file(&format!("{name}.png")), &image, ToneCurve::Paper, 0.0)?;
        let errors = error_map(&image, &self.reference);
        png::write(&self.file(&format!("{name}-error.png")), &errors, ToneCurve::Srgb, 0.0)?;
        let record = Record {
            conditions: self.conditions(&entrant.settings),
            scene: self.name.into(),
            method: name.clone(),
            width: picture.width,
            height: picture.height,
            spp: entrant.spp,
            seconds: entrant.seconds,
            errors: metrics::compare(&image, &self.reference)?,
            counts: entrant.counts,
            memory: entrant.memory(),
            steps: entrant.steps.clone(),
        };
        record.write(&self.file(&format!("{name}.json")))?;
        Ok(record)
    }

    /// Factor by which the reference is averaged down: from `--scale`, from an earlier run, or from the speed of
    /// `bsdf`.
    fn factor(&self) -> Result<u32> {
        let size = [self.reference.width, self.reference.height];
        if let Some(scale) = self.plan.scale {
            return protocol::factor_of_scale(size, scale);
        }
        let path = self.file("size.json");
        let conditions = self.template.clone();
        let before = fs::read_to_string(&path).ok().and_then(|text| serde_json::from_str::<Size>(&text).ok());
        if let Some(before) = before.filter(|before| before.conditions == conditions) {
            return Ok(before.factor);
        }
        let factor = protocol::factor_for(size, self.seconds_per_path(size)?, self.plan.seconds);
        files::write_json(&path, &Size { conditions, factor })?;
        Ok(factor)
    }

    /// Time that `bsdf` takes for a path, in seconds, measured on pictures of a likely size.
    fn seconds_per_path(&self, size: [u32; 2]) -> Result<f64> {
        let factors = protocol::factors(size);
        let factor = factors.get(1).copied().unwrap_or(1);
        let [width, height] = size.map(|side| side / factor);
        let settings = Method::PLAIN.settings(Settings::for_scene(&self.scene), [width, height]);
        let mut renderer = Renderer::new(self.context, &self.scene, &self.bvh, &settings)?;
        let mut step = || renderer.step(settings.spp_per_step, &|| false).map(|report| report.seconds);
        step()?;
        let seconds: f64 = (0..TIMED_STEPS).map(|_| step()).sum::<Result<f64>>()?;
        Ok(seconds / (f64::from(width * height) * f64::from(TIMED_STEPS * settings.spp_per_step)))
    }

    pub fn settings(&self, method: &Method) -> Settings {
        method.settings(Settings::for_scene(&self.scene), [self.reference.width, self.reference.height])
    }

    pub fn conditions(&self, settings: &Settings) -> Conditions {
        Conditions { settings: settings_value(settings), ..self.template.clone() }
    }

    pub fn name(&self) -> &'static str {
        self.name
    }

    pub fn place(&self) -> MappedScene<'_> {
        MappedScene { context: self.context, scene: &self.scene, bvh: &self.bvh }
    }

    fn folder(&self) -> PathBuf {
        self.plan.out.join(self.name)
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.folder().join(name)
    }
}

fn create_folder(folder: &PathBuf) -> Result<()> {
    fs::create_dir_all(folder).map_err(Error::write(folder))
}

fn picture_of(image: &Image) -> Picture {
    let (width, height) = (image.width, image.height);
    Picture { radiance: image.pixels.clone(), ..Picture::empty(width, height, [0, 0], [width, height]) }
}
