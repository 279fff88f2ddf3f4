//! Cameras, films and reconstruction filters.

use super::xml::{
    EYE, ball, default, film, float, integer, on, perspective, printed, sensor, sheet, sized_film, string,
};
use super::{Class::Cameras, Reference, Table};

const BOX: &str = "<rfilter type='box'/>";

/// Adds a scene that this sensor shows.
fn seen(table: &mut Table, name: &str, sensor: &str) {
    seen_as(table, name, sensor, Reference::Mitsuba);
}

/// Adds a scene that this sensor shows, with its reference.
fn seen_as(table: &mut Table, name: &str, sensor: &str, reference: Reference) {
    table.add(Cameras, name, |stage| {
        stage.sensor = sensor.to_owned();
        stage.subject = ball(&printed()) + &sheet(&printed());
        stage.reference = reference;
    });
}

pub fn add(table: &mut Table) {
    let pinhole = |inside: &str| perspective(inside, &film(BOX));
    for axis in ["x", "y", "diagonal", "smaller", "larger"] {
        let (fov, value) = if axis == "x" { ("$fov", default("fov", "40")) } else { ("35", String::new()) };
        let inside = string("fov_axis", axis) + &float("fov", fov);
        let sensor = value + &pinhole(&inside);
        seen(table, &format!("perspective-{axis}"), &sensor);
    }
    seen(table, "focal-length", &pinhole(&string("focal_length", "70mm")));
    let offset =
        float("fov", "40") + &float("principal_point_offset_x", "0.15") + &float("principal_point_offset_y", "-0.1");
    seen(table, "principal-point", &pinhole(&offset));
    seen(table, "clips", &pinhole(&(float("fov", "40") + &float("near_clip", "4.9") + &float("far_clip", "6.2"))));
    let mirrored = format!("<scale x='-1'/>{EYE}");
    seen(table, "perspective-mirrored", &sensor("perspective", &mirrored, &float("fov", "40"), &film(BOX)));
    seen(table, "wide", &pinhole(&float("fov", "100")));
    let lens = float("fov", "40") + &float("aperture_radius", "0.25") + &float("focus_distance", "4.5");
    seen(table, "thinlens", &sensor("thinlens", EYE, &lens, &film(BOX)));
    let near = float("fov", "40") + &float("aperture_radius", "0.05") + &float("focus_distance", "1.5");
    seen(table, "thinlens-near", &sensor("thinlens", EYE, &near, &film(BOX)));
    let parallel = format!("<scale x='2' y='2'/>{EYE}");
    seen(table, "orthographic", &sensor("orthographic", &parallel, "", &film(BOX)));
    let stretched = format!("<scale x='2.5' y='1.5'/>{EYE}");
    seen(table, "orthographic-stretched", &sensor("orthographic", &stretched, "", &film(BOX)));
    let fov = float("fov", "40");
    let crop = integer("crop_offset_x", 7)
        + &integer("crop_offset_y", 5)
        + &integer("crop_width", 24)
        + &integer("crop_height", 18);
    seen(table, "crop", &perspective(&fov, &sized_film(40, 30, &(crop.clone() + BOX))));
    // A pixel at the border sees beyond it, whatever the file says. In Mitsuba it does so only with `sample_border`.
    let gaussian = "<rfilter type='gaussian'/>";
    let filters = [
        ("tent", "tent-border", "<rfilter type='tent'/>"),
        ("tent-wide", "tent-wide-border", "<rfilter type='tent'><float name='radius' value='1.6'/></rfilter>"),
        ("gaussian", "gaussian-border", gaussian),
        (
            "gaussian-wide",
            "gaussian-wide-border",
            "<rfilter type='gaussian'><float name='stddev' value='0.8'/></rfilter>",
        ),
    ];
    for (name, border, filter) in filters {
        seen(table, border, &perspective(&fov, &film(&(on("sample_border") + filter))));
        seen_as(table, name, &perspective(&fov, &film(filter)), Reference::Like(border));
    }
    let crop = crop + &on("sample_border");
    seen(table, "gaussian-crop", &perspective(&fov, &sized_film(40, 30, &(crop + gaussian))));
}
