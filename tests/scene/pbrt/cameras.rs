//! Cameras and films.

use glam::{Vec2, Vec3};
use lodestar::scene::{Crop, FovAxis, Projection, ReconstructionFilter};

use super::{assert_close, load_text};

fn refused(options: &str, expected: &str) {
    let error = load_text(&format!("{options}\nWorldBegin")).expect_err(expected);
    assert!(error.contains(expected) && error.contains("scene.pbrt:1: "), "{error} lacks {expected}");
}

/// pbrt's cameras have `+x` to the right. A mirror by `Scale -1 1 1` exchanges the sides.
#[test]
fn left_and_right() {
    let scene = |before: &str| {
        let text = format!("{before}LookAt 1 2 3  1 2 9  0 1 0 Camera \"perspective\" WorldBegin");
        load_text(&text).unwrap().camera.world_from_camera
    };
    let (plain, mirrored) = (scene(""), scene("Scale -1 1 1 "));
    // The picture's left is the camera's +x of Mitsuba's.
    assert_eq!(plain.x_axis.truncate(), Vec3::NEG_X);
    assert_eq!(mirrored.x_axis.truncate(), Vec3::X);
    for camera in [plain, mirrored] {
        assert_eq!([camera.y_axis.truncate(), camera.z_axis.truncate()], [Vec3::Y, Vec3::Z]);
        assert_eq!(camera.w_axis.truncate(), Vec3::new(1.0, 2.0, 3.0));
    }
}

#[test]
fn the_angle_spans_the_shorter_side() {
    let camera = |film: &str| {
        let text = format!("Film \"rgb\" {film}\nCamera \"perspective\" \"float fov\" 60 WorldBegin");
        let scene = load_text(&text).unwrap();
        scene.camera.half_extent(scene.film.width, scene.film.height)
    };
    let tangent = 30f32.to_radians().tan();
    let wide = camera("\"integer xresolution\" 200 \"integer yresolution\" 100");
    assert_close(&wide.to_array(), &[2.0 * tangent, tangent]);
    let high = camera("\"integer xresolution\" 100 \"integer yresolution\" 200");
    assert_close(&high.to_array(), &[tangent, 2.0 * tangent]);
    assert_close(&camera("").to_array(), &[16.0 / 9.0 * tangent, tangent]);
}

/// A window beside the center: the pixel at (0, 0) looks along the window's upper left corner.
#[test]
fn windows_move_the_principal_point() {
    let text = "Film \"rgb\" \"integer xresolution\" 30 \"integer yresolution\" 20\n\
                Camera \"perspective\" \"float fov\" 90 \"float screenwindow\" [ -0.5 2.5 -1.5 0.5 ] WorldBegin";
    let camera = load_text(text).unwrap().camera;
    let with_lens = load_text(&text.replace("WorldBegin", "\"float lensradius\" 0.1 WorldBegin")).unwrap().camera;
    assert_eq!(with_lens.principal_point, camera.principal_point);
    assert!(matches!(with_lens.projection, Projection::ThinLens { .. }));
    let half = camera.half_extent(30, 20);
    assert_close(&half.to_array(), &[1.5, 1.0]);
    // Mitsuba's x points to the left.
    let corner = (Vec2::ONE - 2.0 * camera.principal_point) * half;
    assert_close(&corner.to_array(), &[0.5, 0.5]);
    assert_eq!(camera.fov_axis, FovAxis::X);
    refused("Camera \"perspective\" \"float screenwindow\" [ -1 1 -1 1 ]", "pixels must be square");
}

#[test]
fn lenses_and_parallel_rays() {
    let camera = |text: &str| load_text(&format!("{text} WorldBegin")).unwrap().camera;
    let lens = camera("Scale 0.5 0.5 0.5 Camera \"perspective\" \"float lensradius\" 0.1 \"float focaldistance\" 3");
    // Camera space is half as large as the world.
    assert_eq!(lens.projection, Projection::ThinLens { aperture_radius: 0.2, focus_distance: 6.0 });
    let parallel =
        camera("Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100 Camera \"orthographic\"");
    assert_eq!(parallel.projection, Projection::Orthographic);
    // The picture's width spans x from -2 to 2.
    assert_eq!(parallel.world_from_camera.x_axis.truncate(), Vec3::new(-2.0, 0.0, 0.0));
    assert_eq!(camera("Camera \"spherical\"").projection, Projection::EqualArea);
    let rows = camera("Camera \"spherical\" \"string mapping\" \"equirectangular\"");
    let backwards = Projection::Equirectangular { longitude: [90.0, -270.0], latitude: [-90.0, 90.0] };
    assert_eq!(rows.projection, backwards);
    refused(
        "Camera \"spherical\" \"string mapping\" \"cube\"",
        "`mapping` is `equalarea` or `equirectangular`, not `cube`",
    );
    refused("Camera \"realistic\"", "the camera `realistic` is not supported");
    refused("Camera \"perspective\" \"float fov\" 180", "`fov` must lie between");
    refused("Scale 1 2 1 Camera \"perspective\"", "neither shear nor scale unevenly");
}

#[test]
fn films_and_filters() {
    let film = |text: &str| load_text(&format!("{text} Camera \"perspective\" WorldBegin")).unwrap();
    let size = "\"integer xresolution\" 100 \"integer yresolution\" 50";
    let crop = |window: &str| film(&format!("Film \"rgb\" {size} {window}")).film.crop;
    let expected = Some(Crop { x: 25, y: 13, width: 50, height: 37 });
    assert_eq!(crop("\"float cropwindow\" [ 0.25 0.75 0.26 1 ]"), expected);
    assert_eq!(crop("\"integer pixelbounds\" [ 25 75 13 50 ]"), expected);
    assert_eq!(crop("\"float cropwindow\" [ 0 1 0 1 ]"), None);
    let filter = |text: &str| film(text).film.filter;
    assert_eq!(filter(""), ReconstructionFilter::Gaussian { stddev: 0.5 });
    assert_eq!(filter("PixelFilter \"gaussian\" \"float sigma\" 0.4"), ReconstructionFilter::Gaussian { stddev: 0.4 });
    assert_eq!(filter("PixelFilter \"triangle\""), ReconstructionFilter::Tent { radius: 2.0 });
    assert_eq!(filter("PixelFilter \"box\""), ReconstructionFilter::Box);
    let warned = film("PixelFilter \"mitchell\"").warnings.join("\n");
    assert!(warned.contains("scene.pbrt:1: the filter `mitchell` is not supported"), "{warned}");
    refused("Film \"rgb\" \"integer xresolution\" 0", "must be a whole number");
}

#[test]
fn samples_and_depths() {
    let scene = |text: &str| load_text(&format!("{text} Camera \"perspective\" WorldBegin")).unwrap();
    assert_eq!(scene("").sample_count, None);
    assert_eq!(scene("Sampler \"zsobol\"").sample_count, Some(16));
    assert_eq!(scene("Sampler \"stratified\" \"integer xsamples\" 3").sample_count, Some(12));
    // Five scatterings are six edges.
    assert_eq!(
        scene("").integrator.max_depth,
        scene("Integrator \"path\" \"integer maxdepth\" 5").integrator.max_depth
    );
    let one = scene("Integrator \"path\" \"integer maxdepth\" 1").integrator.max_depth;
    assert_eq!(one, Some(2));
    refused("Integrator \"ao\"", "makes another kind of picture");
    refused("Integrator \"wrong\"", "the integrator `wrong` is not known");
}
