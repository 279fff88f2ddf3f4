//! BSDFs: each plugin, its roughness, textures on its parameters, and both sides.

use super::xml::{
    ball, bitmap, block, bsdf, checkerboard, default, diffuse, element, float, numbers, on, path, rgb, sheet, string,
    two_sided,
};
use super::{Class::Bsdfs, Reference, Table};

/// Adds a scene whose ball and block have this BSDF.
fn solid(table: &mut Table, name: &str, bsdf: &str) {
    table.show(Bsdfs, name, ball(bsdf) + &block(bsdf));
}

/// Adds a scene whose ball and sheet have this BSDF.
fn thin(table: &mut Table, name: &str, bsdf: &str) {
    table.show(Bsdfs, name, ball(bsdf) + &sheet(bsdf));
}

/// Adds glass, in weak light from all sides, for the lamp is hard to find through it.
fn glass(table: &mut Table, name: &str, bsdf: &str) {
    table.add(Bsdfs, name, |stage| {
        stage.subject = ball(bsdf) + &block(bsdf) + &element("emitter", "constant", &rgb("radiance", "0.5,0.6,0.8"));
    });
}

/// Color of the scene `plastic`.
const PLASTIC: &str = "0.8,0.4,0.1";

const DISTRIBUTIONS: [&str; 2] = ["ggx", "beckmann"];

pub fn add(table: &mut Table) {
    add_diffuse(table);
    add_dielectrics(table);
    add_conductors(table);
    add_plastics(table);
    add_polarized_plastics(table);
    add_principled(table);
    add_thin_principled(table);
    add_wrappers(table);
    add_sheens(table);
    add_films(table);
}

/// Balls of clear glass under films, which are as bright as the sky about them, for what a film does not reflect passes.
fn add_films(table: &mut Table) {
    for (name, thickness) in [("", float("film_thickness", "420")), ("-textured", film_of_numbers())] {
        table.add(Bsdfs, format!("film-furnace{name}"), |stage| {
            stage.integrator = path(32);
            stage.room = String::new();
            stage.lamp = element("emitter", "constant", &rgb("radiance", "0.5,0.7,1"));
            stage.subject = ball(&bsdf("dielectric", &(thickness.clone() + &float("film_eta", "1.9"))));
            stage.reference = Reference::Uniform([0.5, 0.7, 1.0]);
        });
    }
}

/// Thickness from 0 to 600 nm.
fn film_of_numbers() -> String {
    let scale = float("scale", "600") + &numbers("texture", "numbers.png");
    format!("<texture type='scale' name='film_thickness'>{scale}</texture>")
}

/// White balls under white sheens, which are as bright as the sky about them.
fn add_sheens(table: &mut Table) {
    let white = bsdf("diffuse", &rgb("reflectance", "1,1,1"));
    for (name, roughness) in [("", float("roughness", "0.7")), ("-textured", numbers("roughness", "numbers.png"))] {
        table.add(Bsdfs, format!("sheen-furnace{name}"), |stage| {
            stage.room = String::new();
            stage.lamp = element("emitter", "constant", &rgb("radiance", "0.5,0.7,1"));
            stage.subject = ball(&bsdf("sheen", &(roughness.clone() + &white)));
            stage.reference = Reference::Uniform([0.5, 0.7, 1.0]);
        });
    }
}

fn add_diffuse(table: &mut Table) {
    let albedo = bsdf("diffuse", &rgb("reflectance", "$albedo,0.5,0.2"));
    table.show(Bsdfs, "diffuse", default("albedo", "0.7") + &ball(&albedo) + &block(&albedo));
    let board = checkerboard("reflectance", "0.8,0.3,0.2", "0.1,0.3,0.6");
    solid(table, "diffuse-checkerboard", &bsdf("diffuse", &board));
    for (name, inside) in [
        ("nearest", string("filter_type", "nearest")),
        ("mirror", string("wrap_mode", "mirror") + TWICE),
        ("clamp", string("wrap_mode", "clamp") + TWICE),
        ("raw", on("raw")),
    ] {
        let image = bitmap("reflectance", "colors.png", &inside);
        solid(table, &format!("diffuse-bitmap-{name}"), &bsdf("diffuse", &image));
    }
}

const TWICE: &str = "<transform name='to_uv'><scale x='2' y='3'/><translate x='-0.6' y='0.3'/></transform>";

fn add_dielectrics(table: &mut Table) {
    glass(table, "dielectric", &bsdf("dielectric", &string("int_ior", "diamond")));
    let tints = rgb("specular_reflectance", "0.9,0.5,0.4") + &rgb("specular_transmittance", "0.4,0.6,0.9");
    glass(table, "dielectric-tinted", &bsdf("dielectric", &tints));
    let images =
        bitmap("specular_reflectance", "colors.png", "") + &checkerboard("specular_transmittance", "0.9", "0.3");
    glass(table, "dielectric-textured", &bsdf("dielectric", &images));
    glass(table, "dielectric-inverted", &bsdf("dielectric", &(float("int_ior", "1") + &float("ext_ior", "1.5"))));
    glass(table, "thindielectric", &bsdf("thindielectric", &tints));
    glass(table, "thindielectric-textured", &bsdf("thindielectric", &images));
    for distribution in DISTRIBUTIONS {
        for (alpha, percent) in [("0.05", 5), ("0.2", 20), ("0.6", 60)] {
            let inside = string("distribution", distribution) + &float("alpha", alpha);
            glass(table, &format!("roughdielectric-{distribution}-{percent}"), &bsdf("roughdielectric", &inside));
        }
    }
    let inside = numbers("alpha", "numbers.png") + &tints;
    glass(table, "roughdielectric-textured", &bsdf("roughdielectric", &inside));
    let inside = float("alpha_u", "0.1") + &float("alpha_v", "0.4");
    glass(table, "roughdielectric-anisotropic", &bsdf("roughdielectric", &inside));
}

fn add_conductors(table: &mut Table) {
    solid(table, "conductor", &bsdf("conductor", &string("material", "Cu")));
    let image = bitmap("specular_reflectance", "colors.png", "");
    solid(table, "conductor-textured", &bsdf("conductor", &(string("material", "none") + &image)));
    for distribution in DISTRIBUTIONS {
        for (alpha, percent) in [("0.05", 5), ("0.2", 20), ("0.6", 60)] {
            let inside = string("material", "Au") + &string("distribution", distribution) + &float("alpha", alpha);
            solid(table, &format!("roughconductor-{distribution}-{percent}"), &bsdf("roughconductor", &inside));
        }
        let inside = string("distribution", distribution) + &float("alpha_u", "0.05") + &float("alpha_v", "0.4");
        let name = format!("roughconductor-{distribution}-anisotropic");
        solid(table, &name, &bsdf("roughconductor", &inside));
    }
    let inside = string("material", "Al") + &numbers("alpha", "numbers.png") + &image;
    solid(table, "roughconductor-textured", &bsdf("roughconductor", &inside));
    let inside = numbers("alpha_u", "numbers.png") + &float("alpha_v", "0.1");
    thin(table, "roughconductor-textured-twosided", &two_sided(&bsdf("roughconductor", &inside)));
}

fn add_plastics(table: &mut Table) {
    let tint = rgb("diffuse_reflectance", PLASTIC);
    let textured = checkerboard("diffuse_reflectance", "0.8,0.3,0.2", "0.1,0.3,0.6")
        + &bitmap("specular_reflectance", "colors.png", "");
    solid(table, "plastic", &bsdf("plastic", &tint));
    solid(table, "plastic-nonlinear", &bsdf("plastic", &(tint.clone() + &on("nonlinear") + &float("int_ior", "1.9"))));
    solid(table, "plastic-textured", &bsdf("plastic", &textured));
    thin(table, "plastic-twosided", &two_sided(&bsdf("plastic", &tint)));
    for distribution in DISTRIBUTIONS {
        for (alpha, percent) in [("0.05", 5), ("0.3", 30)] {
            let inside = string("distribution", distribution) + &float("alpha", alpha) + &tint;
            solid(table, &format!("roughplastic-{distribution}-{percent}"), &bsdf("roughplastic", &inside));
        }
    }
    let inside = tint + &on("nonlinear") + &float("alpha", "0.2");
    solid(table, "roughplastic-nonlinear", &bsdf("roughplastic", &inside));
    thin(
        table,
        "roughplastic-textured-twosided",
        &two_sided(&bsdf("roughplastic", &(textured + &float("alpha", "0.1")))),
    );
}

fn add_polarized_plastics(table: &mut Table) {
    let tint = rgb("diffuse_reflectance", "0.8,0.4,0.1");
    for distribution in DISTRIBUTIONS {
        let inside = string("distribution", distribution) + &float("alpha", "0.2") + &tint;
        solid(table, &format!("pplastic-{distribution}"), &bsdf("pplastic", &inside));
    }
    let textured = checkerboard("diffuse_reflectance", "0.8,0.3,0.2", "0.1,0.3,0.6")
        + &bitmap("specular_reflectance", "colors.png", "")
        + &float("alpha_u", "0.1")
        + &float("alpha_v", "0.4");
    thin(table, "pplastic-textured-twosided", &two_sided(&bsdf("pplastic", &textured)));
}

fn add_thin_principled(table: &mut Table) {
    let color = rgb("base_color", "0.8,0.4,0.1");
    for (name, values) in [
        ("plain", &[][..]),
        ("crossing", &[("diff_trans", "1.4"), ("roughness", "0.7")]),
        ("specular", &[("spec_trans", "0.7"), ("roughness", "0.4"), ("eta", "1.4"), ("spec_tint", "0.8")]),
        ("anisotropic", &[("spec_trans", "1"), ("roughness", "0.5"), ("anisotropic", "0.8")]),
        ("sheen", &[("sheen", "1"), ("sheen_tint", "0.7"), ("flatness", "0.6"), ("diff_trans", "0.5")]),
    ] {
        let inside: String = values.iter().map(|(name, value)| float(name, value)).collect();
        thin(table, &format!("principledthin-{name}"), &bsdf("principledthin", &(inside + &color)));
    }
    let image = bitmap("base_color", "colors.png", "") + &float("roughness", "0.5");
    for parameter in ["spec_trans", "diff_trans"] {
        let inside = image.clone() + &numbers(parameter, "numbers.png");
        thin(table, &format!("principledthin-textured-{parameter}"), &bsdf("principledthin", &inside));
    }
}

fn add_principled(table: &mut Table) {
    let color = rgb("base_color", "0.8,0.4,0.1");
    for (name, values) in [
        ("plain", &[][..]),
        ("metallic", &[("metallic", "0.9"), ("roughness", "0.2")]),
        ("anisotropic", &[("metallic", "1"), ("roughness", "0.3"), ("anisotropic", "0.9")]),
        ("sheen", &[("sheen", "1"), ("sheen_tint", "0.7"), ("roughness", "0.8")]),
        ("clearcoat", &[("clearcoat", "1"), ("clearcoat_gloss", "0.6"), ("roughness", "0.6")]),
        ("spec-tint", &[("spec_tint", "1"), ("specular", "0.9"), ("roughness", "0.2")]),
        ("flatness", &[("flatness", "0.8"), ("roughness", "0.6")]),
        ("specular", &[("specular", "1"), ("roughness", "0.1")]),
    ] {
        let inside: String = values.iter().map(|(name, value)| float(name, value)).collect();
        solid(table, &format!("principled-{name}"), &bsdf("principled", &(inside + &color)));
    }
    let inside = color.clone() + &float("spec_trans", "0.8") + &float("roughness", "0.3") + &float("eta", "1.4");
    glass(table, "principled-glass", &bsdf("principled", &inside));
    let image = bitmap("base_color", "colors.png", "");
    for parameter in
        ["roughness", "metallic", "anisotropic", "sheen", "clearcoat", "clearcoat_gloss", "spec_tint", "flatness"]
    {
        // A parameter shows where the ones that it acts on are not 0.
        let base = match parameter {
            "anisotropic" => float("metallic", "1") + &float("roughness", "0.4"),
            "clearcoat_gloss" => float("clearcoat", "1"),
            "roughness" => String::new(),
            _ => float("roughness", "0.4"),
        };
        let inside = image.clone() + &base + &numbers(parameter, "numbers.png");
        solid(table, &format!("principled-textured-{parameter}"), &bsdf("principled", &inside));
    }
    let inside = image + &numbers("spec_trans", "numbers.png") + &float("roughness", "0.4") + &float("eta", "1.5");
    glass(table, "principled-textured-spec_trans", &bsdf("principled", &inside));
    thin(table, "principled-twosided", &two_sided(&bsdf("principled", &(color + &float("metallic", "0.5")))));
}

fn add_wrappers(table: &mut Table) {
    let copper = bsdf("roughconductor", &(string("material", "Cu") + &float("alpha", "0.2")));
    let green = diffuse("0.2,0.7,0.3");
    thin(table, "twosided-two", &two_sided(&(diffuse("0.8,0.2,0.2") + &green)));
    solid(table, "blend", &bsdf("blendbsdf", &(float("weight", "0.3") + &copper + &green)));
    solid(table, "blend-textured", &bsdf("blendbsdf", &(numbers("weight", "numbers.png") + &green + &copper)));
    let gold = bsdf("roughconductor", &(string("material", "Au") + &float("alpha", "0.4")));
    let inner = bsdf("blendbsdf", &(float("weight", "0.5") + &copper + &green));
    solid(table, "blend-nested", &bsdf("blendbsdf", &(float("weight", "0.6") + &inner + &gold)));
    let blend = bsdf("blendbsdf", &(numbers("weight", "numbers.png") + &green + &copper));
    thin(table, "blend-twosided", &two_sided(&blend));
    // Mitsuba's blend of a plastic with itself is not that plastic.
    let plastic = bsdf("plastic", &rgb("diffuse_reflectance", PLASTIC));
    let inner = bsdf("blendbsdf", &(float("weight", "0.3") + &plastic + &plastic));
    let blend = bsdf("blendbsdf", &(numbers("weight", "numbers.png") + &inner + &plastic));
    table.add(Bsdfs, "blend-of-plastics", |stage| {
        stage.subject = ball(&blend) + &block(&blend);
        stage.reference = Reference::Like("plastic");
    });
    solid(table, "mask", &bsdf("mask", &(float("opacity", "0.6") + &two_sided(&green))));
    solid(table, "mask-textured", &bsdf("mask", &(numbers("opacity", "numbers.png") + &two_sided(&green))));
    solid(table, "mask-glass", &bsdf("mask", &(float("opacity", "0.5") + &bsdf("dielectric", ""))));
    table.show(Bsdfs, "null", ball(&bsdf("null", "")) + &block(&green));
    let bump = bitmap("arbitrary", "waves.png", &on("raw"));
    for (name, nested) in [("diffuse", &green), ("roughconductor", &copper)] {
        let inside = bump.clone() + nested;
        solid(table, &format!("bumpmap-{name}"), &bsdf("bumpmap", &inside));
        solid(table, &format!("bumpmap-strong-{name}"), &bsdf("bumpmap", &(float("scale", "3") + &inside)));
        let inside = numbers("normalmap", "normals.png") + nested;
        solid(table, &format!("normalmap-{name}"), &bsdf("normalmap", &inside));
    }
    thin(table, "bumpmap-twosided", &two_sided(&bsdf("bumpmap", &(bump + &green))));
}
