//! Reader of `sunsky`, beside what Mitsuba makes of it (`tests/data/sunsky/make.py`).

use std::f64::consts::{PI, TAU};

use glam::{DVec3, dvec3};
use lodestar::scene::texture::{Image, Texels};
use lodestar::scene::{EnvironmentKind, Scene};
use serde_json::Value;

use super::load_body;

fn fixture() -> Value {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/sunsky/values.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn rows<'a>(fixture: &'a Value, name: &str) -> &'a [Value] {
    fixture[name].as_array().unwrap()
}

fn vector(value: &Value) -> DVec3 {
    dvec3(value[0].as_f64().unwrap(), value[1].as_f64().unwrap(), value[2].as_f64().unwrap())
}

fn emitter(inside: &str) -> String {
    format!(r#"<emitter type="sunsky">{inside}</emitter>"#).replace('\n', " ")
}

fn float(name: &str, value: f64) -> String {
    format!(r#"<float name="{name}" value="{value:?}"/>"#)
}

fn triple(tag: &str, name: &str, v: DVec3) -> String {
    match tag {
        "rgb" => format!(r#"<rgb name="{name}" value="{}, {}, {}"/>"#, v.x, v.y, v.z),
        _ => format!(r#"<{tag} name="{name}" x="{:?}" y="{:?}" z="{:?}"/>"#, v.x, v.y, v.z),
    }
}

/// A sky in a scene.
struct Sky {
    scene: Scene,
}

impl Sky {
    #[track_caller]
    fn new(inside: &str) -> Self {
        let scene = load_body(&emitter(inside)).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        Self { scene }
    }

    fn image(&self) -> &Image {
        &self.scene.images[0]
    }

    fn texel(&self, column: usize, row: usize) -> DVec3 {
        let Texels::Floats(texels) = &self.image().texels else { panic!("bytes") };
        let [r, g, b, _] = texels[row * self.image().width as usize + column];
        dvec3(r.into(), g.into(), b.into())
    }

    /// World's direction at the center of a texel.
    fn direction(&self, column: usize, row: usize) -> DVec3 {
        let EnvironmentKind::Map { to_world, .. } = self.scene.environment.unwrap().kind else { panic!("no map") };
        let azimuth = TAU * (column as f64 + 0.5) / f64::from(self.image().width);
        let angle = PI * row as f64 / f64::from(self.image().height - 1);
        let map = dvec3(angle.sin() * azimuth.sin(), angle.cos(), -angle.sin() * azimuth.cos());
        to_world.as_dmat3() * map
    }

    /// Radiance of the texel that is nearest to a direction of the world.
    fn near(&self, direction: DVec3) -> (DVec3, DVec3) {
        let (width, height) = (self.image().width as usize, self.image().height as usize);
        let EnvironmentKind::Map { to_world, .. } = self.scene.environment.unwrap().kind else { panic!("no map") };
        let map = to_world.as_dmat3().transpose() * direction;
        let column = (map.x.atan2(-map.z).rem_euclid(TAU) / TAU * width as f64) as usize % width;
        let row = (map.y.clamp(-1.0, 1.0).acos() / PI * (height - 1) as f64).round() as usize;
        (self.texel(column, row), self.direction(column, row))
    }

    /// Integrals over all directions of the radiance, and of the direction times the mean radiance.
    fn integrals(&self) -> (DVec3, DVec3) {
        let (width, height) = (self.image().width as usize, self.image().height as usize);
        let (mut sum, mut moment) = (DVec3::ZERO, DVec3::ZERO);
        for row in 0..height {
            let angle = PI * row as f64 / (height - 1) as f64;
            let area = angle.sin() * PI / (height - 1) as f64 * TAU / width as f64;
            for column in 0..width {
                let texel = self.texel(column, row) * area;
                sum += texel;
                if texel != DVec3::ZERO {
                    moment += self.direction(column, row) * (texel.element_sum() / 3.0);
                }
            }
        }
        (sum, moment)
    }
}

/// Largest relative error of a sky against Mitsuba's values times `factor`. The nearest texel is up to 0.12 degrees away.
fn sky_error(row: &Value, factor: f64) -> f64 {
    let inside = float("turbidity", row["turbidity"].as_f64().unwrap())
        + &triple("rgb", "albedo", vector(&row["albedo"]))
        + &triple("vector", "sun_direction", vector(&row["sun_direction"]))
        + &float("sun_scale", 0.0);
    let sky = Sky::new(&inside);
    let points = row["points"].as_array().unwrap().iter();
    let errors = points.map(|point| {
        let (ours, at) = sky.near(vector(&point["direction"]));
        assert!(at.angle_between(vector(&point["direction"])).to_degrees() < 0.13);
        let theirs = factor * vector(&point["radiance"]);
        (ours - theirs).length() / theirs.length()
    });
    // The median: close to the sun and to the horizon, the sky changes within a texel.
    let mut errors: Vec<f64> = errors.collect();
    errors.sort_by(f64::total_cmp);
    assert!(errors[errors.len() - 1] < 0.05, "{errors:?}");
    errors[errors.len() / 2]
}

#[test]
fn skies_are_mitsubas() {
    let fixture = fixture();
    for row in &rows(&fixture, "skies")[..4] {
        assert!(sky_error(row, 1.0) < 3.0e-3, "{}: {row}", sky_error(row, 1.0));
        assert!(sky_error(row, 1.01) > 3.0e-3, "the twin: 1 % more");
    }
}

/// The sun has the power of its disk, and its center lies where the sun stands.
#[test]
fn suns_are_mitsubas() {
    let fixture = fixture();
    for (index, row) in rows(&fixture, "suns").iter().enumerate().step_by(4) {
        let direction = vector(&row["sun_direction"]);
        // The power does not depend on the aperture.
        let more = if index == 0 { float("sun_aperture", 3.0) } else { String::new() };
        let inside = float("turbidity", row["turbidity"].as_f64().unwrap())
            + &triple("vector", "sun_direction", direction)
            + &float("sky_scale", 0.0)
            + &more;
        let (sum, moment) = Sky::new(&inside).integrals();
        let half = 0.5 * 0.5358_f64.to_radians();
        let expected = vector(&row["radiance"]).max(DVec3::ZERO) * (2.0 * TAU * (0.5 * half).sin().powi(2));
        let error = |factor: f64| (sum - factor * expected).length() / expected.length();
        assert!(error(1.0) < 1.0e-3, "{sum}, not {expected}: {row}");
        assert!(error(1.002) > 1.0e-3, "the twin: 0.2 % more");
        let off = moment.angle_between(direction).to_degrees();
        assert!(off < 0.02, "{off} degrees off: {row}");
    }
}

/// Mitsuba computes the sun's position in single precision, which holds some 0.02 degrees.
#[test]
fn places_and_times_have_mitsubas_sun() {
    for row in rows(&fixture(), "times") {
        let place = row["place"].as_object().unwrap();
        let inside = |hours: f64| {
            let hour = place.get("hour").map_or(15.0, |hour| hour.as_f64().unwrap()) + hours;
            let others = place.iter().filter(|(name, _)| *name != "hour").map(|(name, value)| match value.as_i64() {
                Some(number) => format!(r#"<integer name="{name}" value="{number}"/>"#),
                None => float(name, value.as_f64().unwrap()),
            });
            others.collect::<String>() + &float("hour", hour) + &float("sky_scale", 0.0)
        };
        let off = |hours: f64| {
            let (_, moment) = Sky::new(&inside(hours)).integrals();
            moment.angle_between(vector(&row["sun_direction"])).to_degrees()
        };
        assert!(off(0.0) < 0.04, "{} degrees: {row}", off(0.0));
        assert!(off(0.05) > 0.1, "the twin: three minutes later");
    }
}

#[test]
fn transforms_turn_the_sky_but_not_a_given_sun() {
    let turn = r#"<transform name="to_world"><rotate x="1" angle="-90"/></transform>"#;
    let given = triple("vector", "sun_direction", dvec3(0.5, 0.7, 0.1)) + &float("sky_scale", 0.0);
    let (_, moment) = Sky::new(&(given + turn)).integrals();
    assert!(moment.angle_between(dvec3(0.5, 0.7, 0.1)).to_degrees() < 0.05, "{moment}");
    // At a place and a time, the sky's `+z` becomes the world's `+y`.
    let plain = Sky::new(&float("sky_scale", 0.0)).integrals().1.normalize();
    let turned = Sky::new(&(float("sky_scale", 0.0) + turn)).integrals().1.normalize();
    assert!(turned.abs_diff_eq(dvec3(plain.x, plain.z, -plain.y), 1e-3), "{plain} {turned}");
}

#[test]
fn a_sun_below_the_horizon_leaves_all_dark() {
    let scene = load_body(&emitter(&float("hour", 22.0))).unwrap();
    assert!(scene.warnings.len() == 1 && scene.warnings[0].contains("horizon"), "{:?}", scene.warnings);
    let Texels::Floats(texels) = &scene.images[0].texels else { panic!("bytes") };
    assert!(texels.iter().all(|texel| texel[..3] == [0.0; 3]));
}

#[test]
fn what_cannot_be_is_refused() {
    let refuse = |inside: &str, word: &str| {
        let message = load_body(&emitter(inside)).map(drop).expect_err("this should be refused").to_string();
        assert!(message.contains("scene.xml:2: ") && message.contains(word), "{message}");
    };
    refuse(&float("turbidity", 11.0), "`turbidity`");
    refuse(&float("sun_aperture", 0.0), "`sun_aperture`");
    refuse(&float("sun_scale", -1.0), "`sun_scale`");
    refuse(r#"<boolean name="complex_sun" value="true"/>"#, "`complex_sun`");
    refuse(r#"<vector name="sun_direction" x="0"/>"#, "`sun_direction`");
    refuse(&(triple("vector", "sun_direction", DVec3::Z) + &float("hour", 3.0)), "`hour`");
    refuse(r#"<transform name="to_world"><scale value="2"/></transform>"#, "`to_world`");
    refuse(r#"<texture name="albedo" type="checkerboard"/>"#, "`albedo`");
    refuse(r#"<integer name="month" value="13"/>"#, "`month`");
}
