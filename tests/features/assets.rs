//! Meshes and images that the scenes name, made anew for each run.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use support::volumes;

/// Mesh with normals and texture coordinates.
struct Mesh {
    positions: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    uvs: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
}

/// A closed egg without any symmetry, of radius 1 or a little less.
fn egg(segments: u32, rings: u32) -> Mesh {
    let mut mesh = Mesh { positions: vec![], normals: vec![], uvs: vec![], triangles: vec![] };
    for ring in 0..=rings {
        for segment in 0..=segments {
            let (u, v) = (f64::from(segment) / f64::from(segments), f64::from(ring) / f64::from(rings));
            let (azimuth, polar) = (u * TAU, v * PI);
            let normal = [polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin()];
            let stretch = [1.0 - 0.2 * normal[1], 0.9, 0.8];
            // Vertices on both sides of the seam have equal positions.
            let around = f64::from(segment % segments) / f64::from(segments) * TAU;
            let place = [polar.sin() * around.cos(), normal[1], polar.sin() * around.sin()];
            mesh.positions.push([0, 1, 2].map(|axis| place[axis] * stretch[axis]));
            mesh.normals.push(normal);
            mesh.uvs.push([u, v]);
        }
    }
    for ring in 0..rings {
        for segment in 0..segments {
            let a = ring * (segments + 1) + segment;
            let b = a + segments + 1;
            if ring > 0 {
                mesh.triangles.push([a, a + 1, b]);
            }
            if ring + 1 < rings {
                mesh.triangles.push([a + 1, b + 1, b]);
            }
        }
    }
    mesh
}

impl Mesh {
    fn obj(&self, normals: bool, uvs: bool) -> String {
        let mut text = String::new();
        for [x, y, z] in &self.positions {
            text += &format!("v {x:.6} {y:.6} {z:.6}\n");
        }
        for [u, v] in self.uvs.iter().filter(|_| uvs) {
            text += &format!("vt {u:.6} {v:.6}\n");
        }
        for [x, y, z] in self.normals.iter().filter(|_| normals) {
            text += &format!("vn {x:.6} {y:.6} {z:.6}\n");
        }
        let corner = |at: u32| {
            let at = at + 1;
            match (uvs, normals) {
                (true, true) => format!("{at}/{at}/{at}"),
                (true, false) => format!("{at}/{at}"),
                (false, true) => format!("{at}//{at}"),
                (false, false) => at.to_string(),
            }
        };
        for triangle in &self.triangles {
            text += &format!("f {}\n", triangle.map(corner).join(" "));
        }
        text
    }

    fn ply(&self, normals: bool, uvs: bool) -> String {
        let mut names = vec!["x", "y", "z"];
        names.extend(if normals { &["nx", "ny", "nz"][..] } else { &[] });
        names.extend(if uvs { &["u", "v"][..] } else { &[] });
        let properties: String = names.iter().map(|name| format!("property float {name}\n")).collect();
        let mut text = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\n{properties}element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            self.positions.len(),
            self.triangles.len()
        );
        for at in 0..self.positions.len() {
            let mut row = self.positions[at].to_vec();
            row.extend(self.normals[at].iter().filter(|_| normals));
            row.extend(self.uvs[at].iter().filter(|_| uvs));
            text += &row.iter().map(|number| format!("{number:.6}")).collect::<Vec<_>>().join(" ");
            text.push('\n');
        }
        for [a, b, c] in &self.triangles {
            text += &format!("3 {a} {b} {c}\n");
        }
        text
    }

    /// Mesh of a serialized file in version 4, without the header.
    fn serialized(&self, normals: bool) -> Vec<u8> {
        const SINGLE: u32 = 0x1000;
        const UVS: u32 = 0x2;
        let mut bytes = (SINGLE | UVS | u32::from(normals)).to_le_bytes().to_vec();
        bytes.extend(b"egg\0");
        bytes.extend((self.positions.len() as u64).to_le_bytes());
        bytes.extend((self.triangles.len() as u64).to_le_bytes());
        let normals = self.normals.iter().flatten().filter(|_| normals);
        let floats = self.positions.iter().flatten().chain(normals).chain(self.uvs.iter().flatten());
        bytes.extend(floats.flat_map(|&float| (float as f32).to_le_bytes()));
        bytes.extend(self.triangles.iter().flatten().flat_map(|index| index.to_le_bytes()));
        let mut encoder = ZlibEncoder::new(vec![0x1c, 0x04, 0x04, 0x00], Compression::default());
        encoder.write_all(&bytes).expect("compressed");
        encoder.finish().expect("compressed")
    }
}

/// Serialized file of several meshes.
fn serialized(meshes: &[Vec<u8>]) -> Vec<u8> {
    let (mut bytes, mut offsets) = (Vec::new(), Vec::new());
    for mesh in meshes {
        offsets.extend((bytes.len() as u64).to_le_bytes());
        bytes.extend(mesh);
    }
    bytes.extend(offsets);
    bytes.extend((meshes.len() as u32).to_le_bytes());
    bytes
}

/// Writes all files into `folder`.
pub fn write(folder: &Path) {
    let write = |name: &str, bytes: &[u8]| fs::write(folder.join(name), bytes).expect("a file written");
    let mesh = egg(8, 5);
    for (name, normals, uvs) in [("smooth", true, true), ("flat", false, true), ("bare", false, false)] {
        write(&format!("{name}.obj"), mesh.obj(normals, uvs).as_bytes());
        write(&format!("{name}.ply"), mesh.ply(normals, uvs).as_bytes());
    }
    write("meshes.serialized", &serialized(&[mesh.serialized(true), egg(6, 4).serialized(false)]));
    write("square.obj", b"v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n");
    for (name, points) in [("linearcurve", &LINEAR[..]), ("bsplinecurve", &SPLINE[..])] {
        for (suffix, factor) in [("", 1.0), ("-thicker", 1.02), ("-thick", 1.4)] {
            write(&format!("{name}{suffix}.txt"), curves(points, factor).as_bytes());
        }
    }
    for (name, channels) in [("smoke", 1), ("tinted", 3)] {
        write(&format!("{name}.vol"), &volumes::file([13, 11, 12], &volumes::smoke([13, 11, 12], channels)));
    }
    let measured = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/measured");
    for name in ["isotropic.bsdf", "anisotropic.bsdf"] {
        write(name, &fs::read(measured.join(name)).expect("the file of a measured material"));
    }
    write_images(folder);
}

/// Control points: a bend, an acute one, and a second curve.
const LINEAR: [&[[f64; 4]]; 2] = [
    &[[-0.9, -0.6, 0.0, 0.25], [0.1, 0.7, 0.3, 0.15], [0.9, -0.4, -0.2, 0.3], [0.2, -0.7, 0.5, 0.1]],
    &[[-0.6, 0.8, -0.5, 0.1], [0.8, 0.9, 0.4, 0.2]],
];

/// Control points of a bent spline that shows its open end, and of one that ends in a point.
const SPLINE: [&[[f64; 4]]; 2] = [
    &[
        [-1.6, -1.0, 0.0, 0.3],
        [-0.7, -0.5, 0.4, 0.3],
        [0.0, 0.8, 0.0, 0.2],
        [0.7, -0.5, -0.4, 0.25],
        [1.0, 0.6, 0.2, 0.35],
        [0.9, 1.2, 1.6, 0.3],
    ],
    &[[-1.2, 0.6, -0.5, 0.2], [-0.6, 0.9, -0.3, 0.2], [0.2, 0.9, 0.2, 0.1], [0.8, 0.7, 0.9, 0.0]],
];

/// Text of curves whose radii are multiplied by `factor`.
fn curves(curves: &[&[[f64; 4]]], factor: f64) -> String {
    let point = |[x, y, z, radius]: &[f64; 4]| format!("{x} {y} {z} {:.5}\n", radius * factor);
    let curve = |points: &&[[f64; 4]]| points.iter().map(point).collect::<String>();
    curves.iter().map(curve).collect::<Vec<_>>().join("\n")
}

/// Number in [0, 1] that looks random.
fn noise(x: u32, y: u32, channel: u32) -> f64 {
    let mixed = (x * 73 + y * 179 + channel * 283 + 17).wrapping_mul(2_654_435_761);
    f64::from(mixed >> 16) / 65535.0
}

fn write_images(folder: &Path) {
    let png = |name: &str, side: u32, texel: &dyn Fn(u32, u32) -> [f64; 3]| {
        let bytes = |x, y| image::Rgb(texel(x, y).map(|value| (value * 255.0).round() as u8));
        image::RgbImage::from_fn(side, side, bytes).save(folder.join(name)).expect("an image written");
    };
    png("colors.png", 8, &|x, y| [0, 1, 2].map(|channel| 0.25 + 0.7 * noise(x, y, channel)));
    png("numbers.png", 4, &|x, y| [0.1 + 0.8 * noise(x, y, 3); 3]);
    let phase = |x: u32| f64::from(x) / 16.0 * TAU;
    png("waves.png", 16, &|x, y| [0.5 + 0.25 * phase(x).sin() + 0.2 * (2.0 * phase(y)).cos(); 3]);
    png("normals.png", 16, &|x, y| [0.5 + 0.3 * phase(x).sin(), 0.5 + 0.2 * phase(y).cos(), 0.9]);
    let exr = |name: &str, width: u32, height: u32, texel: &(dyn Fn(u32, u32) -> [f64; 3] + Sync)| {
        let texel = |x: usize, y: usize| <(f32, f32, f32)>::from(texel(x as u32, y as u32).map(|value| value as f32));
        exr::prelude::write_rgb_file(folder.join(name), width as usize, height as usize, texel)
            .expect("an image written");
    };
    exr("lights.exr", 4, 4, &|x, y| [0, 1, 2].map(|channel| 8.0 * noise(x, y, channel).powi(2)));
    // A sky that is brighter above, with a bright patch.
    let sun = |x, y| if (x, y) == (4, 1) { 12.0 } else { 0.0 };
    exr("sky.exr", 16, 8, &|x, y| [0, 1, 2].map(|c| (0.3 + noise(x, y, c)) * (1.0 - f64::from(y) / 9.0) + sun(x, y)));
}
