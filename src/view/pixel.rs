//! Everything that is known about one pixel.

use glam::Vec3;
use serde::Serialize;

use crate::film::{Picture, Unprojection};
use crate::view::guide::{GuideCells, GuideCopy, Learned};
use crate::view::shot::{Content, Shot};

/// Length of a mean normal below which the pixel shows several surfaces.
const ONE_SURFACE: f32 = 0.95;
/// Number of a pixel that shows no cell.
pub(super) const NO_CELL: u32 = u32::MAX;

/// Values of a pixel, and what the guide has learned where it shows a surface.
#[derive(Debug, Serialize)]
pub(super) struct PixelFacts {
    pub x: u32,
    pub y: u32,
    /// Layers with the names of their channels and their values. A value that is not finite is `null`.
    pub layers: Vec<(String, Vec<String>, Vec<Option<f32>>)>,
    pub surface: Option<Surface>,
    pub learned: Option<Learned>,
}

/// Surface that a pixel shows.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Surface {
    pub position: [f32; 3],
    /// Unit normal, on the side that the camera sees.
    pub normal: [f32; 3],
    /// Directions to the right and up on the surface, as they appear in the picture.
    pub right: [f32; 3],
    pub up: [f32; 3],
    /// Whether the pixel shows several surfaces, so that the position is a mean.
    pub is_mixed: bool,
}

impl PixelFacts {
    /// Facts about the pixel in column `x` and row `y` of `shot`; `None` outside the picture.
    pub fn new(shot: &Shot, [x, y]: [u32; 2], guide: Option<(&GuideCells, &GuideCopy)>) -> Option<Self> {
        let [width, height] = shot.size();
        if x >= width || y >= height {
            return None;
        }
        let at = (y * width + x) as usize;
        let layer = |name: String| {
            let plane = shot.part(&name, at..at + 1)?;
            let values = plane.values.iter().map(|&value| value.is_finite().then_some(value)).collect();
            Some((name, plane.channels, values))
        };
        let layers = shot.offered_layers().into_iter().filter_map(layer).collect();
        let surface = match &shot.content {
            Content::Rendered(picture) => surface(picture, at),
            Content::Read(_) => None,
        };
        let learned = surface
            .zip(guide)
            .map(|(surface, (cells, copy))| cells.learned(copy, surface.position.into(), surface.normal.into()));
        Some(Self { x, y, layers, surface, learned })
    }
}

/// Surface that pixel `at` shows, if it shows one.
fn surface(picture: &Picture, at: usize) -> Option<Surface> {
    let (view, depth) = (picture.view?, picture.depth()[at]);
    let unprojection = view.unprojection();
    let position = position(picture, &unprojection, at)?;
    let eye = unprojection.point_at(film_place(picture, at), 0.0);
    let toward_eye = (eye - position).normalize_or(Vec3::Z);
    // A pixel that hits in part has a shorter mean normal.
    let hits = picture.hit_count[at] as f32 / picture.sample_count[at].max(1) as f32;
    let mean = Vec3::from(picture.normal()[at]) / hits.max(1.0e-6);
    let normal = mean.normalize_or(toward_eye);
    let normal = if normal.dot(toward_eye) < 0.0 { -normal } else { normal };
    let [right, up] = view.axes();
    let tangent = |axis: Vec3| (axis - axis.dot(normal) * normal).try_normalize();
    let right = tangent(right).or_else(|| tangent(up)).unwrap_or_else(|| normal.any_orthonormal_vector());
    let is_mixed = mean.length() < ONE_SURFACE || hits < 1.0 || !depth.is_finite();
    let up = normal.cross(right);
    Some(Surface { position: position.into(), normal: normal.into(), right: right.into(), up: up.into(), is_mixed })
}

/// Position that pixel `at` shows, if it shows a surface.
fn position(picture: &Picture, unprojection: &Unprojection, at: usize) -> Option<Vec3> {
    let depth = picture.depth()[at];
    let is_hit = picture.hit_count[at] > 0 && depth.is_finite();
    is_hit.then(|| unprojection.point_at(film_place(picture, at), depth)).filter(|position| position.is_finite())
}

/// Center of pixel `at`, in widths and heights of the whole film.
fn film_place(picture: &Picture, at: usize) -> [f64; 2] {
    let width = picture.width as usize;
    let place = [at % width, at / width];
    std::array::from_fn(|axis| {
        (place[axis] as f64 + 0.5 + f64::from(picture.offset[axis])) / f64::from(picture.full_size[axis])
    })
}

/// Cell that every pixel shows, as four bytes; [`NO_CELL`] where it shows none.
pub(super) fn cells_of_pixels(picture: &Picture, cells: &GuideCells) -> Vec<u32> {
    let Some(view) = picture.view else { return vec![NO_CELL; picture.depth().len()] };
    let unprojection = view.unprojection();
    let cell = |at: usize| position(picture, &unprojection, at).map_or(NO_CELL, |at| cells.cells.cell_of(at) as u32);
    (0..picture.depth().len()).map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::View;
    use crate::film::features::{DEPTH, NORMAL};
    use crate::scene::Camera;

    /// Picture of the plane z = 0 from a distance of 5. The film is a window of a larger one.
    fn picture(normal: [f32; 3]) -> Picture {
        let camera = Camera::look_at([0.0, 0.0, 5.0], [0.0, 0.0, 0.0], 40.0);
        let mut picture = Picture { view: View::new(&camera, 9, 9), ..Picture::empty(3, 3, [3, 3], [9, 9]) };
        (picture.sample_count, picture.hit_count) = (vec![4; 9], vec![4; 9]);
        (picture.features[NORMAL], picture.features[DEPTH]) = ([normal; 9].as_flattened().to_vec(), vec![5.0; 9]);
        picture
    }

    #[test]
    fn the_surface_of_a_pixel_is_seen_as_in_the_picture() {
        for normal in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] {
            let surface = surface(&picture(normal), 4).unwrap();
            assert!(Vec3::from(surface.position).length() < 1.0e-4, "{surface:?}");
            let axes = [surface.right, surface.up, surface.normal].map(Vec3::from);
            for (axis, expected) in axes.into_iter().zip([Vec3::X, Vec3::Y, Vec3::Z]) {
                assert!(axis.distance(expected) < 1.0e-4, "{surface:?}");
            }
            assert!(!surface.is_mixed);
        }
        let [left, above] = [3, 1].map(|at| Vec3::from(surface(&picture([0.0, 0.0, 1.0]), at).unwrap().position));
        assert!(left.x < -0.1 && above.y > 0.1, "{left} {above}");
    }

    #[test]
    fn pixels_of_several_surfaces_and_of_none_are_told() {
        assert!(surface(&picture([0.0, 0.5, 0.5]), 4).unwrap().is_mixed);
        let mut half = picture([0.0, 0.0, 0.5]);
        half.hit_count = vec![2; 9];
        assert!(surface(&half, 4).unwrap().is_mixed);
        half.hit_count = vec![0; 9];
        assert!(surface(&half, 4).is_none());
        let empty = Picture { view: None, ..picture([0.0, 0.0, 1.0]) };
        assert!(surface(&empty, 4).is_none());
    }
}
