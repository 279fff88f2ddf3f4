//! Comparison of the SPIR-V in the published crate with freshly compiled SPIR-V. It runs in the unpacked crate, with
//! `cargo test --release --features shaderc --test shipped`. A checkout has no shipped SPIR-V, so the test fails there.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use lodestar::generated::kernels::{BackEnd, Registry};

#[test]
fn the_shipped_kernels_are_those_that_the_glsl_gives() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("spirv");
    let shipped: BTreeSet<String> = fs::read_dir(&folder)
        .expect("the published crate has a folder spirv; packages/crate.sh makes the crate")
        .map(|entry| entry.expect("an entry").file_name().into_string().expect("a name in UTF-8"))
        .filter(|name| name.ends_with(".spv"))
        .collect();
    let compiled = Registry::built_in();
    let kernels: Vec<_> = BackEnd::ALL.into_iter().flat_map(|back_end| compiled.kernels(back_end).iter()).collect();
    let names: BTreeSet<String> = kernels.iter().map(|kernel| kernel.file.to_owned()).collect();
    assert_eq!(shipped, names);
    for kernel in kernels {
        let bytes = fs::read(folder.join(kernel.file)).expect("a file");
        assert!(bytes == *kernel.spirv, "{} differs from the compiled kernel", kernel.file);
    }
}
