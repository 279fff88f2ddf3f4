//! Comparison of the SPIR-V in the published crate with freshly compiled SPIR-V. It runs in the unpacked crate, with
//! `cargo test --release --features shaderc --test shipped`. A checkout has no shipped SPIR-V, so the test fails there.

use std::fs;
use std::io::Read;
use std::path::Path;

use lodestar::generated::kernels::{BackEnd, Registry};
use ruzstd::StreamingDecoder;

#[test]
fn the_shipped_kernels_are_those_that_the_glsl_gives() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("spirv");
    let list = fs::read_to_string(folder.join("kernels.txt"))
        .expect("the published crate has a folder spirv; packages/crate.sh makes the crate");
    let compressed = fs::read(folder.join("kernels.zst")).expect("the kernels");
    let mut shipped = StreamingDecoder::new(&compressed[..]).expect("a file of zstd");
    let compiled = Registry::built_in();
    let mut kernels: Vec<_> = BackEnd::ALL.into_iter().flat_map(|back_end| compiled.kernels(back_end).iter()).collect();
    for line in list.lines() {
        let (name, bytes) = line.split_once(' ').expect("a name and a number of bytes");
        let mut spirv = vec![0; bytes.parse().expect("a number")];
        shipped.read_exact(&mut spirv).expect("as many bytes as the list says");
        let place = kernels.iter().position(|kernel| kernel.file == name).expect("a kernel of this name");
        assert!(spirv == *kernels.remove(place).spirv, "{name} differs from the compiled kernel");
    }
    assert!(kernels.is_empty(), "the crate lacks {:?}", kernels.iter().map(|kernel| kernel.file).collect::<Vec<_>>());
}
