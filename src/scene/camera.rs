//! Camera of a scene, and its projections.

use glam::{Mat4, Vec2, Vec3, Vec4};

use crate::{Error, Result};

/// Most by which squared lengths and cosines of a rigid camera's axes differ from 1 and 0. Scene files are printed with six digits.
const MOST_SCALE: f32 = 4.0e-3;

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
        /// Radius of the lens, scene units; 0 makes a pinhole.
        aperture_radius: f32,
        /// Depth of the plane in focus, > 0, scene units.
        focus_distance: f32,
    },
    /// Orthographic: all rays are parallel to camera space's z axis. The picture's width spans x from -1 to 1 there.
    Orthographic,
    /// Panorama whose rows and columns are latitudes and longitudes.
    Equirectangular {
        /// Longitudes of the picture's left and right side in degrees; 0 is forward, and 90 to the right.
        longitude: [f32; 2],
        /// Latitudes of its lower and upper side in degrees; 90 is up.
        latitude: [f32; 2],
    },
    /// Panorama by pbrt's equal-area map (Clarberg 2008): a square whose middle is up, and whose corners are down.
    EqualArea,
}

impl Projection {
    /// Whether the camera sees all around, so that no matrix leads to its picture.
    pub fn is_panorama(self) -> bool {
        matches!(self, Self::Equirectangular { .. } | Self::EqualArea)
    }
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
    /// Place of the camera, world space.
    pub(crate) fn eye(&self) -> Vec3 {
        self.world_from_camera.w_axis.truncate()
    }

    /// Half the width and height, in camera units, of the part of the plane at depth 1 that a picture of `width` x
    /// `height` pixels shows.
    pub fn half_extent(&self, width: u32, height: u32) -> Vec2 {
        let half_width = match self.projection {
            Projection::Orthographic => 1.0,
            _ => self.tan_half_fov_x(width, height),
        };
        Vec2::new(half_width, half_width * height as f32 / width as f32)
    }

    /// Refuses a camera that shows no picture.
    pub(crate) fn check(&self) -> Result<()> {
        let refuse = |message: &str| Err(Error::Settings(message.into()));
        let Self { fov, world_from_camera, principal_point, near_clip, far_clip, .. } = *self;
        let numbers = [fov, principal_point.x, principal_point.y, near_clip, far_clip];
        if !world_from_camera.is_finite() || !numbers.iter().all(|number| number.is_finite()) {
            return refuse("the camera has a number that is not finite; give it finite ones");
        }
        if !(near_clip > 0.0 && far_clip > near_clip) {
            return refuse("the camera's near plane must lie before it, and the far plane behind the near one");
        }
        let [x, y, z] = [world_from_camera.x_axis, world_from_camera.y_axis, world_from_camera.z_axis];
        if self.projection == Projection::Orthographic {
            let sees = z.length_squared() >= f32::MIN_POSITIVE;
            return if sees {
                Ok(())
            } else {
                refuse("the camera's transform shrinks its viewing direction to length 0")
            };
        }
        if !(fov > 0.0 && fov < 180.0) {
            return refuse(&format!("the camera's field of view is {fov} degrees, but must lie between 0 and 180"));
        }
        let is_unit = |axis: Vec4| (axis.length_squared() - 1.0).abs() < MOST_SCALE;
        let are_apart = [x.dot(y), y.dot(z), z.dot(x)].iter().all(|cosine| cosine.abs() < MOST_SCALE);
        if !([x, y, z].into_iter().all(is_unit) && are_apart) {
            return refuse("the camera's transform must neither scale nor shear");
        }
        match self.projection {
            Projection::Equirectangular { longitude: [left, right], latitude: [bottom, top] } => {
                let spans = (right - left).abs() > 0.0 && (right - left).abs() <= 360.0 && left.abs() <= 720.0;
                let is_up = -90.0 <= bottom && bottom < top && top <= 90.0;
                let message = "the camera's longitudes must span up to 360 degrees, and its latitudes grow from -90 to 90 at most";
                if spans && is_up { Ok(()) } else { refuse(message) }
            }
            Projection::ThinLens { aperture_radius: radius, focus_distance: focus }
                if !(radius >= 0.0 && radius.is_finite() && focus > 0.0 && focus.is_finite()) =>
            {
                refuse("the camera's lens must have a radius that is not negative, and focus at a distance above 0")
            }
            _ => Ok(()),
        }
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
