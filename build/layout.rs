//! Writer of assertions that the structs of `layout.rs` have the same layout in GLSL.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::kernels::{BackEnd, Kernel};

/// Assertions on the size and the member offsets of each reflected struct.
pub fn code(kernels: &[Kernel]) -> String {
    let mut structs = BTreeMap::new();
    for kernel in kernels.iter().filter(|kernel| !kernel.is_test()) {
        structs.extend(&kernel.module(BackEnd::Storage).interface.structs);
    }
    let mut code = String::new();
    for (name, (size, members)) in structs {
        let _ = writeln!(
            code,
            "const _: () = {{\n    use self::{name} as S;\n    \
             assert!(size_of::<S>() == {size}, \"size of {name} differs from the GLSL\");"
        );
        for (member, offset) in members {
            let _ = writeln!(
                code,
                "    assert!(std::mem::offset_of!(S, {member}) == {offset}, \"{name}::{member} lies elsewhere in the GLSL\");"
            );
        }
        code.push_str("};\n");
    }
    code
}
