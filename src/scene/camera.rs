//! Camera of a scene, and its projections.

use glam::{Mat4, Vec2};

/// Camera of a scene.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Camera {
    /// Kind of projection.
    pub projection: Projection,
    /// Transform from camera space (x left, y up, z forward) to the world. A rigid motion unless the projection is
    /// orthographic.
    pub world_from_camera: Mat4,
    /// Field of view in degrees, in (0, 180), along `fov_axis`. Unused by an orthographic projection.
    pub fov: f32,
    /// Axis that `fov` spans.
    pub fov_axis: FovAxis,
    /// Offset of the principal point, in picture widths and heights: the pixel at `(x, y)`, from the top left corner in
    /// the same units, looks along `((1 - 2 (x + offset.x)) tan_x, (1 - 2 (y + offset.y)) tan_y, 1)` in camera space.
    pub principal_point: Vec2,
    /// Distance of the near plane, > 0, scene units.
    pub near_clip: f32,
    /// Distance of the far plane, > near, scene units.
    pub far_clip: f32,
}

/// Projections of a camera.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum Projection {
    /// Perspective: all rays go through one point.
    Perspective,
    /// Thin lens: all rays go through a disk around the origin of camera space. The plane at depth `focus_distance` is
    /// sharp.
    ThinLens {
        /// Radius of the lens, > 0, scene units.
        aperture_radius: f32,
        /// Depth of the plane in focus, > 0, scene units.
        focus_distance: f32,
    },
    /// Orthographic: all rays are parallel to camera space's z axis. The picture's width spans x from -1 to 1 there.
    Orthographic,
}

/// Mitsuba's `fov_axis`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum FovAxis {
    /// Horizontal (Mitsuba's default).
    X,
    /// Vertical.
    Y,
    /// The picture's diagonal.
    Diagonal,
    /// The shorter side.
    Smaller,
    /// The longer side.
    Larger,
}

impl Camera {
    /// Half the width and height, in camera units, of the part of the plane at depth 1 that a picture of `width` x
    /// `height` pixels shows.
    pub fn half_extent(&self, width: u32, height: u32) -> Vec2 {
        let half_width = match self.projection {
            Projection::Orthographic => 1.0,
            _ => self.tan_half_fov_x(width, height),
        };
        Vec2::new(half_width, half_width * height as f32 / width as f32)
    }

    /// Tangent of half the *horizontal* field of view for a picture of `width` x `height` pixels.
    pub fn tan_half_fov_x(&self, width: u32, height: u32) -> f32 {
        self.fov_axis.tan_half_fov_x(self.fov, width, height)
    }
}

impl FovAxis {
    /// Tangent of half the *horizontal* field of view for a picture of `width` x `height` pixels that spans `fov` degrees along
    /// this axis.
    pub fn tan_half_fov_x(self, fov: f32, width: u32, height: u32) -> f32 {
        let (width, height) = (width as f32, height as f32);
        let tan_half = (0.5 * fov.to_radians()).tan();
        let vertical = tan_half * width / height;
        match self {
            Self::X => tan_half,
            Self::Y => vertical,
            Self::Diagonal => tan_half * width / width.hypot(height),
            Self::Smaller => {
                if width < height {
                    tan_half
                } else {
                    vertical
                }
            }
            Self::Larger => {
                if width > height {
                    tan_half
                } else {
                    vertical
                }
            }
        }
    }
}
