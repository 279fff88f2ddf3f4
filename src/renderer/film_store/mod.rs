//! The film on the device, and what a step's end does with it.

use std::ops::Range;
use std::sync::Arc;

use crate::Result;
use crate::film::Picture;
use crate::generated::kernels::{Kernels, Variant};
use crate::gpu::{Context, Kernel};
use crate::renderer::film_store::adaptive::Adaptive;
use crate::renderer::film_store::pages::FilmPage;
use crate::renderer::film_store::part_sums::PartSums;
use crate::renderer::sets::frame::Frame;
use crate::settings::Settings;

pub(super) mod adaptive;
pub(super) mod pages;
pub(super) mod part_sums;

/// Fate of the film at the end of a step.
pub(crate) enum FilmStore {
    /// The film stays on the device and holds the whole picture.
    Plain,
    /// The film stays, too, and its tiles are sampled until noise ends them.
    Adaptive(Box<Adaptive>),
    /// The render is one part of several: the host sums up steps, and the film on the device begins anew.
    Part(PartSums),
}

impl FilmStore {
    /// The store that the settings ask for. They never ask for two: noise would end each part of a picture elsewhere.
    pub fn new(context: &Arc<Context>, kernels: &Kernels, variant: &Variant, settings: &Settings) -> Result<Self> {
        if let Some(target) = settings.noise {
            let judge = Kernel::new(context, &kernels.judge_noise, &variant.entries())?;
            return Ok(Self::Adaptive(Box::new(Adaptive::new(judge, settings, target))));
        }
        Ok(if settings.sample_offset.is_some() { Self::Part(PartSums::new(settings)) } else { Self::Plain })
    }

    /// Begins anew, for a film of perhaps another size.
    pub fn begin_anew(&mut self, settings: &Settings) {
        match self {
            Self::Plain => {}
            Self::Adaptive(adaptive) => adaptive.begin_anew(settings),
            Self::Part(sums) => *sums = PartSums::new(settings),
        }
    }

    /// Reads rows of the picture so far, with the samples of a step under way.
    pub fn picture(&self, frame: &Frame, settings: &Settings, rows: &Range<u32>) -> Result<Picture> {
        match self {
            Self::Plain | Self::Adaptive(_) => frame.picture(settings, rows),
            Self::Part(sums) => sums.picture(frame, settings, rows),
        }
    }

    /// Number of samples so far, those of a step under way among them, in all pixels together.
    pub fn samples(&self, frame: &Frame, settings: &Settings) -> Result<u64> {
        let window = settings.window();
        let of_page = |page: &FilmPage| page.samples([window.width, window.height]);
        match self {
            Self::Plain | Self::Adaptive(_) => frame.pages().iter().map(of_page).sum(),
            Self::Part(sums) => {
                Ok(sums.picture(frame, settings, &(0..window.height))?.sample_count.into_iter().map(u64::from).sum())
            }
        }
    }

    pub fn adaptive(&self) -> Option<&Adaptive> {
        match self {
            Self::Adaptive(adaptive) => Some(adaptive),
            Self::Plain | Self::Part(_) => None,
        }
    }
}
