//! Shapes: each plugin mirrored, flipped, unevenly scaled; meshes with and without normals and texture coordinates; as
//! glass, whose picture depends on the side; in groups.

use super::xml::{bsdf, default, on, placed, printed, rgb, shape, string, two_sided};
use super::{Class::Shapes, Table};

/// Plugins, each with a word on its file.
const PLUGINS: [(&str, &str); 7] = [
    ("rectangle", ""),
    ("disk", ""),
    ("sphere", ""),
    ("cube", ""),
    ("obj", "smooth.obj"),
    ("ply", "smooth.ply"),
    ("serialized", "meshes.serialized"),
];

/// Name of a placement, its steps, and whether normals are flipped.
const PLACEMENTS: [(&str, &str, bool); 5] = [
    ("plain", "", false),
    ("mirrored", "<scale x='-1'/>", false),
    ("flipped", "", true),
    ("mirrored-flipped", "<scale y='-1'/>", true),
    ("uneven", "<scale x='1.2' y='0.5' z='0.8'/>", false),
];

const TURN: &str = "<rotate y='1' angle='35'/><rotate x='1' angle='-20'/><rotate z='1' angle='10'/>\
                    <translate x='-0.1' y='0.9' z='0.3'/>";

/// A subject in the middle of the stage.
pub fn subject(plugin: &str, file: &str, steps: &str, flips: bool, inside: &str) -> String {
    let mut parts = placed(&format!("<scale value='$size'/>{steps}{TURN}"));
    if !file.is_empty() {
        parts += &string("filename", file);
    }
    if flips {
        parts += &on("flip_normals");
    }
    default("size", "0.7") + &shape(plugin, &(parts + inside))
}

pub fn add(table: &mut Table) {
    for (plugin, file) in PLUGINS {
        for (placement, steps, flips) in PLACEMENTS {
            // A sphere cannot be scaled unevenly.
            if (plugin, placement) != ("sphere", "uneven") {
                let name = format!("{plugin}-{placement}");
                table.show(Shapes, name, subject(plugin, file, steps, flips, &printed()));
            }
        }
    }
    for (name, plugin, file, inside) in [
        ("obj-flat", "obj", "flat.obj", ""),
        ("obj-face-normals", "obj", "smooth.obj", on("face_normals").as_str()),
        ("obj-unflipped-uv", "obj", "smooth.obj", "<boolean name='flip_tex_coords' value='false'/>"),
        ("ply-flat", "ply", "flat.ply", ""),
        ("ply-flipped-uv", "ply", "smooth.ply", on("flip_tex_coords").as_str()),
        ("serialized-second", "serialized", "meshes.serialized", "<integer name='shape_index' value='1'/>"),
    ] {
        table.show(Shapes, name, subject(plugin, file, "", false, &(inside.to_owned() + &printed())));
    }
    let gray = two_sided(&super::diffuse("0.7,0.6,0.3"));
    for (name, plugin, file) in [("obj-bare", "obj", "bare.obj"), ("ply-bare", "ply", "bare.ply")] {
        table.show(Shapes, name, subject(plugin, file, "", false, &gray));
        table.show(Shapes, format!("{name}-mirrored"), subject(plugin, file, "<scale x='-1'/>", false, &gray));
    }
    let glass = bsdf("dielectric", &rgb("specular_transmittance", "0.7,0.9,0.8"));
    for (plugin, file) in [PLUGINS[2], PLUGINS[3], PLUGINS[4]] {
        for (placement, steps, flips) in [PLACEMENTS[0], PLACEMENTS[1], PLACEMENTS[2]] {
            table.show(Shapes, format!("{plugin}-{placement}-glass"), subject(plugin, file, steps, flips, &glass));
        }
    }
    for (placement, steps, _) in [PLACEMENTS[0], PLACEMENTS[1]] {
        let inside = shape("sphere", &("<float name='radius' value='0.6'/>".to_owned() + &printed()))
            + &shape("cube", &(placed("<scale value='0.4'/><translate x='0.9'/>") + &printed()));
        let group = "<shape type='shapegroup' id='group'>".to_owned() + &inside + "</shape>";
        let instance = shape("instance", &(placed(&format!("{steps}{TURN}")) + "<ref id='group'/>"));
        table.show(Shapes, format!("instance-{placement}"), group + &instance);
    }
}
