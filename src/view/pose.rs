//! Place and lens of a camera as a page names them, and as XML.

use std::fmt::Write as _;

use glam::{Mat4, Vec3, Vec4};
use serde::Serialize;

use crate::scene::{Camera, FovAxis, Projection};

/// Least length of a direction, and least sine of the angle between two, that make axes of a camera.
const LEAST_LENGTH: f32 = 1.0e-6;
/// Most of a number on the wire. Cameras beyond see nothing but rounding.
const MOST: f32 = 1.0e12;

/// A camera of the scene, moved and turned, perhaps with another lens.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Pose {
    /// Index of the scene's camera that decides all that is not said here.
    pub camera: u32,
    /// Position, world space.
    pub eye: [f32; 3],
    /// Direction of view, and a direction that is up in the picture, world space.
    pub forward: [f32; 3],
    pub up: [f32; 3],
    /// Radius of the lens, scene units; 0 for a pinhole.
    pub aperture: f32,
    /// Depth of the plane in focus, scene units.
    pub focus: f32,
    /// Size of an orthographic camera's view, as a multiple of its own.
    pub scale: f32,
}

impl Pose {
    /// Pose of a camera of the scene as it is.
    pub fn of(index: u32, camera: &Camera, focus: f32) -> Self {
        let [_, up, forward, eye] = columns(&camera.world_from_camera);
        let (aperture, focus) = match camera.projection {
            Projection::ThinLens { aperture_radius, focus_distance } => (aperture_radius, focus_distance),
            _ => (0.0, focus),
        };
        let (forward, up) = (forward.normalize_or(Vec3::Z), up.normalize_or(Vec3::Y));
        Self { camera: index, eye: eye.into(), forward: forward.into(), up: up.into(), aperture, focus, scale: 1.0 }
    }

    /// Pose in a request's query; the sentence says what is wrong with it.
    pub fn read<'a>(value: impl Fn(&str) -> Option<&'a str>) -> Result<Self, String> {
        let vector = |name: &str| -> Result<[f32; 3], String> {
            let wrong = || format!("{name} has three numbers with commas between them.");
            let numbers: Vec<f32> = value(name).ok_or_else(wrong)?.split(',').take(4).map_while(number).collect();
            numbers.try_into().map_err(|_| wrong())
        };
        let scalar = |name: &str| value(name).and_then(number).ok_or_else(|| format!("{name} is a number."));
        Ok(Self {
            camera: value("camera").and_then(|text| text.parse().ok()).ok_or("camera is the number of a camera.")?,
            eye: vector("eye")?,
            forward: vector("forward")?,
            up: vector("up")?,
            aperture: scalar("aperture")?,
            focus: scalar("focus")?,
            scale: scalar("scale")?,
        })
    }

    /// The camera among `cameras`; the sentence says why there is none.
    pub fn camera(&self, cameras: &[Camera]) -> Result<Camera, String> {
        let own = cameras.get(self.camera as usize).ok_or("The scene has no such camera.")?;
        let [eye, forward, up] = [self.eye, self.forward, self.up].map(Vec3::from);
        let axes = || {
            let forward = (forward.length() > LEAST_LENGTH).then(|| forward.normalize())?;
            let left = up.normalize_or_zero().cross(forward);
            let left = (left.length() > LEAST_LENGTH).then(|| left.normalize())?;
            Some([left, forward.cross(left), forward])
        };
        let axes = axes().ok_or("The directions forward and up make no axes of a camera.")?;
        let (axes, projection) = match own.projection {
            Projection::Orthographic if self.scale > 0.0 => {
                let [x, y, z, _] = columns(&own.world_from_camera).map(Vec3::length);
                let sizes = [x * self.scale, y * self.scale, z];
                // A mirror stays a mirror.
                let sign = own.world_from_camera.determinant().signum();
                ([axes[0] * sizes[0] * sign, axes[1] * sizes[1], axes[2] * sizes[2]], Projection::Orthographic)
            }
            Projection::Orthographic => return Err("The scale is above 0.".into()),
            panorama if panorama.is_panorama() => (axes, panorama),
            _ => {
                let (aperture_radius, focus_distance) = (self.aperture, self.focus);
                (axes, Projection::ThinLens { aperture_radius, focus_distance })
            }
        };
        let [x, y, z] = axes.map(|axis| axis.extend(0.0));
        let camera = Camera { projection, world_from_camera: Mat4::from_cols(x, y, z, eye.extend(1.0)), ..*own };
        camera.check().map(|()| camera).map_err(|error| error.to_string())
    }
}

/// A finite number that is not huge.
fn number(text: &str) -> Option<f32> {
    text.parse().ok().filter(|number: &f32| number.abs() <= MOST)
}

fn columns(matrix: &Mat4) -> [Vec3; 4] {
    [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis].map(Vec4::truncate)
}

/// Sensor of a camera in Mitsuba's XML, with a film of this size. The scene's file takes it in place of its own.
pub(super) fn xml(camera: &Camera, [width, height]: [u32; 2]) -> String {
    let mut text = String::new();
    let plugin = match camera.projection {
        Projection::Orthographic => "orthographic",
        Projection::ThinLens { aperture_radius, .. } if aperture_radius > 0.0 => "thinlens",
        Projection::Perspective | Projection::ThinLens { .. } => "perspective",
        Projection::Equirectangular { .. } | Projection::EqualArea => "spherical",
    };
    let has_angle = camera.projection != Projection::Orthographic && !camera.projection.is_panorama();
    // Writing into a text cannot fail.
    let _ = writeln!(text, "<sensor type=\"{plugin}\">");
    let mut float = |name: &str, value: f32| {
        let _ = writeln!(text, "    <float name=\"{name}\" value=\"{value}\"/>");
    };
    if has_angle {
        float("fov", camera.fov);
    }
    if let Projection::Equirectangular { longitude, latitude } = camera.projection {
        for (name, [min, max]) in [("longitude", longitude), ("latitude", latitude)] {
            float(&format!("{name}_min"), min);
            float(&format!("{name}_max"), max);
        }
    }
    if let ("thinlens", Projection::ThinLens { aperture_radius, focus_distance }) = (plugin, camera.projection) {
        float("aperture_radius", aperture_radius);
        float("focus_distance", focus_distance);
    }
    if has_angle {
        float("principal_point_offset_x", camera.principal_point.x);
        float("principal_point_offset_y", camera.principal_point.y);
    }
    float("near_clip", camera.near_clip);
    float("far_clip", camera.far_clip);
    if has_angle {
        let axis = match camera.fov_axis {
            FovAxis::X => "x",
            FovAxis::Y => "y",
            FovAxis::Diagonal => "diagonal",
            FovAxis::Smaller => "smaller",
            FovAxis::Larger => "larger",
        };
        let _ = writeln!(text, "    <string name=\"fov_axis\" value=\"{axis}\"/>");
    }
    if camera.projection == Projection::EqualArea {
        let _ = writeln!(text, "    <string name=\"mapping\" value=\"equal_area\"/>");
    }
    let rows = camera.world_from_camera.transpose().to_cols_array().map(|value| value.to_string()).join(" ");
    let _ = writeln!(text, "    <transform name=\"to_world\">\n        <matrix value=\"{rows}\"/>\n    </transform>");
    let _ = writeln!(text, "    <film type=\"hdrfilm\">");
    for (name, value) in [("width", width), ("height", height)] {
        let _ = writeln!(text, "        <integer name=\"{name}\" value=\"{value}\"/>");
    }
    text + "    </film>\n</sensor>\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn cameras() -> [Camera; 2] {
        let camera = Camera::look_at([1.0, 2.0, 6.0], [0.5, 0.0, -1.0], 45.0);
        let wide = Mat4::from_scale(Vec3::new(3.0, 3.0, 1.0));
        let world_from_camera = camera.world_from_camera * wide;
        let parallel = Camera { projection: Projection::Orthographic, world_from_camera, ..camera };
        [Camera { fov_axis: FovAxis::Y, near_clip: 0.5, ..camera }, parallel]
    }

    fn read(query: &str) -> Result<Pose, String> {
        Pose::read(|name| {
            query
                .split('&')
                .find_map(|pair| pair.split_once('=').filter(|(found, _)| *found == name))
                .map(|(_, value)| value)
        })
    }

    const GOOD: &str = "camera=0&eye=1,2,3&forward=0,0,-1&up=0,1,0&aperture=0&focus=4&scale=1";

    #[test]
    fn a_pose_is_the_camera_that_it_comes_from() {
        let cameras = cameras();
        for (index, camera) in (0..).zip(&cameras) {
            let pose = Pose::of(index, camera, 7.0);
            let made = pose.camera(&cameras).unwrap();
            assert!(made.world_from_camera.abs_diff_eq(camera.world_from_camera, 1.0e-5), "{made:?}");
            assert_eq!((made.fov, made.fov_axis, made.near_clip), (camera.fov, camera.fov_axis, camera.near_clip));
        }
        let lens = Pose { aperture: 0.25, ..Pose::of(0, &cameras[0], 7.0) };
        let projection = Projection::ThinLens { aperture_radius: 0.25, focus_distance: 7.0 };
        assert_eq!(lens.camera(&cameras).unwrap().projection, projection);
        let twice = Pose { scale: 2.0, ..Pose::of(1, &cameras[1], 7.0) };
        assert!((twice.camera(&cameras).unwrap().world_from_camera.x_axis.length() - 6.0).abs() < 1.0e-4);
    }

    #[test]
    fn wrong_poses_are_refused_in_a_sentence() {
        let cameras = cameras();
        assert_eq!(read(GOOD).unwrap().eye, [1.0, 2.0, 3.0]);
        for (from, to) in [
            ("eye=1,2,3", "eye=1,2"),
            ("eye=1,2,3", "eye=1,2,3,4"),
            ("eye=1,2,3", "eye=1,2,nan"),
            ("eye=1,2,3", "eye=1,2,1e30"),
            ("eye=1,2,3&", ""),
            ("camera=0", "camera=-1"),
            ("camera=0", "camera=2"),
            ("forward=0,0,-1", "forward=0,0,0"),
            ("up=0,1,0", "up=0,0,2"),
            ("aperture=0", "aperture=-1"),
            ("aperture=0", "aperture=inf"),
            ("focus=4", "focus=0"),
            ("focus=4", "focus=x"),
        ] {
            let query = GOOD.replace(from, to);
            let refusal = read(&query).and_then(|pose| pose.camera(&cameras)).err();
            assert!(refusal.is_some_and(|sentence| sentence.ends_with('.') || sentence.contains(' ')), "{query}");
        }
    }

    /// The XML that the page copies is the camera, in the reader's words.
    #[test]
    fn xml_is_read_as_the_camera() {
        let cameras = cameras();
        let lens = Pose { aperture: 0.25, ..Pose::of(0, &cameras[0], 7.0) }.camera(&cameras).unwrap();
        let folder = tempfile::tempdir().unwrap();
        for camera in [cameras[0], lens, cameras[1]] {
            let path = folder.path().join("scene.xml");
            std::fs::write(&path, format!("<scene version=\"3.0.0\">{}</scene>", xml(&camera, [64, 48]))).unwrap();
            let scene = Scene::load(&path).unwrap();
            assert!(scene.camera.world_from_camera.abs_diff_eq(camera.world_from_camera, 1.0e-5));
            assert_eq!((scene.film.width, scene.film.height), (64, 48));
            assert_eq!((scene.camera.projection, scene.camera.near_clip), (camera.projection, camera.near_clip));
            if camera.projection != Projection::Orthographic {
                assert_eq!((scene.camera.fov, scene.camera.fov_axis), (camera.fov, camera.fov_axis));
            }
        }
    }
}
