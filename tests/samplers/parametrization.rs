//! Texture coordinates and tangents of `glsl/include/surface.glsl`, against what Mitsuba 3 says of the same hits.

use glam::{DVec2, DVec3, Vec3};
use lodestar::kernels::{FEATURE_TANGENTS, NONE};
use lodestar::scene::{LoadOptions, load};
use serde_json::Value;

use crate::intersections::TraceInput;
use crate::surfaces::{SurfaceOutput, find};

/// A hit as `tests/data/surfaces/make.py` writes it.
struct Hit(Value);

impl Hit {
    fn numbers<const N: usize>(&self, name: &str) -> [f64; N] {
        std::array::from_fn(|i| self.0[name][i].as_f64().expect("a number"))
    }

    fn vector(&self, name: &str) -> DVec3 {
        self.numbers(name).into()
    }

    fn ray(&self) -> TraceInput {
        let [origin, direction] = [self.vector("origin"), self.vector("direction")];
        TraceInput::new(origin.as_vec3(), direction.as_vec3())
    }
}

fn hits() -> Vec<Hit> {
    let text = std::fs::read_to_string("tests/data/surfaces/hits.json").expect("the fixture");
    serde_json::from_str::<Vec<Value>>(&text).expect("JSON").into_iter().map(Hit).collect()
}

/// Relative to the size of what is compared, which the shapes' sizes and the polar coordinates' poles set.
fn differs(device: [f32; 3], mitsuba: DVec3) -> f64 {
    (Vec3::from(device).as_dvec3() - mitsuba).length() / mitsuba.length().max(1.0)
}

/// The largest deviation of uv, dp_du, dp_dv and the two tangents of the shading frame.
fn deviations(hit: &Hit, o: &SurfaceOutput) -> [f64; 5] {
    let uv = DVec2::from(hit.numbers("uv")) - DVec2::from(o.uv.map(f64::from));
    // An azimuth of one turn is one of none.
    let uv = DVec2::new((uv.x + 0.5).rem_euclid(1.0) - 0.5, (uv.y + 0.5).rem_euclid(1.0) - 0.5);
    let [s, t, _] = o.frame;
    let vectors = [(o.dp_du, "dp_du"), (o.dp_dv, "dp_dv"), (s, "s"), (t, "t")];
    let [a, b, c, d] = vectors.map(|(device, name)| differs(device, hit.vector(name)));
    [uv.length(), a, b, c, d]
}

#[test]
fn coordinates_and_tangents_are_mitsubas() {
    let scene = load("tests/data/surfaces/scene.xml".as_ref(), &LoadOptions::default()).expect("a scene");
    let hits = hits();
    let found = find(&scene.primitives, &hits.iter().map(Hit::ray).collect::<Vec<_>>(), FEATURE_TANGENTS);
    assert!(hits.len() > 200);
    let mut worst = [0.0_f64; 5];
    for (hit, o) in hits.iter().zip(&found) {
        assert_ne!(o.primitive, NONE, "{}", hit.0);
        assert!(differs(o.position, hit.vector("p")) < 2.0e-3, "{}: {o:?}", hit.0);
        let deviations = deviations(hit, o);
        for (worst, deviation) in worst.iter_mut().zip(deviations) {
            *worst = worst.max(deviation);
        }
        // Vertex normals are kept in 16 bits a coordinate; the last two are frames about them.
        let tolerances = [1.0e-5, 3.0e-5, 3.0e-5, 1.0e-4, 1.0e-4];
        let ok = deviations.iter().zip(tolerances).all(|(deviation, tolerance)| *deviation < tolerance);
        assert!(ok, "{deviations:?} for {}: {o:?}", hit.0);
    }
    println!("largest deviations of uv, dp_du, dp_dv, s, t: {worst:?}");
    // The twin: the right answers to the wrong questions.
    assert!(hits.iter().zip(&found[1..]).any(|(hit, o)| deviations(hit, o)[0] > 2.0e-5));
}
