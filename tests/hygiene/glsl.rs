//! Bindings are named only in the file that declares them, among the files that one kernel includes. Neither files nor folders
//! include each other in circles.

use std::collections::{BTreeMap, BTreeSet};

use crate::graph::Edges;
use crate::source::{Source, words};

/// Folder that includes are relative to.
const FOLDER: &str = "glsl/include/";

/// Violations of the rule in `sources`, one line each.
pub fn violations(sources: &[Source]) -> Vec<String> {
    let kernels = sources.iter().filter(|source| source.path.ends_with(".comp"));
    let found: BTreeSet<_> = kernels.flat_map(|kernel| kernel_violations(&included(kernel, sources))).collect();
    found.into_iter().collect()
}

/// Files below [`FOLDER`], each with the files that it includes. What is written at build time counts for nobody.
pub fn includes(sources: &[Source]) -> Edges {
    let file = |source: &Source| {
        let names = include_names(&source.text).into_iter().filter(|name| !name.starts_with("generated/"));
        Some((source.path.strip_prefix(FOLDER)?.to_owned(), names.collect()))
    };
    sources.iter().filter_map(file).collect()
}

/// Folders of the files in `includes`, each with the folders whose files it includes.
pub fn folders(includes: &Edges) -> Edges {
    let folder = |file: &str| file.split('/').next().unwrap_or_default().to_owned();
    let mut folders = Edges::new();
    for (file, used) in includes {
        let used = used.iter().map(|used| folder(used)).filter(|used| *used != folder(file));
        folders.entry(folder(file)).or_default().extend(used);
    }
    folders
}

fn kernel_violations(files: &[&Source]) -> Vec<String> {
    let mut owners = BTreeMap::<&str, Vec<&str>>::new();
    for file in files {
        for name in declared_names(&file.code) {
            owners.entry(name).or_default().push(&file.path);
        }
    }
    let mut violations = Vec::new();
    for file in files {
        // A word after a point is a member of another structure.
        for word in words(&file.code).filter(|word| !word.before.ends_with('.')) {
            let Some(owners) = owners.get(word.text) else { continue };
            if !owners.contains(&file.path.as_str()) {
                let (path, line, name, owner) = (&file.path, word.line, word.text, owners.join(", "));
                violations
                    .push(format!("{path}:{line}: names {name}, the binding that {owner} declares and alone may name"));
            }
        }
    }
    violations
}

/// The kernel with every file that it includes, directly or not.
fn included<'a>(kernel: &'a Source, sources: &'a [Source]) -> Vec<&'a Source> {
    let mut files = vec![kernel];
    let mut next = 0;
    while next < files.len() {
        for name in include_names(&files[next].text) {
            for source in sources.iter().filter(|source| is_named(source, &name)) {
                if !files.iter().any(|file| file.path == source.path) {
                    files.push(source);
                }
            }
        }
        next += 1;
    }
    files
}

fn include_names(text: &str) -> Vec<String> {
    let lines =
        text.lines().filter_map(|line| line.trim_start().strip_prefix('#')?.trim_start().strip_prefix("include"));
    let names = lines.filter_map(|rest| rest.split(['"', '<', '>']).nth(1));
    names.map(|name| name.trim_start_matches("./").trim_start_matches("../").to_owned()).collect()
}

fn is_named(source: &Source, name: &str) -> bool {
    source.path.strip_suffix(name).is_some_and(|folder| folder.ends_with('/'))
}

/// Names by which `code` reaches the bindings that it declares: the variable, the block's instance, or the members of a
/// block without an instance.
fn declared_names(code: &str) -> Vec<&str> {
    let mut names = Vec::new();
    for (start, _) in code.match_indices("layout") {
        let Some((qualifiers, rest)) = parenthesized(&code[start + "layout".len()..]) else { continue };
        if !words(qualifiers).any(|word| word.text == "binding") {
            continue;
        }
        match rest.find([';', '{']) {
            Some(end) if rest[end..].starts_with('{') => names.extend(block_names(&rest[end + 1..])),
            Some(end) => names.extend(last_name(&rest[..end])),
            None => {}
        }
    }
    names
}

/// Splits `(a) b` into `a` and `b`.
fn parenthesized(text: &str) -> Option<(&str, &str)> {
    let inside = text.trim_start().strip_prefix('(')?;
    let mut depth = 1;
    for (position, c) in inside.char_indices() {
        depth += match c {
            '(' => 1,
            ')' => -1,
            _ => 0,
        };
        if depth == 0 {
            return Some((&inside[..position], &inside[position + 1..]));
        }
    }
    None
}

/// The names by which a block is reached, given what follows its opening brace.
fn block_names(text: &str) -> Vec<&str> {
    let Some((members, rest)) = text.split_once('}') else { return Vec::new() };
    let instance = rest.split(';').next().and_then(last_name);
    match instance {
        Some(instance) => vec![instance],
        None => members.split(';').filter_map(last_name).collect(),
    }
}

/// The name in a declaration such as `readonly uint counts[4]`: the last word before any bracket.
fn last_name(declaration: &str) -> Option<&str> {
    words(declaration.split('[').next()?).last().map(|word| word.text)
}

#[cfg(test)]
const GRID: &str = "layout(set = 2, binding = 0, scalar) buffer Cells { float cell_radiance[]; };\n\
                    layout(set = SET, binding = 1) uniform usamplerBuffer nodes;\n\
                    layout(set = 2, binding = 2) readonly buffer Counts { uint a; } counts[2];\n\
                    layout(local_size_x = 8) in;\n";

#[cfg(test)]
fn found(kernel: &str) -> Vec<String> {
    violations(&[
        Source::new("glsl/include/grid.glsl", GRID),
        Source::new("glsl/include/pure.glsl", "#include \"grid.glsl\"\nfloat f(float cell) { return cell; }"),
        Source::new("glsl/k.comp", &format!("#include \"include/pure.glsl\"\n{kernel}")),
        Source::new(
            "glsl/test/unrelated.comp",
            "layout(set = 0, binding = 0) buffer Out { float nodes[]; };\nnodes[0] = 1.0;",
        ),
    ])
}

#[test]
fn names_of_every_kind_of_declaration() {
    assert_eq!(declared_names(GRID), ["cell_radiance", "nodes", "counts"]);
    let two = "layout(binding = (1 + 2)) buffer B { vec4 first[4]; uint second; };";
    assert_eq!(declared_names(two), ["first", "second"]);
}

#[test]
fn bad_snippets_are_found() {
    for kernel in ["void main() { cell_radiance[0] = 1.0; }", "texelFetch(nodes, 0);", "uint a = counts[1].a;"] {
        let violations = found(kernel);
        assert_eq!(violations.len(), 1, "{kernel}: {violations:?}");
        assert!(violations[0].starts_with("glsl/k.comp:2: names "), "{}", violations[0]);
    }
}

#[test]
fn good_snippets_are_not() {
    for kernel in ["// cell_radiance[0]\nfloat b = f(a);", "hit.nodes = 1; my_counts = 2;"] {
        assert_eq!(found(kernel), Vec::<String>::new(), "{kernel}");
    }
}

#[test]
fn a_planted_circle_of_includes_is_found() {
    let found = |texts: &[(&str, &str)]| {
        let sources: Vec<_> = texts.iter().map(|(path, text)| Source::new(path, text)).collect();
        let files = includes(&sources);
        [&files, &folders(&files)].map(crate::graph::circles)
    };
    let grid = ("glsl/include/guide/grid.glsl", "#include \"math/direction.glsl\"\n#include \"generated/grid.glsl\"");
    let direction = ("glsl/include/math/direction.glsl", "");
    let sampler = ("glsl/include/guide/sampler.glsl", "#include \"light/light.glsl\"");
    let light = ("glsl/include/light/light.glsl", "#include \"guide/grid.glsl\"");
    assert_eq!(found(&[grid, direction, light]), [[""; 0]; 2]);
    let [files, folders] = found(&[grid, direction, light, sampler]);
    assert_eq!((files.len(), &folders[..]), (0, &["circle: guide -> light -> guide".to_owned()][..]));
    let [files, _] = found(&[("glsl/include/math/direction.glsl", "#include \"guide/grid.glsl\""), grid]);
    assert_eq!(files, ["circle: guide/grid.glsl -> math/direction.glsl -> guide/grid.glsl"]);
}
