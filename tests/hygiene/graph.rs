//! Graph of the source files. An edge leads from a file that uses a name to the file that defines it.
//!
//! A name counts for the file that defines it, however many files re-export it. Code that only tests compile is left
//! out, and so is code that macros write.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::modules::{Module, Modules};
use crate::source::Source;

/// Rooms that never reach others, and why.
const NEVER: &[(&[&str], &[&str], &str)] = &[
    (&["scene", "encode", "math", "image", "film"], &["gpu"], "what runs on the CPU knows nothing of the device"),
    (&["generated", "settings", "spirv"], &["gpu"], "plain data knows nothing of the device"),
    (&["gpu"], &["scene", "renderer", "denoise"], "gpu knows nothing of rendering"),
    (&["renderer"], &["fleet"], "a renderer is one device"),
    (&["denoise"], &["gpu", "renderer", "session"], "the denoiser knows pictures only"),
    (&["scene", "encode", "math", "image", "film"], &["denoise"], "nothing but a file has a denoised layer"),
    (&["session", "renderer", "film", "reproduce"], &["view"], "a render knows nothing of who watches it"),
];

/// Most rooms of a chain in which each uses the next.
pub const MOST_LAYERS: usize = 11;

/// Nodes, each with the nodes that it uses.
pub type Edges = BTreeMap<String, BTreeSet<String>>;

/// Files of `sources` by module path (`scene::mesh`), each with the files that it uses.
pub fn files(sources: &[Source]) -> Edges {
    let modules = Modules::new(sources);
    let used = |(name, module): (&String, &Module)| {
        let owners = module.uses.iter().filter_map(|path| modules.owner(path));
        (name.clone(), owners.filter(|owner| owner != name).collect())
    };
    modules.0.iter().map(used).collect()
}

/// Rooms (top-level modules), each with the rooms that it uses. The roots of library and program are no rooms.
pub fn rooms(files: &Edges) -> Edges {
    let mut rooms = Edges::new();
    for (file, used) in files.iter().filter(|(file, _)| !is_root(file)) {
        let used = used.iter().filter(|used| !is_root(used)).map(|used| room(used).to_owned());
        rooms.entry(room(file).into()).or_default().extend(used.filter(|used| used != room(file)));
    }
    rooms
}

fn room(file: &str) -> &str {
    file.split("::").next().unwrap_or_default()
}

fn is_root(file: &str) -> bool {
    file.is_empty() || file == "main"
}

/// Shortest circle through every node that lies on one; each circle once, node by node.
pub fn circles(edges: &Edges) -> Vec<String> {
    let mut seen = BTreeSet::new();
    let circles = edges.keys().filter_map(|node| {
        let circle = chain(edges, node, |other| other == node)?;
        seen.insert(circle.iter().cloned().collect::<BTreeSet<_>>()).then(|| circle.join(" -> "))
    });
    circles.map(|circle| format!("circle: {circle}")).collect()
}

/// Breaches of [`NEVER`], each with the chain of files that leads there.
pub fn reaches(files: &Edges) -> Vec<String> {
    let mut found = Vec::new();
    for &(from, to, reason) in NEVER {
        for file in files.keys().filter(|file| from.contains(&room(file))) {
            if let Some(chain) = chain(files, file, |other| to.contains(&room(other))) {
                found.push(format!("{}, but {reason}", chain.join(" -> ")));
            }
        }
    }
    found
}

/// Shortest chain of one edge or more from `start` to a node that `is_end`.
fn chain(edges: &Edges, start: &str, is_end: impl Fn(&str) -> bool) -> Option<Vec<String>> {
    let mut before: BTreeMap<&str, &str> = BTreeMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(node) = queue.pop_front() {
        for next in edges.get(node).into_iter().flatten() {
            if is_end(next) {
                let mut chain = vec![next.clone(), node.to_owned()];
                let mut last = node;
                while let Some(&previous) = before.get(last).filter(|_| last != start) {
                    chain.push(previous.to_owned());
                    last = previous;
                }
                chain.reverse();
                return Some(chain);
            }
            if !before.contains_key(&next[..]) {
                before.insert(next, node);
                queue.push_back(next);
            }
        }
    }
    None
}

/// Layers of a graph without circles, lowest first: a node lies one layer above the highest that it uses.
pub fn layers(edges: &Edges) -> Vec<Vec<String>> {
    fn layer<'a>(edges: &'a Edges, node: &'a str, known: &mut BTreeMap<&'a str, usize>) -> usize {
        if let Some(&layer) = known.get(node) {
            return layer;
        }
        let above = edges.get(node).into_iter().flatten().map(|used| 1 + layer(edges, used, known)).max();
        known.insert(node, above.unwrap_or(0));
        above.unwrap_or(0)
    }
    let mut known = BTreeMap::new();
    let mut layers: Vec<Vec<String>> = Vec::new();
    for node in edges.keys() {
        let at = layer(edges, node, &mut known);
        layers.resize(layers.len().max(at + 1), Vec::new());
        layers[at].push(node.clone());
    }
    layers
}

/// Layers as text, one a line.
pub fn describe(title: &str, layers: &[Vec<String>]) -> String {
    let line = |(at, nodes): (usize, &Vec<String>)| format!("{:>3}  {}\n", at + 1, nodes.join(" "));
    format!("{title}: {} layers\n{}", layers.len(), layers.iter().enumerate().map(line).collect::<String>())
}

#[cfg(test)]
fn graph(texts: &[(&str, &str)]) -> Edges {
    files(&texts.iter().map(|(path, text)| Source::new(path, text)).collect::<Vec<_>>())
}

#[test]
fn a_planted_circle_is_found() {
    for (b, a) in [
        ("use crate::a::A;", "pub struct A; use crate::b::B;"),
        ("use super::a::{self, A as C};fn f() { a::f() }", "use super::b::{c::C, B};"),
        ("use crate::a; fn f() -> a::A {}", "fn f() { crate::b::g() }"),
        // A function beside the module of its name.
        ("use crate::A;", "use crate::c; fn f() { c::d() }"),
        // By way of another file, and of a name that it re-exports.
        ("use crate::A;", "use crate::c::B;"),
    ] {
        let others = [
            ("src/lib.rs", "pub use a::A; mod a; mod b; mod c;"),
            ("src/c.rs", "mod d; pub use d::d; pub use super::b::*; use crate::b::B;"),
            ("src/c/d.rs", "use crate::b::B; pub fn d() {}"),
        ];
        let edges = graph(&[("src/a.rs", a), ("src/b.rs", b), others[0], others[1], others[2]]);
        assert!(!circles(&edges).is_empty(), "{b} {a}: {edges:?}");
    }
    let edges =
        graph(&[("src/a.rs", "use crate::b::B;"), ("src/b.rs", "use crate::c::C;"), ("src/c.rs", "use crate::a::A;")]);
    assert_eq!(circles(&edges), ["circle: a -> b -> c -> a"]);
}

#[test]
fn a_planted_reach_is_found() {
    let edges = graph(&[
        ("src/film/merge.rs", "use crate::session::Identity;"),
        ("src/session/mod.rs", "pub use identity::Identity;"),
        ("src/session/identity.rs", "fn f() { let a = crate::renderer::state::A; }"),
        ("src/renderer/state.rs", "use super::super::gpu::Buffer;"),
        ("src/gpu/mod.rs", ""),
    ]);
    let chain = "film::merge -> session::identity -> renderer::state -> gpu, but what runs";
    assert!(reaches(&edges).iter().any(|found| found.starts_with(chain)), "{:?}", reaches(&edges));
    let edges = graph(&[
        ("src/gpu/mod.rs", "mod a;"),
        ("src/gpu/a.rs", "use crate::{scene::Scene, Error};"),
        ("src/scene.rs", ""),
    ]);
    assert_eq!(reaches(&edges).len(), 1);
    assert!(reaches(&edges)[0].starts_with("gpu::a -> scene, but gpu knows nothing"), "{:?}", reaches(&edges));
}

#[test]
fn what_is_no_circle_is_not_found() {
    let edges = graph(&[
        ("src/lib.rs", "pub mod a; pub mod b; pub use a::A; pub use b::B;"),
        // Reads a name that `a` re-exports, and one of the crate's root.
        ("src/b.rs", "pub struct B; use crate::a::C; use crate::A; pub(in crate::a) fn f() {}"),
        ("src/a/mod.rs", "mod c; mod d; pub use c::{C, A}; pub use d::D;"),
        ("src/a/c.rs", "#[cfg(test)]\nmod tests { use crate::b::B; fn f() { super::d::f() } }\n// use crate::b;"),
        ("src/a/d.rs", "use super::{c::C, A}; use crate::b; fn f() { b::f(); println!(\"crate::lib\"); }"),
    ]);
    assert_eq!(circles(&edges), Vec::<String>::new(), "{edges:?}");
    assert_eq!(edges["b"], BTreeSet::from(["a::c".to_owned()]));
    assert_eq!(edges["a::d"], BTreeSet::from(["a::c".to_owned(), "b".into()]));
    assert_eq!(layers(&edges).len(), 4, "{edges:?}");
    assert_eq!(
        rooms(&edges),
        Edges::from([("a".into(), BTreeSet::from(["b".into()])), ("b".into(), BTreeSet::from(["a".into()]))])
    );
}
