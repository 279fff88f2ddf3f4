//! Layers that compositors read beside a picture: positions, texture coordinates, motion, and mattes of objects and materials. They say what
//! camera rays meet first behind surfaces with holes, so they are free of the noise of light.
//!
//! | channels | what |
//! |---|---|
//! | `position.X`, `.Y`, `.Z` | point in world space |
//! | `uv.U`, `.V` | texture coordinates |
//! | `motion.X`, `.Y` | way of the point over the picture while the shutter is open, in pixels to the right and up |
//! | `CryptoObject00.R` to `CryptoObject02.A` | Cryptomatte of objects |
//! | `CryptoMaterial00.R` to `CryptoMaterial02.A` | Cryptomatte of materials |
//!
//! Positions, coordinates and motion are means over the samples of the object that most samples of a pixel meet, because a mean over several
//! objects lies on none of them. They are 0 where no sample meets anything.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use glam::{DMat4, DVec2, DVec3, Vec3};

use crate::Result;
use crate::encode::bvh::Bvh;
use crate::film::View;
use crate::film::matte::{self, Count, Coverage, RANKS, ranked};
use crate::generated::constants::NONE;
use crate::generated::layout::FirstHitRecord;
use crate::gpu::Context;
use crate::image::columns::{Column, Columns, Rows, ValueAt};
use crate::image::exr::{self, FileHeader};
use crate::image::rows_at_a_time;
use crate::renderer::first_hits::FirstHits;
use crate::scene::objects::{Names, name_of_id};
use crate::scene::{Camera, Projection, Scene};
use crate::settings::Settings;

/// Most names that a file has of its objects, and of its materials. Without names the mattes of a file can still be picked by eye.
const MOST_NAMES: usize = 1 << 16;
/// Name of what has none.
const UNNAMED: &str = "unnamed";

/// Layers of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// Positions in world space.
    Position,
    /// Texture coordinates.
    Uv,
    /// Motion over the picture while the shutter is open.
    Motion,
    /// Cryptomatte of objects.
    Objects,
    /// Cryptomatte of materials.
    Materials,
}

impl Layer {
    /// All layers.
    pub const ALL: [Self; 5] = [Self::Position, Self::Uv, Self::Motion, Self::Objects, Self::Materials];

    /// Name by which a caller asks for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Uv => "uv",
            Self::Motion => "motion",
            Self::Objects => "objects",
            Self::Materials => "materials",
        }
    }
}

/// Order for a file of layers.
pub struct Request<'a> {
    /// The device.
    pub context: &'a Arc<Context>,
    /// The scene.
    pub scene: &'a Scene,
    /// Hierarchy of the scene.
    pub bvh: &'a Bvh,
    /// Film, seed, filter and traversal. All else is ignored.
    pub settings: &'a Settings,
    /// Samples per pixel.
    pub samples: u32,
    /// The layers.
    pub layers: &'a [Layer],
}

impl Request<'_> {
    /// Writes the layers as an EXR file, with `attributes` (name and value) as text attributes named `lodestar.<name>`. Calls `tell` with the
    /// share that is written, in [0, 1], again and again. Memory holds a few rows at a time. Returns sentences about what the file lacks.
    ///
    /// # Errors
    /// Where the device cannot hold the scene or is lost, and where the file cannot be written.
    pub fn write(
        &self,
        path: &Path,
        attributes: &[(String, String)],
        tell: &mut dyn FnMut(f64),
    ) -> Result<Vec<String>> {
        let hits = FirstHits::new(self.context, self.scene, self.bvh, self.settings)?;
        let reader = Reader::new(self.scene, self.bvh, self.settings);
        let view = View::new(&self.scene.camera, self.settings.width, self.settings.height);
        let mut header = FileHeader {
            attributes: attributes.to_vec(),
            foreign: Vec::new(),
            camera_from_world: view.map(|view| view.camera_from_world),
            film_from_world: view.map(|view| view.film_from_world),
        };
        let mut notes = Vec::new();
        if self.layers.contains(&Layer::Motion) && self.scene.camera.projection == Projection::EqualArea {
            notes.push("the layer motion is 0, because it is not known for equal-area panoramas".to_owned());
        }
        for (layer, mattes) in [(Layer::Objects, &reader.objects), (Layer::Materials, &reader.materials)] {
            if self.layers.contains(&layer) {
                header.foreign.extend(mattes.attributes(&mut notes));
            }
        }
        let mut make = |rows: Range<u32>, take: &mut dyn FnMut(&Rows<'_>)| {
            let pixels = (rows.end - rows.start) as usize * self.settings.window().width as usize;
            let mut strip = vec![Pixel::default(); pixels];
            hits.of_rows(&rows, self.samples, &mut |at, records| strip[at] = reader.pixel(records))?;
            take(&Rows { columns: &self.columns(&strip), first: rows.start });
            Ok(())
        };
        let rows = rows_at_a_time(self.settings.window().width);
        exr::write_rows(path, &self.columns(&[]), &header, rows, &mut make, tell)?;
        Ok(notes)
    }

    fn columns<'a>(&self, strip: &'a [Pixel]) -> Columns<'a> {
        let window = self.settings.window();
        Columns {
            width: window.width,
            height: window.height,
            offset: [window.x, window.y],
            full_size: [self.settings.width, self.settings.height],
            channels: self.layers.iter().flat_map(|&layer| channels(layer, strip)).collect(),
        }
    }
}

fn channels(layer: Layer, strip: &[Pixel]) -> Vec<(String, Column<'_>)> {
    type Values = fn(&Pixel, usize) -> f32;
    let floats = |names: &[&str], value: Values| -> Vec<(String, Column<'_>)> {
        let column = |(at, name): (usize, &&str)| {
            let value: ValueAt<'_, f32> = Box::new(move |pixel| value(&strip[pixel], at));
            ((*name).to_owned(), Column::Floats(value))
        };
        names.iter().enumerate().map(column).collect()
    };
    let mattes = |layer: &str, value: Values| {
        let names: Vec<String> =
            (0..2 * RANKS).map(|at| format!("{layer}{:02}.{}", at / 4, ["R", "G", "B", "A"][at % 4])).collect();
        floats(&names.iter().map(String::as_str).collect::<Vec<_>>(), value)
    };
    match layer {
        Layer::Position => floats(&["position.X", "position.Y", "position.Z"], |pixel, at| pixel.position[at]),
        Layer::Uv => floats(&["uv.U", "uv.V"], |pixel, at| pixel.uv[at]),
        Layer::Motion => floats(&["motion.X", "motion.Y"], |pixel, at| pixel.motion[at]),
        Layer::Objects => mattes(OBJECTS, |pixel, at| pixel.objects[at / 2].number(at % 2)),
        Layer::Materials => mattes(MATERIALS, |pixel, at| pixel.materials[at / 2].number(at % 2)),
    }
}

/// Names of the mattes' layers.
const OBJECTS: &str = "CryptoObject";
const MATERIALS: &str = "CryptoMaterial";

/// Layers of a pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Pixel {
    position: [f32; 3],
    uv: [f32; 2],
    motion: [f32; 2],
    objects: [Coverage; RANKS],
    materials: [Coverage; RANKS],
}

/// Things by their names.
struct Mattes {
    layer: &'static str,
    names: Vec<Arc<str>>,
    /// Number that stands for each name in a file.
    ids: Vec<f32>,
}

impl Mattes {
    /// The names, and one for what has none behind them.
    fn new(layer: &'static str, mut names: Vec<Arc<str>>) -> Self {
        names.push(UNNAMED.into());
        let ids = names.iter().map(|name| matte::identifier(name)).collect();
        Self { layer, names, ids }
    }

    fn attributes(&self, notes: &mut Vec<String>) -> Vec<(String, String)> {
        let mut names: Vec<&str> = self.names.iter().map(AsRef::as_ref).collect();
        if names.len() > MOST_NAMES {
            let (layer, count) = (self.layer, names.len());
            notes.push(format!("the file names none of the {count} parts of {layer}: it names {MOST_NAMES} at most"));
            names.clear();
        }
        matte::attributes(self.layer, &names)
    }

    /// Shares of a pixel, given how many of its `samples` samples met which names.
    fn coverage(&self, met: &[Count], samples: usize) -> [Coverage; RANKS] {
        let mut found = [Coverage::default(); RANKS];
        for (coverage, count) in found.iter_mut().zip(met) {
            *coverage = Coverage { id: self.ids[count.object as usize], share: count.samples as f32 / samples as f32 };
        }
        found
    }
}

/// Reader of records.
struct Reader<'a> {
    scene: &'a Scene,
    bvh: &'a Bvh,
    size: DVec2,
    /// Matrices of the camera where the shutter opens and where it closes: from the world to the film or, for a panorama, to the camera's
    /// own space.
    from_world: [DMat4; 2],
    objects: Mattes,
    materials: Mattes,
    /// Index of each material's name.
    material_names: Vec<u32>,
}

impl<'a> Reader<'a> {
    fn new(scene: &'a Scene, bvh: &'a Bvh, settings: &Settings) -> Self {
        let from_world = [0.0, 1.0].map(|time| {
            let moved = scene.camera_motion.as_ref().map(|motion| motion.at(time).as_mat4());
            let camera = Camera { world_from_camera: moved.unwrap_or(scene.camera.world_from_camera), ..scene.camera };
            let own = || camera.world_from_camera.as_dmat4().inverse();
            View::new(&camera, settings.width, settings.height).map_or_else(own, |view| view.film_from_world.as_dmat4())
        });
        let mut names = Names::default();
        let material_names =
            scene.materials.iter().map(|material| names.index(&name_of_id(&material.name).into())).collect();
        Self {
            scene,
            bvh,
            size: DVec2::new(settings.width.into(), settings.height.into()),
            from_world,
            objects: Mattes::new(OBJECTS, scene.objects.names.clone()),
            materials: Mattes::new(MATERIALS, names.into_list()),
            material_names,
        }
    }

    /// Layers of a pixel of which these are the samples.
    fn pixel(&self, records: &[FirstHitRecord]) -> Pixel {
        let met = || records.iter().filter(|record| record.primitive != NONE);
        let objects: Vec<u32> = met().map(|record| self.object(record)).collect();
        let counts = ranked(objects.iter().copied());
        let Some(&most) = counts.first() else { return Pixel::default() };
        let (mut position, mut uv, mut motion) = (DVec3::ZERO, DVec2::ZERO, DVec2::ZERO);
        for (record, _) in met().zip(&objects).filter(|&(_, &object)| object == most.object) {
            position += Vec3::from(record.position).as_dvec3();
            uv += DVec2::from(record.uv.map(f64::from));
            motion += self.motion(record);
        }
        let per_sample = 1.0 / f64::from(most.samples);
        Pixel {
            position: (per_sample * position).as_vec3().into(),
            uv: (per_sample * uv).as_vec2().into(),
            motion: (per_sample * motion).as_vec2().into(),
            objects: self.objects.coverage(&counts, records.len()),
            materials: self.materials.coverage(&ranked(met().map(|record| self.material(record))), records.len()),
        }
    }

    /// Index of the name of the object that a sample met.
    fn object(&self, record: &FirstHitRecord) -> u32 {
        let source = |primitive: u32| self.bvh.sources[primitive as usize] as usize;
        let (primitives, instances) = (self.scene.primitives.len(), self.scene.instances.len());
        let objects = &self.scene.objects;
        let found = match record.instance {
            NONE => objects.of_primitive(source(record.primitive)),
            instance => {
                objects.of_instance(source(instance) - primitives, source(record.primitive) - primitives - instances)
            }
        };
        found.unwrap_or(objects.names.len() as u32)
    }

    fn material(&self, record: &FirstHitRecord) -> u32 {
        let unnamed = self.materials.names.len() as u32 - 1;
        self.material_names.get(record.material as usize).copied().unwrap_or(unnamed)
    }

    /// Way of the point over the picture, in pixels to the right and up; 0 where the camera does not see one of its ends.
    fn motion(&self, record: &FirstHitRecord) -> DVec2 {
        let ends = [(&self.from_world[0], record.opening), (&self.from_world[1], record.closing)];
        let [Some(opening), Some(closing)] = ends.map(|(matrix, point)| self.on_film(matrix, point)) else {
            return DVec2::ZERO;
        };
        let mut way = closing - opening;
        if let Projection::Equirectangular { longitude: [left, right], .. } = self.scene.camera.projection {
            // The shorter way around.
            let turn = 360.0 / f64::from(right - left);
            way.x -= turn * (way.x / turn).round();
        }
        way * self.size * DVec2::new(1.0, -1.0)
    }

    /// Place of a point on the film, in film widths and heights from the top left corner; `None` where the camera does not see it.
    fn on_film(&self, from_world: &DMat4, point: [f32; 3]) -> Option<DVec2> {
        let point = Vec3::from(point).as_dvec3();
        let place = match self.scene.camera.projection {
            Projection::Equirectangular { longitude: [left, right], latitude: [bottom, top] } => {
                let own = from_world.transform_point3(point).normalize_or_zero();
                let longitude = (-own.x).atan2(own.z).to_degrees() - f64::from(left);
                let latitude = f64::from(top) - own.y.asin().to_degrees();
                DVec2::new(longitude / f64::from(right - left), latitude / f64::from(top - bottom))
            }
            Projection::EqualArea => return None,
            _ => {
                let on_film = *from_world * point.extend(1.0);
                (on_film.w > 0.0).then(|| on_film.truncate().truncate() / on_film.w)?
            }
        };
        place.is_finite().then_some(place)
    }
}
