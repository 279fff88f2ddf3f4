//! Set 0, Frame: film pages, scene constants, materials, emitters and counters.

use std::sync::Arc;

use glam::{Mat4, Vec3};

use super::film_pages::{FilmPage, PageBuffers, empty_picture};
use super::statistics::Counts;
use super::{buffer_kind, set_shape};
use crate::Result;
use crate::bvh::Bvh;
use crate::film::Picture;
use crate::gpu::{Buffer, BufferKind, Context, DescriptorSet};
use crate::kernels::{self, Kernels};
use crate::layout;
use crate::scene::{Bsdf, Material, Projection, Scene};
use crate::settings::Settings;

/// Learning targets saturate at this multiple of the largest emitted radiance.
const TARGET_LIMIT: f32 = 16.0;
/// Bit of [`layout::Material::kind_and_sides`].
const TWO_SIDED: u32 = 0x100;

/// The set, once for every film page; all else is shared between them.
pub(super) struct Frame {
    pages: Vec<FilmPage>,
    counters: Arc<Buffer>,
}

impl Frame {
    pub fn new(
        context: &Arc<Context>,
        kernels: &Kernels,
        scene: &Scene,
        bvh: &Bvh,
        settings: &Settings,
    ) -> Result<Self> {
        let uploaded = |name: &str, bytes: &[u8], kind| -> Result<Arc<Buffer>> {
            let buffer = Buffer::new(context, name, bytes.len() as u64, kind)?;
            buffer.upload(0, bytes)?;
            Ok(buffer)
        };
        let constants = scene_constants(scene, bvh, settings);
        let constants = uploaded("scene constants", bytemuck::bytes_of(&constants), BufferKind::Uniform)?;
        let materials: Vec<_> = scene.materials.iter().map(material).collect();
        let shape = set_shape(kernels, 0);
        let materials = uploaded("materials", bytemuck::cast_slice(&materials), buffer_kind(shape.bindings[3].kind))?;
        let emitters: Vec<_> =
            scene.emitters.iter().map(|e| layout::Emitter { radiance: e.radiance.into(), reserved: 0.0 }).collect();
        let emitters = uploaded("emitters", bytemuck::cast_slice(&emitters), buffer_kind(shape.bindings[4].kind))?;
        let counters = Buffer::new(context, "counters", u64::from(kernels::COUNTER_COUNT) * 4, BufferKind::Storage)?;
        let page = |buffers: PageBuffers| -> Result<FilmPage> {
            let all = [&buffers.radiance, &buffers.features, &constants, &materials, &emitters, &counters];
            let set = DescriptorSet::new(context, "frame", shape, &all)?;
            Ok(buffers.with_set(set))
        };
        let pages = PageBuffers::allocate(context, settings)?.into_iter().map(page).collect::<Result<_>>()?;
        Ok(Self { pages, counters })
    }

    pub fn pages(&self) -> std::slice::Iter<'_, FilmPage> {
        self.pages.iter()
    }

    /// A film has at least one pixel, so at least one page.
    pub fn first_page(&self) -> &FilmPage {
        &self.pages[0]
    }

    pub fn counters(&self) -> &Buffer {
        &self.counters
    }

    pub fn read_counts(&self) -> Result<Counts> {
        Ok(Counts::from_counters(&self.counters.read(0, kernels::COUNTER_COUNT as usize)?))
    }

    pub fn picture(&self, settings: &Settings) -> Result<Picture> {
        let mut picture = empty_picture(settings);
        self.pages.iter().try_for_each(|page| page.read_into(&mut picture))?;
        Ok(picture)
    }
}

fn material(material: &Material) -> layout::Material {
    let sides = if material.two_sided { TWO_SIDED } else { 0 };
    match material.bsdf {
        Bsdf::Diffuse { reflectance } => {
            layout::Material { reflectance: reflectance.into(), kind_and_sides: kernels::BSDF_DIFFUSE | sides }
        }
    }
}

fn scene_constants(scene: &Scene, bvh: &Bvh, settings: &Settings) -> layout::SceneConstants {
    let camera = &scene.camera;
    let (aperture_radius, focus_distance) = match camera.projection {
        Projection::ThinLens { aperture_radius, focus_distance } => (aperture_radius, focus_distance),
        _ => (0.0, 1.0),
    };
    let window = settings.window();
    let extent = (bvh.bounds.1 - bvh.bounds.0).max(Vec3::splat(bvh.largest_coordinate().max(1.0e-20) * 1.0e-6));
    let rows = rows(&camera.world_from_camera);
    layout::SceneConstants {
        world_from_camera: rows,
        film_size: [settings.width as f32, settings.height as f32],
        raster_scale: camera.half_extent(settings.width, settings.height).into(),
        principal_point: camera.principal_point.into(),
        near_clip: camera.near_clip,
        far_clip: camera.far_clip,
        bounds_min: bvh.bounds.0.into(),
        aperture_radius,
        cells_per_unit: (settings.grid as f32 / extent).into(),
        target_limit: target_limit(scene),
        environment: scene.environment.into(),
        seed: settings.seed,
        window_offset: [window.x, window.y],
        window_size: [window.width, window.height],
        focus_distance,
        reserved: 0,
    }
}

/// The upper three rows, as the kernels read them.
fn rows(matrix: &Mat4) -> [[f32; 4]; 3] {
    [0, 1, 2].map(|i| matrix.row(i).into())
}

fn target_limit(scene: &Scene) -> f32 {
    let brightest = scene.emitters.iter().map(|e| e.radiance).chain([scene.environment]).map(|c| c.element_sum() / 3.0);
    match brightest.fold(0.0, f32::max) {
        0.0 => TARGET_LIMIT,
        most => TARGET_LIMIT * most,
    }
}
