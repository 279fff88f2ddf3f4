//! Set 0, Frame: film pages, scene constants, materials, emitters and counters.

use std::ops::Range;
use std::sync::Arc;

use glam::Mat4;

use crate::Result;
use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::encode::lights::Lights;
use crate::encode::media;
use crate::encode::surfaces::{Shading, Surfaces};
use crate::encode::textures::TexelWords;
use crate::film::Picture;
use crate::generated::kernels::bindings::frame as numbers;
use crate::generated::kernels::{self, Kernels};
use crate::generated::layout;
use crate::generated::layout::SceneConstants;
use crate::gpu::{Buffer, BufferKind, Context, Recorder, SetShape};
use crate::renderer::film_store::pages::{FilmPage, PageBuffers, empty_picture, indices_of};
use crate::renderer::persistent::{Persistent, Span};
use crate::renderer::sets::shapes::{buffer_kind, set_over, set_shape, word_buffer_kind};
use crate::renderer::statistics::Counts;
use crate::scene::texel_pages::MAX_PAGES;
use crate::scene::{Camera, Projection, Scene};
use crate::settings::{Learner, Settings};

/// Texels of a material's record.
const MATERIAL_TEXELS: u32 = (size_of::<layout::MaterialRecord>() / layout::TEXEL_BYTES) as u32;

/// Words of the statistics: a low and a high one each.
const STATISTICS_WORDS: u32 = 2 * kernels::COUNTER_COUNT;

/// Targets of learners that bootstrap saturate at this multiple of the largest emitted radiance.
const TARGET_LIMIT: f32 = 16.0;
/// Collected returns saturate at this multiple instead: roulette makes the few paths that survive count for more.
const RETURN_LIMIT: f32 = 1024.0;
/// Most that targets saturate at, so that no sum of 2^40 of them leaves single precision.
const MOST_LIMIT: f32 = 1.0e26;

/// The set, once for every film page. Pages share all buffers but those of the film.
pub(crate) struct Frame {
    pages: Vec<FilmPage>,
    shared: SharedBuffers,
    constants: SceneConstants,
    counters: Arc<Buffer>,
    /// Copy of the counters that the host can read.
    counters_read: Arc<Buffer>,
}

/// Buffers that all pages share.
struct SharedBuffers {
    shape: &'static SetShape,
    /// The buffers with the numbers of their bindings.
    numbered: Vec<(u32, Arc<Buffer>)>,
    constants: Arc<Buffer>,
    /// Scratch memory in place of that of each page.
    scratch: Option<Arc<Buffer>>,
}

impl SharedBuffers {
    /// Pages of an empty film.
    fn pages(&self, context: &Arc<Context>, settings: &Settings) -> Result<Vec<FilmPage>> {
        let page = |buffers: PageBuffers| -> Result<FilmPage> {
            let own = [
                (numbers::FILM_RADIANCE_PAGE, &buffers.radiance),
                (numbers::FILM_FEATURES_PAGE, &buffers.features),
                (numbers::SCRATCH, self.scratch.as_ref().unwrap_or(&buffers.adaptive)),
            ];
            let shared = self.numbered.iter().map(|(number, buffer)| (*number, buffer));
            let set = set_over(context, "frame", self.shape, &shared.chain(own).collect::<Vec<_>>())?;
            buffers.with_set(set)
        };
        PageBuffers::allocate(context, settings)?.into_iter().map(page).collect()
    }
}

impl Frame {
    /// The set of a scene. Kernels find `scratch` in place of the scratch memory of the film's pages, if it is given.
    #[expect(clippy::too_many_arguments, reason = "what a set shows")]
    pub fn new(
        context: &Arc<Context>,
        kernels: &Kernels,
        scene: &Scene,
        shading: &Shading,
        bvh: &Bvh,
        cells: &Cells,
        settings: &Settings,
        scratch: Option<Arc<Buffer>>,
    ) -> Result<Self> {
        let Shading { surfaces: surfaces @ Surfaces { textures, .. }, lights } = shading;
        let uploaded = |name: &str, bytes: &[u8], kind| Buffer::with_values(context, name, bytes, kind);
        let mut constants = scene_constants(scene, cells, lights, settings);
        constants.camera_motion = bvh.motions.of_camera.map_or(0, |[first, _]| first);
        let constants_buffer = uploaded("scene constants", bytemuck::bytes_of(&constants), BufferKind::Uniform)?;
        let shape = set_shape(kernels, kernels::FRAME_SET);
        let materials = uploaded("materials", &surfaces.material_bytes(), buffer_kind(shape, numbers::MATERIALS))?;
        let emitters = lights.texels();
        let emitters = uploaded("emitters", bytemuck::cast_slice(&emitters), buffer_kind(shape, numbers::EMITTERS))?;
        // After the statistics, the lengths of a wave's queues: of paths and of connections, for every edge.
        let counter_bytes = u64::from(STATISTICS_WORDS + 2 * settings.depth_bound()) * 4;
        let counters = Buffer::new(context, "counters", counter_bytes, BufferKind::Storage)?;
        let counters_read = Buffer::new(context, "counters for the host", counter_bytes, BufferKind::Readback)?;
        let records = bytemuck::cast_slice(&textures.records);
        let records = uploaded("textures", records, buffer_kind(shape, numbers::TEXTURES))?;
        let [words0, words1, words2, words3] = texel_words(context, shape, &textures.words)?;
        let numbered = vec![
            (numbers::SCENE, Arc::clone(&constants_buffer)),
            (numbers::MATERIALS, materials),
            (numbers::EMITTERS, emitters),
            (numbers::COUNTERS, Arc::clone(&counters)),
            (numbers::TEXEL_WORDS, words0),
            (numbers::TEXTURES, records),
            (numbers::TEXEL_WORDS1, words1),
            (numbers::TEXEL_WORDS2, words2),
            (numbers::TEXEL_WORDS3, words3),
        ];
        let shared = SharedBuffers { shape, numbered, constants: constants_buffer, scratch };
        let pages = shared.pages(context, settings)?;
        Ok(Self { pages, shared, constants, counters, counters_read })
    }

    /// Makes an empty film of the size that the settings have in place of this one.
    pub fn resize(&mut self, context: &Arc<Context>, settings: &Settings) -> Result<()> {
        self.pages = self.shared.pages(context, settings)?;
        Ok(())
    }

    /// Looks from now on through a camera that stands still, with the film and the seed of these settings.
    pub fn look_through(&mut self, camera: &Camera, settings: &Settings) -> Result<()> {
        set_view(&mut self.constants, camera, settings);
        self.constants.camera_motion = 0;
        self.shared.constants.upload(0, &[self.constants])
    }

    pub fn pages(&self) -> &[FilmPage] {
        &self.pages
    }

    /// First page. A film has at least one pixel, so at least one page.
    pub fn first_page(&self) -> &FilmPage {
        &self.pages[0]
    }

    /// Records that all counters begin at zero.
    pub fn clear_counts<'a>(&'a self, recorder: &mut Recorder<'a>) {
        recorder.fill_zero(&self.counters);
        recorder.barrier();
    }

    /// Records that the host can [read](Self::read_counts) what was counted.
    pub fn hand_over_counts<'a>(&'a self, recorder: &mut Recorder<'a>) {
        recorder.barrier();
        recorder.copy(&self.counters, 0, &self.counters_read, 0, self.counters.len_bytes());
    }

    /// Reads what was counted up to the last submission that [handed it over](Self::hand_over_counts).
    pub fn read_counts(&self) -> Result<Counts> {
        Ok(Counts::from_counters(&self.counters_read.read(0, STATISTICS_WORDS as usize)?))
    }

    /// Reads how many paths were queued for an edge up to that submission.
    pub fn read_queued(&self, edge: u32) -> Result<u32> {
        let length: Vec<u32> = self.counters_read.read(u64::from(STATISTICS_WORDS + edge) * 4, 1)?;
        Ok(length[0])
    }

    pub fn persistent(&self) -> Vec<Persistent<'_>> {
        let spans = |span: fn(&FilmPage) -> Span<'_>| self.pages.iter().map(span).collect();
        let mut parts = vec![
            Persistent { name: "film radiance", spans: spans(|page| page.radiance().into()) },
            Persistent { name: "film features", spans: spans(|page| page.features().into()) },
        ];
        if self.first_page().is_adaptive() {
            parts.push(Persistent { name: "film halves", spans: spans(FilmPage::halves) });
        }
        parts
    }

    /// Rows of the picture.
    pub fn picture(&self, settings: &Settings, rows: &Range<u32>) -> Result<Picture> {
        let (mut picture, indices) = (empty_picture(settings, rows), indices_of(rows, settings));
        self.pages.iter().try_for_each(|page| page.read_into(&mut picture, settings, &indices, rows.start))?;
        Ok(picture)
    }
}

/// Buffers of the pages of texel words. Every binding needs a buffer, so the last page serves for those that there are not.
fn texel_words(context: &Arc<Context>, shape: &SetShape, words: &TexelWords) -> Result<[Arc<Buffer>; MAX_PAGES]> {
    let kind = word_buffer_kind(shape, numbers::TEXEL_WORDS);
    let mut buffers = Vec::new();
    for (i, page) in words.pages().iter().enumerate() {
        buffers.push(Buffer::with_values(context, &format!("texel words {i}"), page, kind)?);
    }
    Ok(std::array::from_fn(|i| Arc::clone(&buffers[i.min(buffers.len() - 1)])))
}

fn scene_constants(scene: &Scene, cells: &Cells, lights: &Lights, settings: &Settings) -> SceneConstants {
    let mut constants = SceneConstants {
        bounds_min: cells.grid.origin.into(),
        cells_per_unit: cells.grid.per_unit.into(),
        target_limit: target_limit(lights.brightest().max(media::brightest(&scene.media)), settings.learner),
        grid_size: cells.grid.size.into(),
        cell_count: cells.count(),
        all_cell_count: cells.all_count(),
        first_medium: scene.materials.len() as u32,
        camera_medium: media::number(scene.media.of_camera),
        first_volume: (scene.materials.len() + scene.media.all.len()) as u32 * MATERIAL_TEXELS,
        ..bytemuck::Zeroable::zeroed()
    };
    set_view(&mut constants, &scene.camera, settings);
    lights.write_constants(&mut constants);
    constants
}

/// Writes the camera, the film and the seed.
fn set_view(constants: &mut SceneConstants, camera: &Camera, settings: &Settings) {
    let (aperture_radius, focus_distance) = match camera.projection {
        Projection::ThinLens { aperture_radius, focus_distance } => (aperture_radius, focus_distance),
        _ => (0.0, 1.0),
    };
    let (raster_scale, principal_point) = match camera.projection {
        Projection::Equirectangular { longitude: [left, right], latitude: [bottom, top] } => {
            ([(right - left) / 360.0, (bottom - top) / 360.0], [left / 360.0, top / 360.0])
        }
        _ => (camera.half_extent(settings.width, settings.height).into(), camera.principal_point.into()),
    };
    let window = settings.window();
    *constants = SceneConstants {
        world_from_camera: rows(&camera.world_from_camera),
        film_size: [settings.width as f32, settings.height as f32],
        raster_scale,
        principal_point,
        near_clip: camera.near_clip,
        far_clip: camera.far_clip,
        aperture_radius,
        seed: settings.seed,
        window_offset: [window.x, window.y],
        window_size: [window.width, window.height],
        focus_distance,
        ..*constants
    };
}

/// The matrix's upper three rows.
fn rows(matrix: &Mat4) -> [[f32; 4]; 3] {
    [0, 1, 2].map(|i| matrix.row(i).into())
}

/// Radiance at which learning targets saturate.
fn target_limit(brightest: f32, learner: Learner) -> f32 {
    let multiple = match learner {
        Learner::Sarsa | Learner::ExpectedSarsa => TARGET_LIMIT,
        Learner::MonteCarlo => RETURN_LIMIT,
    };
    match brightest {
        0.0 => multiple,
        // `min` drops a NaN.
        most => (multiple * most).min(MOST_LIMIT),
    }
}
