//! Words and crates that few modules may name. The test `graph` checks which modules may use which others.

use crate::source::{Source, Word, words};

/// A word and the modules in which it may stand.
struct Rule {
    word: Name,
    /// The only modules in which the word may stand.
    only_in: &'static [&'static str],
    reason: &'static str,
}

enum Name {
    /// The word wherever it stands.
    Word(&'static str),
    /// The word as the first part of a path, or in `use`: a crate, whatever modules may share its name.
    Crate(&'static str),
}

const RULES: &[Rule] = &[
    // `denoise/library` is the C interface of a library that is loaded at run time; the rest of `denoise` is safe code.
    Rule {
        word: Name::Word("unsafe"),
        only_in: &["gpu", "denoise/library"],
        reason: "unsafe code is argued for in one place per library",
    },
    Rule {
        word: Name::Crate("libloading"),
        only_in: &["denoise/library"],
        reason: "the denoiser's library is loaded in one place",
    },
    Rule { word: Name::Word("vk"), only_in: &["gpu"], reason: "Vulkan is called in one place" },
    Rule { word: Name::Crate("ash"), only_in: &["gpu"], reason: "Vulkan is called in one place" },
    Rule { word: Name::Crate("gpu_allocator"), only_in: &["gpu"], reason: "Vulkan is called in one place" },
    Rule { word: Name::Crate("exr"), only_in: &["image"], reason: "EXR files are read in one place" },
    Rule { word: Name::Crate("clap"), only_in: &["cli"], reason: "the library knows no command line" },
    Rule { word: Name::Crate("indicatif"), only_in: &["cli"], reason: "the library knows no command line" },
    Rule { word: Name::Crate("plotters"), only_in: &["reproduce"], reason: "only the paper's figures are plotted" },
    Rule { word: Name::Crate("hyper"), only_in: &["view"], reason: "the page is served in one place" },
    Rule { word: Name::Crate("hyper_util"), only_in: &["view"], reason: "the page is served in one place" },
    Rule { word: Name::Crate("tokio"), only_in: &["view"], reason: "the page is served in one place" },
    Rule { word: Name::Crate("mpi"), only_in: &["fleet/mpi"], reason: "MPI is called in one place" },
    Rule { word: Name::Crate("obvhs"), only_in: &["encode"], reason: "the hierarchy is built in one place" },
    Rule { word: Name::Crate("support"), only_in: &[], reason: "twins are for tests only" },
];

/// Violations of the rules in `sources`, one line each.
pub fn violations(sources: &[Source]) -> Vec<String> {
    sources.iter().flat_map(|source| RULES.iter().flat_map(move |rule| rule.violations(source))).collect()
}

impl Rule {
    fn violations(&self, source: &Source) -> Vec<String> {
        if self.only_in.iter().any(|module| is_in(source, module)) {
            return Vec::new();
        }
        let lines = self.word.lines(&source.code);
        lines.map(|line| format!("{}:{line}: names {}, but {}", source.path, self.word.text(), self.reason)).collect()
    }
}

impl Name {
    fn text(&self) -> &'static str {
        match self {
            Self::Word(text) | Self::Crate(text) => text,
        }
    }

    fn lines<'a>(&'a self, code: &'a str) -> impl Iterator<Item = usize> + 'a {
        let found = words(code).filter(|word| word.text == self.text());
        let is_local = imports_namesake(code, self.text());
        let counts = move |word: &Word| match self {
            Self::Word(_) => true,
            Self::Crate(_) => is_crate(word, is_local),
        };
        found.filter(counts).map(|word| word.line)
    }
}

/// Whether `code` brings in a module of its own that is called like the crate `name`, as `use crate::image::exr;` does.
fn imports_namesake(code: &str, name: &str) -> bool {
    code.split(';').filter_map(|statement| Some(statement.split_once("use ")?.1)).any(|path| {
        let mut parts = words(path);
        parts.next().is_some_and(|first| first.text != name) && parts.any(|part| part.text == name)
    })
}

/// Whether `word` means the crate of that name; a bare `word::` does unless a module `is_local` under it.
fn is_crate(word: &Word, is_local: bool) -> bool {
    let statement = word.before.rsplit(';').next().unwrap_or_default();
    if let Some(parent) = statement.strip_suffix("::") {
        // `::word` starts at the crates, `parent::word` lies within something else.
        return words(parent).last().is_none_or(|last| !parent.ends_with(last.text) || last.text == "use");
    }
    match words(statement).last() {
        Some(last) if last.text == "use" || last.text == "crate" => statement.ends_with(last.text),
        _ if words(statement).any(|earlier| earlier.text == "use") => false,
        _ => word.after.trim_start().starts_with("::") && !is_local,
    }
}

/// Whether the file is the module `module` of the library, or lies below it.
fn is_in(source: &Source, module: &str) -> bool {
    source.path == format!("src/{module}.rs") || source.path.starts_with(&format!("src/{module}/"))
}

#[cfg(test)]
fn found(path: &str, text: &str) -> usize {
    violations(&[Source::new(path, text)]).len()
}

#[test]
fn bad_snippets_are_found() {
    for (path, text) in [
        ("src/cli/devices.rs", "use lodestar::gpu::vk;"),
        ("src/renderer/mod.rs", "unsafe { f() }"),
        ("src/generated/layout.rs", "unsafe impl Pod for A {}"),
        ("src/denoise/mod.rs", "unsafe { f() }"),
        ("src/denoise/search.rs", "unsafe { f() }"),
        ("src/denoise/search.rs", "use libloading::Library;"),
        ("src/gpu/device.rs", "use libloading::Library;"),
        ("src/renderer/mod.rs", "use ash::Entry;"),
        ("src/renderer/mod.rs", "fn f(b: ::ash::Entry) {}"),
        ("src/renderer/mod.rs", "use gpu_allocator as allocator;"),
        ("src/film/picture.rs", "use exr::prelude::*;"),
        ("src/film/picture.rs", "use ::exr::prelude::*;"),
        ("src/film/picture.rs", "let a = [::exr::prelude::read()];"),
        ("src/film/picture.rs", "extern crate exr;"),
        ("src/film/picture.rs", "fn f() { let a = exr::prelude::read(); }"),
        ("src/film/picture.rs", "use crate::image::exr; fn f() { let a = ::exr::prelude::read(); }"),
        ("src/scene/mod.rs", "obvhs::Bvh2::default()"),
        ("src/session/run.rs", "use hyper::Request;"),
        ("src/settings/value.rs", "use clap::ValueEnum;"),
        ("src/math/mod.rs", "use support::twins::fresnel;"),
    ] {
        assert_eq!(found(path, text), 1, "{path}: {text}");
    }
}

#[test]
fn good_snippets_are_not() {
    for (path, text) in [
        ("src/scene/mod.rs", "/// Knows nothing of ash.\nconst A: &str = \"ash::vk\"; let vk_like = 1;"),
        ("src/gpu/mod.rs", "use ash::vk; use gpu_allocator::MemoryLocation; unsafe { f() }"),
        ("src/lib.rs", "#![deny(unsafe_op_in_unsafe_fn)] pub mod gpu; pub mod scene; pub mod bvh;"),
        ("src/image/exr.rs", "use ::exr::prelude::*;"),
        ("src/denoise/library.rs", "use libloading::Library; unsafe { f() }"),
        ("src/cli/render.rs", "use lodestar::image::{exr, png}; fn f() { exr::read_rgb(); }"),
        ("src/cli/render.rs", "fn f(exr: bool) { let exr = 1; crate::image::exr::read_rgb(); }"),
        ("src/cli/compare.rs", "use lodestar::image::exr; fn f() { exr::read_rgb(); image::exr::read_rgb(); }"),
        ("src/encode/bvh.rs", "use obvhs::cwbvh::CwBvh;"),
        ("src/renderer/mod.rs", "let hash = 1; use crate::gpu::Context; use crate::scene::Scene;"),
    ] {
        assert_eq!(found(path, text), 0, "{path}: {text}");
    }
}
