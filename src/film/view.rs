//! Matrices of a picture's camera, as viewers and compositors use them.

use glam::{DMat4, DVec3, Mat4, Vec3, Vec4};

use crate::scene::{Camera, Projection};

/// Matrices from the world to a picture's camera and to its film. They multiply column vectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Matrix to camera space as OpenEXR has it: x to the right, y up, z forward.
    pub camera_from_world: Mat4,
    /// Matrix to the film, in film widths and heights from its top left corner, after division by w. Depth is 0 at the near
    /// plane and 1 at the far plane.
    pub film_from_world: Mat4,
}

impl View {
    /// View of `camera` on a film of `width` x `height` pixels. A thin lens is seen through its center. A panorama has none.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Option<Self> {
        let own_from_world = camera.world_from_camera.inverse();
        // Lodestar's x points to the left, OpenEXR's to the right.
        let mirror = Mat4::from_diagonal(Vec4::new(-1.0, 1.0, 1.0, 1.0));
        Some(Self {
            camera_from_world: mirror * own_from_world,
            film_from_world: film_from_own(camera, width, height)? * own_from_world,
        })
    }

    /// The way back from the film to the world.
    pub fn unprojection(&self) -> Unprojection {
        let camera_from_world = self.camera_from_world.as_dmat4();
        Unprojection {
            world_from_film: self.film_from_world.as_dmat4().inverse(),
            is_parallel: self.film_from_world.row(3) == Vec4::W,
            camera_from_world,
            world_from_camera: camera_from_world.inverse(),
        }
    }

    /// Directions to the right and up in the picture, in world space.
    pub fn axes(&self) -> [Vec3; 2] {
        [Vec3::X, Vec3::Y].map(|axis| self.camera_from_world.inverse().transform_vector3(axis).normalize_or_zero())
    }
}

/// The way back from places on the film to points of the world.
#[derive(Debug, Clone, Copy)]
pub struct Unprojection {
    world_from_film: DMat4,
    camera_from_world: DMat4,
    world_from_camera: DMat4,
    is_parallel: bool,
}

impl Unprojection {
    /// Point of the world that lies `depth` scene units from the camera and is seen at the place `film`, in film widths and heights
    /// from the top left corner.
    pub fn point_at(&self, film: [f64; 2], depth: f32) -> Vec3 {
        let on_near_plane = self.world_from_film.project_point3(DVec3::new(film[0], film[1], 0.0));
        let (origin, direction) = if self.is_parallel {
            let distance = self.camera_from_world.transform_point3(on_near_plane).z;
            let forward = self.world_from_camera.transform_vector3(DVec3::Z).normalize();
            (on_near_plane - distance * forward, forward)
        } else {
            let eye = self.world_from_camera.transform_point3(DVec3::ZERO);
            (eye, (on_near_plane - eye).normalize())
        };
        (origin + f64::from(depth) * direction).as_vec3()
    }
}

/// Matrix to the film from the camera's own space, whose x points to the left; `None` for a panorama.
fn film_from_own(camera: &Camera, width: u32, height: u32) -> Option<Mat4> {
    let scale = -0.5 / camera.half_extent(width, height);
    let center = 0.5 - camera.principal_point;
    let (near, range) = (camera.near_clip, camera.far_clip - camera.near_clip);
    let rows = match camera.projection {
        Projection::Orthographic => [
            Vec4::new(scale.x, 0.0, 0.0, center.x),
            Vec4::new(0.0, scale.y, 0.0, center.y),
            Vec4::new(0.0, 0.0, 1.0 / range, -near / range),
            Vec4::W,
        ],
        Projection::Perspective | Projection::ThinLens { .. } => [
            Vec4::new(scale.x, 0.0, center.x, 0.0),
            Vec4::new(0.0, scale.y, center.y, 0.0),
            Vec4::new(0.0, 0.0, camera.far_clip / range, -camera.far_clip * near / range),
            Vec4::Z,
        ],
        Projection::Equirectangular { .. } | Projection::EqualArea => return None,
    };
    let [x, y, z, w] = rows;
    Some(Mat4::from_cols(x, y, z, w).transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    const SIZE: [u32; 2] = [40, 30];

    fn camera(projection: Projection) -> Camera {
        let camera = Camera::look_at([1.0, 2.0, 6.0], [0.5, 0.0, -1.0], 45.0);
        Camera { projection, principal_point: Vec2::new(0.1, -0.05), near_clip: 0.5, far_clip: 50.0, ..camera }
    }

    /// Place on the film of a point, in pixels, by the formula of `camera_ray` in `camera.glsl` solved for the position.
    fn pixel_by_formula(camera: &Camera, point: Vec3) -> Vec2 {
        let own = camera.world_from_camera.inverse().transform_point3(point);
        let half = camera.half_extent(SIZE[0], SIZE[1]);
        let depth = if camera.projection == Projection::Orthographic { 1.0 } else { own.z };
        let screen = own.truncate() / depth / half;
        ((1.0 - screen) / 2.0 - camera.principal_point) * Vec2::new(SIZE[0] as f32, SIZE[1] as f32)
    }

    #[test]
    fn points_fall_on_their_pixels() {
        let lens = Projection::ThinLens { aperture_radius: 0.1, focus_distance: 4.0 };
        for projection in [Projection::Perspective, lens, Projection::Orthographic] {
            let camera = camera(projection);
            let view = View::new(&camera, SIZE[0], SIZE[1]).expect("a view");
            for point in [Vec3::ZERO, Vec3::new(1.5, -0.5, 2.0), Vec3::new(-1.0, 1.0, -3.0)] {
                let film = view.film_from_world.project_point3(point).truncate();
                let pixel = film * Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
                assert!(pixel.distance(pixel_by_formula(&camera, point)) < 1.0e-3, "{projection:?}: {pixel}");
            }
        }
    }

    #[test]
    fn pixels_lead_back_to_their_points() {
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let camera = camera(projection);
            let view = View::new(&camera, SIZE[0], SIZE[1]).expect("a view");
            for point in [Vec3::ZERO, Vec3::new(1.5, -0.5, 2.0), Vec3::new(-1.0, 1.0, -3.0)] {
                let film = view.film_from_world.project_point3(point);
                let own = camera.world_from_camera.inverse().transform_point3(point);
                let depth = if projection == Projection::Orthographic { own.z } else { own.length() };
                let back = view.unprojection().point_at([film.x.into(), film.y.into()], depth);
                assert!(back.distance(point) < 1.0e-3, "{projection:?}: {back} is not {point}");
            }
        }
    }

    #[test]
    fn the_camera_looks_along_z_with_x_to_the_right() {
        let camera = Camera { principal_point: Vec2::ZERO, ..camera(Projection::Perspective) };
        let view = View::new(&camera, SIZE[0], SIZE[1]).expect("a view");
        let world_from_camera = view.camera_from_world.inverse();
        let film = |x: f32, y: f32, z: f32| {
            view.film_from_world.project_point3(world_from_camera.transform_point3(Vec3::new(x, y, z)))
        };
        assert!((film(0.0, 0.0, 3.0).truncate() - 0.5).length() < 1.0e-5, "the axis meets the center");
        assert!(film(0.2, 0.0, 3.0).x > 0.51, "x is to the right");
        assert!(film(0.0, 0.2, 3.0).y < 0.49, "y is up");
        assert!(film(0.0, 0.0, 0.5).z.abs() < 1.0e-5 && (film(0.0, 0.0, 50.0).z - 1.0).abs() < 1.0e-4, "the planes");
    }
}
