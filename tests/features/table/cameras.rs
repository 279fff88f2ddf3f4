//! Cameras, films and reconstruction filters.

use super::xml::{
    EYE, ball, default, film, float, integer, on, perspective, printed, sensor, sheet, sized_film, string,
};
use super::{Class::Cameras, Known, Table};

const BOX: &str = "<rfilter type='box'/>";

/// Adds a scene that this sensor shows.
fn seen(table: &mut Table, name: &str, sensor: &str) {
    table.add(Cameras, name, |stage| {
        stage.sensor = sensor.to_owned();
        stage.subject = ball(&printed()) + &sheet(&printed());
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
    let filters = [
        ("tent", "<rfilter type='tent'/>"),
        ("tent-wide", "<rfilter type='tent'><float name='radius' value='1.6'/></rfilter>"),
        ("gaussian", "<rfilter type='gaussian'/>"),
        ("gaussian-wide", "<rfilter type='gaussian'><float name='stddev' value='0.8'/></rfilter>"),
    ];
    for (name, filter) in filters {
        seen(table, name, &perspective(&fov, &film(filter)));
        if name.ends_with("wide") {
            table.known(Known("a pixel at the border sees beyond it; in Mitsuba, only with `sample_border`", 0.02));
        }
        let border = on("sample_border") + filter;
        seen(table, &format!("{name}-border"), &perspective(&fov, &film(&border)));
    }
    seen(table, "gaussian-crop", &perspective(&fov, &sized_film(40, 30, &(crop + filters[2].1))));
}
