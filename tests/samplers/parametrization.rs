//! Texture coordinates and tangents of `glsl/include/geometry/surface.glsl`, against Mitsuba 3 for equal hits.

use glam::{DVec2, DVec3, Vec3};
use lodestar::generated::kernels::{FEATURE_TANGENTS, NONE};
use lodestar::scene::{LoadOptions, load};

use crate::fixture::{Row, rows};
use crate::intersections::TraceInput;
use crate::surfaces::{SurfaceOutput, find};

fn ray(hit: &Row) -> TraceInput {
    TraceInput::new(hit.vector("origin").as_vec3(), hit.vector("direction").as_vec3())
}

/// Difference relative to the size of Mitsuba's vector. The sizes of shapes and the poles of polar coordinates make
/// vectors large.
fn differs(device: [f32; 3], mitsuba: DVec3) -> f64 {
    (Vec3::from(device).as_dvec3() - mitsuba).length() / mitsuba.length().max(1.0)
}

/// Deviations of uv, dp_du, dp_dv and the two tangents of the shading frame.
fn deviations(hit: &Row, o: &SurfaceOutput) -> [f64; 5] {
    let uv = DVec2::from(hit.numbers("uv")) - DVec2::from(o.uv.map(f64::from));
    // An azimuth of one turn equals an azimuth of 0.
    let uv = DVec2::new((uv.x + 0.5).rem_euclid(1.0) - 0.5, (uv.y + 0.5).rem_euclid(1.0) - 0.5);
    let [s, t, _] = o.frame;
    let vectors = [(o.dp_du, "dp_du"), (o.dp_dv, "dp_dv"), (s, "s"), (t, "t")];
    let [a, b, c, d] = vectors.map(|(device, name)| differs(device, hit.vector(name)));
    [uv.length(), a, b, c, d]
}

#[test]
fn coordinates_and_tangents_are_mitsubas() {
    let scene = load("tests/data/surfaces/scene.xml".as_ref(), &LoadOptions::default()).expect("a scene");
    let hits = rows("surfaces/hits.json");
    let found = find(&scene.primitives, &hits.iter().map(ray).collect::<Vec<_>>(), FEATURE_TANGENTS);
    assert!(hits.len() > 200);
    let mut worst = [0.0_f64; 5];
    for (hit, o) in hits.iter().zip(&found) {
        assert_ne!(o.primitive, NONE, "{hit:?}");
        assert!(differs(o.position, hit.vector("p")) < 2.0e-3, "{hit:?}: {o:?}");
        let deviations = deviations(hit, o);
        for (worst, deviation) in worst.iter_mut().zip(deviations) {
            *worst = worst.max(deviation);
        }
        // Vertex normals have 16 bits per coordinate. The last two vectors are frames about them.
        let tolerances = [1.0e-5, 3.0e-5, 3.0e-5, 1.0e-4, 1.0e-4];
        let ok = deviations.iter().zip(tolerances).all(|(deviation, tolerance)| *deviation < tolerance);
        assert!(ok, "{deviations:?} for {hit:?}: {o:?}");
    }
    println!("largest deviations of uv, dp_du, dp_dv, s, t: {worst:?}");
    // The twin must fail: each hit against the answer for the next hit.
    assert!(hits.iter().zip(&found[1..]).any(|(hit, o)| deviations(hit, o)[0] > 2.0e-5));
}
