//! Radiance that arrives at a point of the scene, by direction: as a guide has learned it, and as it truly is (the paper's
//! Fig. 6). A map is a square of `directions` x `directions` bins, row by row from the top, in the order of the radiance grid.

use std::sync::Arc;

use glam::{Mat4, Vec2, Vec3, dvec2};

use crate::encode::bvh::Bvh;
use crate::film::Picture;
use crate::gpu::Context;
use crate::image::Image;
use crate::image::false_color::false_color;
use crate::math::direction_map::{bin_center, bin_point};
use crate::renderer::Renderer;
use crate::scene::{Camera, Crop, FovAxis, Projection, ReconstructionFilter, Scene};
use crate::settings::{MAX_FILM_SIDE, Sampler, Settings};
use crate::{Error, Result};

/// Parts along each side into which a pixel is cut, so that the middle part shows the pixel's center. The number is odd.
const CENTER_CUT: u32 = 31;
/// Most surfaces with holes in front of a visible point.
const MOST_SURFACES: u32 = 64;
/// Pixels along the side of a view, relative to the map's side. Six views, the faces of a cube, measure the true radiance.
const FACE_SCALE: u32 = 2;
/// Number of points along each side of a bin at which the six views are looked up.
const LOOKUPS: u32 = 8;
/// Distance between the surface and the eye of the six views, relative to the scene's largest coordinate.
const OFFSET: f32 = 1.0e-4;

/// Far clipping distance, beyond every scene.
const FAR: f32 = 1.0e20;
/// Approximate number of pixels along each side of a map's picture.
const PICTURE_SIDE: u32 = 512;

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Position in world space.
    pub position: Vec3,
    /// Shading normal, on the side that the camera sees.
    pub normal: Vec3,
}

/// A scene on a device.
pub struct MappedScene<'a> {
    /// The device.
    pub context: &'a Arc<Context>,
    /// The scene.
    pub scene: &'a Scene,
    /// Hierarchy of the scene.
    pub bvh: &'a Bvh,
}

/// Settings of a path tracer without a guide, on a film of `width` x `height` pixels.
fn plain(settings: &Settings, width: u32, height: u32) -> Settings {
    let film = Settings { width, height, crop: None, filter: ReconstructionFilter::Box, ..settings.clone() };
    Settings { hide_emitters: false, sample_weights: None, ..film.without_guide() }
}

/// Settings with which a map is learned: a picture's `settings`, without emitter sampling.
///
/// # Errors
/// [`Error::Settings`] where the sampler learns no radiance.
pub fn settings_for_map(settings: Settings) -> Result<Settings> {
    let refuse = |message: &str| Err(Error::Settings(message.into()));
    match settings.sampler {
        Sampler::Bsdf => refuse("--sampler bsdf learns nothing, so there is no map of it"),
        Sampler::Quadtree => refuse("--sampler quadtree learns flux, not radiance, so there is no map of it"),
        _ => Ok(Settings { nee: false, ..settings }),
    }
}

impl MappedScene<'_> {
    /// Radiance at `point` by direction, learned from `spp` samples per pixel in steps of the full length.
    ///
    /// # Errors
    /// Where the device cannot hold the scene or is lost.
    pub fn learned_radiance(&self, settings: &Settings, point: &SurfacePoint, spp: u32) -> Result<Vec<f32>> {
        let mut renderer = Renderer::new(self.context, self.scene, self.bvh, settings)?;
        while renderer.samples_done() < spp {
            let left = spp - renderer.samples_done();
            renderer.step(settings.spp_per_step.min(left), &|| false)?;
        }
        renderer.radiance_at(point.position)
    }

    /// Point of a surface that the center of a pixel shows.
    ///
    /// # Errors
    /// Where the pixel lies outside the film, the camera is no pinhole, or there is nothing to be seen.
    pub fn visible_point(&self, settings: &Settings, [x, y]: [u32; 2]) -> Result<SurfacePoint> {
        let refuse = |why: &str| Err(Error::Settings(format!("--pixel {x},{y}: {why}")));
        let Settings { width, height, .. } = *settings;
        if x >= width || y >= height {
            return refuse(&format!("the film has {width} x {height} pixels"));
        }
        if self.scene.camera.projection != Projection::Perspective {
            return refuse("only a `perspective` sensor shows one point at the center of a pixel");
        }
        let cut = (MAX_FILM_SIDE / width.max(height)).min(CENTER_CUT);
        let cut = if cut.is_multiple_of(2) { cut - 1 } else { cut }.max(1);
        let center = [x, y].map(|at| at * cut + cut / 2);
        let crop = Crop { x: center[0], y: center[1], width: 1, height: 1 };
        // A path goes straight on through holes to the first surface that scatters.
        let plain = plain(settings, width * cut, height * cut);
        let settings = Settings { crop: Some(crop), max_depth: MOST_SURFACES, ..plain };
        let picture = self.picture(self.scene, &settings, 1)?;
        if picture.hit_count[0] == 0 {
            return refuse("there is nothing to be seen");
        }
        let at =
            (Vec2::from(center.map(|at| at as f32)) + 0.5) / Vec2::new(settings.width as f32, settings.height as f32);
        let direction = direction_through(&self.scene.camera, at, [settings.width, settings.height]);
        let eye = self.scene.camera.world_from_camera.w_axis.truncate();
        let normal = Vec3::from(picture.normal()[0]);
        let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
        Ok(SurfacePoint { position: eye + picture.depth()[0] * direction, normal: normal.normalize_or(-direction) })
    }

    /// True radiance at `point`: the mean over each bin and over RGB. Six views around the point measure it with `spp` samples
    /// per pixel each. Bins below the surface see the inside of the object.
    ///
    /// # Errors
    /// Where the device cannot hold the scene or is lost.
    pub fn true_radiance(&self, settings: &Settings, point: &SurfacePoint, spp: u32) -> Result<Vec<f32>> {
        let side = FACE_SCALE * settings.directions;
        let offset = OFFSET * self.bvh.largest_coordinate();
        let eye = point.position + offset * point.normal;
        // Emitter sampling reduces the noise and keeps the expected value.
        let unguided = Settings { nee: true, ..plain(settings, side, side) };
        let in_view = with_all_in_view(self.scene);
        let hierarchy = in_view.as_ref().map(Bvh::of_scene);
        let place = match (&in_view, &hierarchy) {
            (Some(scene), Some(bvh)) => MappedScene { scene, bvh, ..*self },
            _ => MappedScene { ..*self },
        };
        let mut faces = Vec::new();
        for axes in FACES {
            let camera = face_camera(axes, eye, 0.01 * offset.max(1.0e-30));
            let scene = Scene { camera, camera_motion: None, ..place.scene.clone() };
            faces.push(place.picture(&scene, &unguided, spp)?);
        }
        let bins = 0..settings.directions * settings.directions;
        Ok(bins.map(|bin| bin_mean(&faces, settings, bin)).collect())
    }

    fn picture(&self, scene: &Scene, settings: &Settings, spp: u32) -> Result<Picture> {
        let mut renderer = Renderer::new(self.context, scene, self.bvh, settings)?;
        renderer.step(spp, &|| false)?;
        renderer.picture()
    }
}

/// Directions left, up and forward of the six views in world space: right-handed, like a camera's axes.
const FACES: [[Vec3; 3]; 6] = [
    [Vec3::NEG_Z, Vec3::Y, Vec3::X],
    [Vec3::Z, Vec3::Y, Vec3::NEG_X],
    [Vec3::Z, Vec3::X, Vec3::Y],
    [Vec3::X, Vec3::Z, Vec3::NEG_Y],
    [Vec3::X, Vec3::Y, Vec3::Z],
    [Vec3::NEG_X, Vec3::Y, Vec3::NEG_Z],
];

/// The scene with all shapes in view of a camera, which stands for a surface that they light; `None` where no shape hides.
fn with_all_in_view(scene: &Scene) -> Option<Scene> {
    let of_groups = scene.groups.iter().flat_map(|group| &group.primitives);
    if !scene.primitives.iter().chain(of_groups).any(|primitive| primitive.unseen) {
        return None;
    }
    let mut scene = scene.clone();
    let of_groups = scene.groups.iter_mut().flat_map(|group| &mut group.primitives);
    scene.primitives.iter_mut().chain(of_groups).for_each(|primitive| primitive.unseen = false);
    Some(scene)
}

/// Camera at `eye` that sees one face of the cube around it.
fn face_camera([left, up, forward]: [Vec3; 3], eye: Vec3, near_clip: f32) -> Camera {
    let axes = [left, up, forward].map(|axis| axis.extend(0.0));
    Camera {
        projection: Projection::Perspective,
        world_from_camera: Mat4::from_cols(axes[0], axes[1], axes[2], eye.extend(1.0)),
        fov: 90.0,
        fov_axis: FovAxis::X,
        principal_point: Vec2::ZERO,
        near_clip,
        far_clip: FAR,
    }
}

/// Unit direction from the eye through a point of the film. `at` counts widths and heights of the film from its top left
/// corner, in [0, 1]^2.
fn direction_through(camera: &Camera, at: Vec2, [width, height]: [u32; 2]) -> Vec3 {
    let on_screen = (1.0 - 2.0 * (at + camera.principal_point)) * camera.half_extent(width, height);
    camera.world_from_camera.transform_vector3(on_screen.extend(1.0)).normalize()
}

fn bin_mean(faces: &[Picture], settings: &Settings, bin: u32) -> f32 {
    let points = (0..LOOKUPS * LOOKUPS).map(|i| {
        let within = dvec2(f64::from(i % LOOKUPS), f64::from(i / LOOKUPS)) + 0.5;
        bin_point(settings.map, bin, settings.directions, within / f64::from(LOOKUPS))
    });
    points.map(|direction| look_up(faces, direction.as_vec3())).sum::<f32>() / (LOOKUPS * LOOKUPS) as f32
}

/// Mean over RGB of the radiance that the six views show in a direction.
fn look_up(faces: &[Picture], direction: Vec3) -> f32 {
    let ahead = |face: &usize| FACES[*face][2].dot(direction);
    let face = (0..FACES.len()).max_by(|a, b| ahead(a).total_cmp(&ahead(b))).unwrap_or(0);
    let ([left, up, forward], picture) = (FACES[face], &faces[face]);
    let across = Vec2::new(left.dot(direction), up.dot(direction)) / forward.dot(direction);
    let place = |across: f32, side: u32| ((0.5 - 0.5 * across) * side as f32).clamp(0.0, side as f32 - 1.0) as u32;
    let [x, y] = [place(across.x, picture.width), place(across.y, picture.height)];
    picture.radiance[(y * picture.width + x) as usize].iter().sum::<f32>() / 3.0
}

/// A map in false colors, each bin as a square of pixels. The middle of the color ramp is the mean over all bins.
pub fn false_colors(map: &[f32], side: u32) -> Image {
    let zoom = (PICTURE_SIDE / side).max(1);
    let mean = f64::from(map.iter().sum::<f32>()) / map.len() as f64;
    let pixel = |i: u32| {
        let [x, y] = [i % (zoom * side) / zoom, i / (zoom * side) / zoom];
        let value = f64::from(map[(y * side + x) as usize]);
        false_color(value / (value + mean).max(1.0e-30))
    };
    let size = zoom * side;
    Image { width: size, height: size, pixels: (0..size * size).map(pixel).collect() }
}

/// Mean absolute difference of `map` and `truth` over the bins above the surface, relative to the mean of `truth` there.
pub fn relative_error(map: &[f32], truth: &[f32], settings: &Settings, normal: Vec3) -> f64 {
    let is_above =
        |bin: &usize| bin_center(settings.map, *bin as u32, settings.directions).dot(normal.as_dvec3()) > 0.0;
    let above = || (0..truth.len()).filter(is_above);
    let difference: f64 = above().map(|bin| f64::from((map[bin] - truth[bin]).abs())).sum();
    difference / above().map(|bin| f64::from(truth[bin])).sum::<f64>().max(1.0e-30)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{FilmDescription, IntegratorDescription};
    use crate::settings::DirectionMap;

    fn settings() -> Settings {
        let film = FilmDescription { width: 8, height: 8, crop: None, filter: ReconstructionFilter::Box };
        Settings { directions: 8, ..Settings::for_film(&film, &IntegratorDescription::default()) }
    }

    #[test]
    fn faces_are_right_handed_and_look_everywhere() {
        for [left, up, forward] in FACES {
            assert_eq!(left.cross(up), forward);
        }
        assert_eq!(FACES.map(|[_, _, forward]| forward).into_iter().sum::<Vec3>(), Vec3::ZERO);
    }

    /// A face on which every pixel holds a component of the direction that a camera sees there.
    fn face(axes: [Vec3; 3], component: usize) -> Picture {
        const SIDE: u32 = 64;
        let camera = face_camera(axes, Vec3::ONE, 0.1);
        let radiance = (0..SIDE * SIDE).map(|i| {
            let at = (Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32;
            [direction_through(&camera, at, [SIDE, SIDE])[component]; 3]
        });
        Picture { radiance: radiance.collect(), ..Picture::empty(SIDE, SIDE, [0, 0], [SIDE, SIDE]) }
    }

    #[test]
    fn directions_are_looked_up_where_cameras_see_them() {
        let components = [0, 1, 2].map(|component| FACES.map(|axes| face(axes, component)));
        for map in [DirectionMap::EqualArea, DirectionMap::Cylindrical] {
            let settings = Settings { map, ..settings() };
            for bin in 0..64 {
                let seen = Vec3::from(std::array::from_fn(|axis| bin_mean(&components[axis], &settings, bin)));
                let center = bin_center(map, bin, settings.directions).as_vec3();
                assert!(seen.normalize().dot(center) > 0.97, "{map:?} {bin}: {seen} is not {center}");
            }
        }
    }

    #[test]
    fn errors_count_above_the_surface_only() {
        let settings = settings();
        let above = |bin: u32| bin_center(settings.map, bin, settings.directions).z > 0.0;
        let truth = vec![2.0; 64];
        let map: Vec<_> = (0..64).map(|bin| if above(bin) { 2.5 } else { 100.0 }).collect();
        assert!((relative_error(&map, &truth, &settings, Vec3::Z) - 0.25).abs() < 1.0e-6);
    }
}
