//! Against pictures of another renderer. They are too large to lie here: `LODESTAR_SCENES` names the folder of the scenes
//! and `LODESTAR_REFERENCES` that of the pictures, `NAME.mean.exr` and `NAME.var.exr`.

use std::env;
use std::path::{Path, PathBuf};

use lodestar::image::exr::read_rgb;
use lodestar::scene::{LoadOptions, ReconstructionFilter, Scene, load};
use lodestar::settings::{Sampler, Settings};

use crate::device::Device;
use crate::estimate::{Comparison, Estimate, WHOLE};
use crate::scenes::{settings, with_albedo_scaled};

struct Case {
    name: &'static str,
    /// Spp for `bsdf` and for `rejection-mix`.
    spp: [u32; 2],
    /// Sides of the blocks: large ones, for what few paths find the lamp leaves smaller ones without a known variance.
    sides: &'static [usize],
    reference: Estimate,
    scene: Scene,
}

impl Case {
    /// `None`, and a line that says so, where the pictures are not at hand.
    fn find(name: &'static str, spp: [u32; 2], sides: &'static [usize]) -> Option<Self> {
        let folder = |variable| env::var_os(variable).map(PathBuf::from);
        let (Some(scenes), Some(references)) = (folder("LODESTAR_SCENES"), folder("LODESTAR_REFERENCES")) else {
            println!("{name}: skipped, for LODESTAR_SCENES and LODESTAR_REFERENCES are not both set");
            return None;
        };
        let scene = load(&scenes.join(name).join("scene.xml"), &LoadOptions::default()).expect("a scene");
        Some(Self { name, spp, sides, reference: reference(&references, name), scene })
    }

    fn render(&self, device: &Device, sampler: Sampler, seed: u32, albedo_factor: f32, pdf_tamper: f32) -> Comparison {
        let scene = with_albedo_scaled(&self.scene, albedo_factor);
        let settings = Settings {
            filter: ReconstructionFilter::Box,
            max_depth: 16,
            rr_depth: 8,
            pdf_tamper,
            ..settings(&scene, [256, 256], sampler, seed)
        };
        let spp = self.spp[sampler as usize];
        let picture = Estimate::of(&device.render(&scene, &settings, spp));
        let comparison = Comparison::new(&picture, &self.reference, self.sides);
        println!("{} {sampler:?} albedo x {albedo_factor}, pdf x {pdf_tamper}: {comparison:?}", self.name);
        comparison
    }

    fn check(&self) {
        let device = Device::new();
        for sampler in [Sampler::Bsdf, Sampler::RejectionMix] {
            let right = self.render(&device, sampler, 21, 1.0, 1.0);
            assert!(right.agrees() && right.whole < 4.0, "{sampler:?}: {right:?}");
        }
        assert!(!self.render(&device, Sampler::RejectionMix, 22, 0.97, 1.0).agrees());
        assert!(!self.render(&device, Sampler::RejectionMix, 23, 1.0, 1.05).agrees());
        assert!(!self.render(&device, Sampler::Bsdf, 24, 0.97, 1.0).agrees());
        assert!(!self.render(&device, Sampler::Bsdf, 25, 1.0, 1.05).agrees());
    }
}

fn reference(folder: &Path, name: &str) -> Estimate {
    let image = |kind| read_rgb(&folder.join(format!("{name}.{kind}.exr"))).expect("a reference");
    Estimate::new(&image("mean"), &image("var"))
}

#[test]
fn cornell_box_agrees_with_another_renderer() {
    if let Some(case) = Case::find("cornell-box", [128, 64], &[32, WHOLE]) {
        case.check();
    }
}

#[test]
fn cornell_box_hard_agrees_with_another_renderer() {
    if let Some(case) = Case::find("cornell-box-hard", [64, 64], &[32, WHOLE]) {
        case.check();
    }
}
