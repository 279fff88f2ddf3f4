//! Camera rays of `glsl/include/film/camera.glsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Mat4, Vec2, Vec3, Vec4, Vec4Swizzles, dvec2, dvec3, vec2, vec3, vec4};
use lodestar::generated::kernels::{
    CAMERA_EQUAL_AREA, CAMERA_EQUIRECTANGULAR, CAMERA_ORTHOGRAPHIC, CAMERA_PERSPECTIVE, CAMERA_THINLENS, Variant, test,
};
use lodestar::generated::layout::SceneConstants;
use lodestar::gpu::BufferKind;
use support::device::{Device, GROUP};
use support::twins::camera::camera_ray;
use support::twins::intersect::Ray;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct CameraRay {
    origin: [f32; 3],
    direction: [f32; 3],
    t_max: f32,
}

const FILM: Vec2 = vec2(640.0, 400.0);

fn scene() -> SceneConstants {
    let (eye, forward) = (vec3(3.0, -2.0, 5.0), vec3(-2.5, 2.7, -6.0).normalize());
    let left = Vec3::Y.cross(forward).normalize();
    let matrix =
        Mat4::from_cols(left.extend(0.0), forward.cross(left).extend(0.0), forward.extend(0.0), eye.extend(1.0));
    SceneConstants {
        world_from_camera: [0, 1, 2].map(|row| matrix.row(row).into()),
        film_size: FILM.into(),
        raster_scale: [0.7, 0.7 * FILM.y / FILM.x],
        principal_point: [0.05, -0.1],
        near_clip: 0.5,
        far_clip: 100.0,
        aperture_radius: 0.3,
        focus_distance: 4.0,
        ..SceneConstants::zeroed()
    }
}

/// Fails unless the device's rays with the variant `camera` agree with the twin, and disagree with the twin at slightly
/// other positions.
fn rays_are_those_of_the_twin(camera: u32) {
    let (device, scene) = (Device::new(), scene());
    let at = |i: u32| {
        let position = vec2((i % 64) as f32 / 63.0, (i / 64) as f32 / 63.0) * FILM;
        position.extend((i * 7 % 64) as f32 / 63.0).extend((i * 29 % 4096) as f32 / 4095.0)
    };
    let positions: Vec<Vec4> = (0..64 * 64).map(at).collect();
    let constants = device.buffer("scene", size_of::<SceneConstants>(), BufferKind::Uniform);
    constants.upload(0, &[scene]).expect("uploaded");
    let input = device.uploaded("positions", &positions);
    let output = device.storage("rays", positions.len() * size_of::<CameraRay>());
    let kernel = device.kernel(&test::CAMERA, &Variant { camera, ..Variant::default() });
    device.dispatch(&kernel, &[&constants, &input, &output], &[], positions.len() as u32 / GROUP);
    let rays: Vec<CameraRay> = output.read(0, positions.len()).expect("read");
    let error = |ray: &CameraRay, position: Vec4| {
        let twin = camera_ray(camera, &scene, position.xy().as_dvec2(), position.zw().as_dvec2());
        let origin = (Vec3::from(ray.origin).as_dvec3() - twin.origin).length();
        let direction = (Vec3::from(ray.direction).as_dvec3() - twin.direction).length();
        origin.max(direction).max((f64::from(ray.t_max) / twin.t_max - 1.0).abs())
    };
    // A point on the lens needs a longer calculation, so its error is larger.
    let tolerance = if camera == CAMERA_THINLENS { 6.0e-6 } else { 2.0e-6 };
    for (ray, &position) in rays.iter().zip(&positions) {
        assert!(error(ray, position) < tolerance, "{position}: {ray:?}, off by {}", error(ray, position));
        let beside = position + vec4(0.01, 0.01, 0.0, 0.0);
        assert!(error(ray, beside) > tolerance, "{position}: a hundredth of a pixel off");
    }
}

#[test]
fn perspective() {
    rays_are_those_of_the_twin(CAMERA_PERSPECTIVE);
    // The center of projection lies at the principal point.
    let scene = scene();
    let center = (0.5 - Vec2::from(scene.principal_point)) * FILM;
    let center = camera_ray(CAMERA_PERSPECTIVE, &scene, center.as_dvec2(), DVec2::ZERO);
    assert!((center.direction - vec3(-2.5, 2.7, -6.0).normalize().as_dvec3()).length() < 1.0e-6);
}

#[test]
fn thin_lens() {
    rays_are_those_of_the_twin(CAMERA_THINLENS);
}

#[test]
fn orthographic() {
    rays_are_those_of_the_twin(CAMERA_ORTHOGRAPHIC);
}

#[test]
fn panoramas() {
    rays_are_those_of_the_twin(CAMERA_EQUIRECTANGULAR);
    rays_are_those_of_the_twin(CAMERA_EQUAL_AREA);
}

fn of_mitsuba(near_clip: f32, far_clip: f32, world_from_camera: Mat4, raster_scale: [f32; 2]) -> SceneConstants {
    SceneConstants {
        world_from_camera: [0, 1, 2].map(|row| world_from_camera.row(row).into()),
        film_size: [200.0, 100.0],
        raster_scale,
        near_clip,
        far_clip,
        aperture_radius: 0.1,
        focus_distance: 5.0,
        ..SceneConstants::zeroed()
    }
}

/// Camera rays agree with `sample_ray` of Mitsuba 3.9, for a film of 200 x 100 at (0.25, 0.75) and the lens at (0.9,
/// 0.3).
#[test]
fn rays_are_mitsubas() {
    let tangent = 30.0_f32.to_radians().tan();
    let ray = |camera, scene: &SceneConstants| camera_ray(camera, scene, dvec2(50.0, 75.0), dvec2(0.9, 0.3));
    let is = |ray: Ray, origin: DVec3, direction: DVec3, t_max: f64| {
        assert!(ray.origin.abs_diff_eq(origin, 2.0e-5), "{ray:?}");
        assert!(ray.direction.abs_diff_eq(direction, 2.0e-5), "{ray:?}");
        assert!((ray.t_max / t_max - 1.0).abs() < 1.0e-5, "{ray:?}");
    };
    let scene = of_mitsuba(1.0, 50.0, Mat4::IDENTITY, [tangent, 0.5 * tangent]);
    let pinhole = ray(CAMERA_PERSPECTIVE, &scene);
    is(pinhole, dvec3(0.28868, -0.14434, 1.0), dvec3(0.27472, -0.13736, 0.95166), 51.4889);
    let lens = ray(CAMERA_THINLENS, &scene);
    is(lens, dvec3(0.34780, -0.16883, 1.0), dvec3(0.26185, -0.13214, 0.95602), 51.2541);
    let to_world = Mat4::from_translation(vec3(1.0, 2.0, 3.0)) * Mat4::from_scale(vec3(3.0, 2.0, 4.0));
    let orthographic = ray(CAMERA_ORTHOGRAPHIC, &of_mitsuba(0.5, 20.0, to_world, [1.0, 0.5]));
    is(orthographic, dvec3(2.5, 1.5, 5.0), DVec3::Z, 19.5);
}
