//! Option `--kernel-dir`: edited files from `inspect --out` replace the built-in kernels.

use std::fs;
use std::path::Path;
use std::process::Output;
use std::sync::OnceLock;

use lodestar::image::{Image, exr};
use rspirv::binary::Assemble;
use rspirv::dr::{self, Instruction, Operand};
use rspirv::spirv::{Decoration, Op};

use crate::support::{Folder, assert_quiet_success, assert_sentence, attribute};

/// Arguments of a render. Russian roulette starts at the first bounce, so that it matters here.
const RENDER: [&str; 8] = ["render", "scene.xml", "--quiet", "--spp", "16", "--rr-depth", "1", "--sampler"];

/// Files of the back ends for the own traversal. Each device reads one of them.
const FILES: [&str; 2] = ["kernels/trace.spv", "kernels/trace.texel.spv"];

/// Folder with the files that `inspect --out` writes. The program writes them once for all tests.
fn folder_with_kernels() -> Folder {
    static WRITTEN: OnceLock<Vec<(String, Vec<u8>)>> = OnceLock::new();
    let written = WRITTEN.get_or_init(|| {
        let folder = Folder::new();
        // The variants, which take most of the time, are not needed.
        let output = folder.without_tools(&["inspect", "--out", "kernels"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        folder.names().into_iter().map(|name| (name.clone(), fs::read(folder.path(&name)).unwrap())).collect()
    });
    let folder = Folder::new();
    for (name, content) in written {
        let path = folder.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }
    folder
}

fn edit(path: &Path, change: impl Fn(&mut Instruction)) {
    let mut module = dr::load_bytes(fs::read(path).unwrap()).unwrap();
    module.all_inst_iter_mut().for_each(change);
    let bytes: Vec<u8> = module.assemble().iter().flat_map(|word| word.to_le_bytes()).collect();
    fs::write(path, bytes).unwrap();
}

fn render(folder: &Folder, output: &str, arguments: &[&str]) -> Output {
    folder.run(&[&RENDER[..], &["bsdf", "-o", output], arguments].concat())
}

fn picture(folder: &Folder, name: &str) -> Image {
    exr::read_rgb(&folder.path(name)).unwrap()
}

/// Fails unless standard error has one line per file that this device does not read, and no other.
fn assert_only_unused(output: &Output) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && output.stdout.is_empty(), "{said}");
    assert!(said.lines().all(|line| line.contains("not used, because this render reads")), "{said}");
}

fn mean(image: &Image) -> f64 {
    let sum: f64 = image.pixels.iter().flatten().map(|&value| f64::from(value)).sum();
    sum / (3 * image.pixels.len()) as f64
}

#[test]
fn what_inspect_wrote_renders_the_same() {
    let folder = folder_with_kernels();
    assert_only_unused(&render(&folder, "own.exr", &["--kernel-dir", "kernels"]));
    assert_quiet_success(&render(&folder, "plain.exr", &[]));
    assert_eq!(picture(&folder, "own.exr"), picture(&folder, "plain.exr"));
    assert!(attribute(&folder.path("own.exr"), "replaced_kernels").contains("trace."));
    let plain = exr::read_attributes(&folder.path("plain.exr")).unwrap();
    assert!(plain.iter().all(|(name, _)| name != "replaced_kernels"));
}

#[test]
fn an_edited_constant_changes_the_picture() {
    let folder = folder_with_kernels();
    // The edited constant is the maximum probability of survival. The picture is unbiased at any value above 0, so the
    // mean stays.
    let change = |i: &mut Instruction| {
        if i.class.opcode == Op::Constant && i.operands == [Operand::LiteralBit32(0.95_f32.to_bits())] {
            i.operands = vec![Operand::LiteralBit32(0.3_f32.to_bits())];
        }
    };
    FILES.iter().for_each(|file| edit(&folder.path(file), change));
    assert_only_unused(&render(&folder, "edited.exr", &["--kernel-dir", "kernels"]));
    assert_quiet_success(&render(&folder, "plain.exr", &[]));
    let (edited, plain) = (picture(&folder, "edited.exr"), picture(&folder, "plain.exr"));
    assert_ne!(edited, plain);
    assert!((mean(&edited) / mean(&plain) - 1.0).abs() < 0.1, "{} and {}", mean(&edited), mean(&plain));
}

#[test]
fn a_render_goes_on_with_the_kernels_it_was_begun_with() {
    let folder = folder_with_kernels();
    let begin = ["--kernel-dir", "kernels", "--checkpoint", "a.ckpt"];
    assert_only_unused(&render(&folder, "a.exr", &begin));
    let go_on = ["resume", "a.ckpt", "--quiet", "--spp", "24"];
    assert_sentence(&folder.run(&go_on), 1, &["trace.", "the built-in kernels", "--kernel-dir"]);
    fs::rename(folder.path("kernels"), folder.path("moved")).unwrap();
    assert_only_unused(&folder.run(&[&go_on[..], &["--kernel-dir", "moved"]].concat()));
    assert_eq!(crate::resume::samples_in(&folder.path("a.ckpt")), 24);
}

#[test]
fn an_edited_binding_is_refused() {
    let folder = folder_with_kernels();
    let change = |i: &mut Instruction| {
        let is_first = i.class.opcode == Op::Decorate
            && i.operands[1..] == [Operand::Decoration(Decoration::Binding), Operand::LiteralBit32(0)];
        if is_first {
            i.operands[2] = Operand::LiteralBit32(77);
        }
    };
    edit(&folder.path(FILES[1]), change);
    let before = folder.names();
    for command in [&RENDER[..7], &["inspect"]] {
        let output = folder.run(&[command, &["--kernel-dir", "kernels"]].concat());
        assert_sentence(&output, 1, &["trace.texel.spv", "set 0, binding 77 (`FilmRadiancePage`)"]);
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn a_folder_without_kernels_is_told() {
    let folder = Folder::new();
    fs::create_dir(folder.path("empty")).unwrap();
    fs::create_dir(folder.path("other")).unwrap();
    folder.write("other/path_tracer.spv", "");
    for (name, words) in
        [("empty", "no file has the name of a kernel"), ("other", "path_tracer.spv: no kernel has this name")]
    {
        let output = render(&folder, "a.exr", &["--kernel-dir", name]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && said.contains("lodestar: warning: ") && said.contains(words), "{said}");
    }
    assert_sentence(&render(&folder, "a.exr", &["--kernel-dir", "missing"]), 1, &["missing"]);
}

#[test]
fn inspect_shows_the_edited_kernel() {
    let folder = folder_with_kernels();
    let change = |i: &mut Instruction| {
        if i.class.opcode == Op::FMul {
            i.class = rspirv::grammar::INSTRUCTION_TABLE.get(Op::FAdd);
        }
    };
    edit(&folder.path(FILES[0]), change);
    let count = |arguments: &[&str]| {
        let output =
            folder.without_tools(&[&["inspect", "trace", "--back-end", "storage", "--json"], arguments].concat());
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        report["kernels"][0]["histogram"]["operations"].clone()
    };
    let (own, edited) = (count(&[]), count(&["--kernel-dir", "kernels"]));
    let of = |operations: &serde_json::Value, name: &str| operations[name].as_u64().unwrap_or(0);
    assert_eq!(of(&edited, "FAdd"), of(&own, "FAdd") + of(&own, "FMul"));
    assert_eq!(of(&edited, "FMul"), 0);
}
