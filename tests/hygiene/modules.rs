//! Modules of the sources: the paths that each names, resolved to the files that define them.

use std::collections::BTreeMap;

use crate::source::{Source, words};

/// Segments of a path from the crate's root: `["scene", "mesh", "Mesh"]`.
pub type Path = Vec<String>;

/// Modules by path (`scene::mesh`). The library's root is ``, the program's is `main`.
pub struct Modules(pub BTreeMap<String, Module>);

/// Module of one file.
#[derive(Default)]
pub struct Module {
    /// Paths that the file names.
    pub uses: Vec<Path>,
    /// Names that `use` brings in, with their paths.
    imports: BTreeMap<String, Path>,
}

impl Modules {
    /// Modules of `src`. The program's modules see the library as `lodestar`, and share no name with it.
    pub fn new(sources: &[Source]) -> Self {
        let parsed = sources.iter().map(|source| (module_of(&source.path), tokens(&source.code)));
        let parsed: Vec<_> = parsed.map(|(module, tokens)| (module, without_tests(&tokens))).collect();
        let mut modules = Self(parsed.iter().map(|(path, _)| (path.join("::"), Module::default())).collect());
        for (path, tokens) in &parsed {
            let imports = imports(tokens);
            let imports = imports.into_iter().filter_map(|(name, path_in_use)| {
                // A child module is seen by its name, in `use` too.
                Some((name, modules.absolute(path, &path_in_use)?))
            });
            modules.0.entry(path.join("::")).or_default().imports = imports.collect();
        }
        for (path, tokens) in &parsed {
            let named: Vec<Path> =
                named_paths(tokens).iter().filter_map(|named| modules.absolute(path, named)).collect();
            let module = modules.0.entry(path.join("::")).or_default();
            module.uses = module.imports.values().cloned().chain(named).collect();
        }
        modules
    }

    /// File that defines the name at `path`; `None` for a module itself, whose names count one by one.
    pub fn owner(&self, path: &[String]) -> Option<String> {
        let mut path = path.to_vec();
        // No name is re-exported more often.
        for _ in 0..16 {
            // The last segment may be a name beside a module of that name, as a function is that `pub use` brings up.
            let parent = (0..path.len()).rev().find(|&length| self.0.contains_key(&path[..length].join("::")))?;
            let (module, rest) = (path[..parent].join("::"), &path[parent..]);
            match self.0[&module].imports.get(&rest[0]) {
                Some(target) => path = target.iter().chain(&rest[1..]).cloned().collect(),
                None if self.0.contains_key(&path.join("::")) => return None,
                None => return Some(module),
            }
        }
        None
    }

    /// Path from the root of what a file of `module` calls `path`; `None` for other crates.
    fn absolute(&self, module: &[String], path: &[String]) -> Option<Path> {
        let (first, rest) = path.split_first()?;
        let join = |from: &[String]| Some(from.iter().chain(rest).cloned().collect());
        match &first[..] {
            "crate" | "lodestar" => join(&[]),
            "self" => join(module),
            "super" => match rest.first().is_some_and(|next| next == "super") {
                true => self.absolute(module.split_last()?.1, rest),
                false => join(module.split_last()?.1),
            },
            name => {
                let imported = self.0.get(&module.join("::")).and_then(|module| module.imports.get(name));
                let child: Path = module.iter().chain([first]).cloned().collect();
                match imported {
                    Some(imported) => join(imported),
                    None => self.0.contains_key(&child.join("::")).then(|| join(&child))?,
                }
            }
        }
    }
}

/// Path of the module that the file at `path` is.
fn module_of(path: &str) -> Path {
    let name = path.trim_start_matches("src/").trim_end_matches(".rs");
    let name = if name == "lib" { "" } else { name.strip_suffix("/mod").unwrap_or(name) };
    name.split('/').filter(|part| !part.is_empty()).map(str::to_owned).collect()
}

/// Words, `::` and all other characters but white space.
fn tokens(code: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut end = 0;
    for word in words(code) {
        let start = word.text.as_ptr() as usize - code.as_ptr() as usize;
        punctuation(&code[end..start], &mut tokens);
        tokens.push(word.text);
        end = start + word.text.len();
    }
    punctuation(&code[end..], &mut tokens);
    tokens
}

fn punctuation<'a>(mut text: &'a str, tokens: &mut Vec<&'a str>) {
    while let Some(first) = text.chars().next() {
        let length = if text.starts_with("::") { 2 } else { first.len_utf8() };
        if !first.is_whitespace() {
            tokens.push(&text[..length]);
        }
        text = &text[length..];
    }
}

/// Tokens without items that only tests compile, and without what stands in brackets after `pub`.
fn without_tests<'a>(tokens: &[&'a str]) -> Vec<&'a str> {
    let mut kept = Vec::new();
    let mut rest = tokens;
    while let Some((first, after)) = rest.split_first() {
        if rest.starts_with(&["#", "[", "cfg", "(", "test", ")", "]"]) {
            rest = &rest[7 + item_length(&rest[7..])..];
        } else if kept.last() == Some(&"pub") && *first == "(" {
            rest = &rest[1 + rest.iter().position(|&token| token == ")").unwrap_or(0)..];
        } else {
            kept.push(*first);
            rest = after;
        }
    }
    kept
}

/// Tokens up to the end of an item: its `;`, or the brace that closes its body.
fn item_length(tokens: &[&str]) -> usize {
    let mut depth = 0;
    for (at, &token) in tokens.iter().enumerate() {
        match token {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => depth -= 1,
            _ => {}
        }
        if depth == 0 && matches!(token, ";" | "}") {
            return at + 1;
        }
    }
    tokens.len()
}

/// Names that `use` brings in, each with its path.
fn imports(tokens: &[&str]) -> Vec<(String, Path)> {
    let mut imports = Vec::new();
    for (at, _) in tokens.iter().enumerate().filter(|(_, token)| **token == "use") {
        let end = tokens[at..].iter().position(|&token| token == ";").map_or(tokens.len(), |length| at + length);
        add_tree(&tokens[at + 1..end], &[], &mut imports);
    }
    imports
}

/// Adds every leaf of a use-tree below `prefix`. A glob and an unnamed trait keep their whole path as a name.
fn add_tree(tree: &[&str], prefix: &[String], imports: &mut Vec<(String, Path)>) {
    let mut path = prefix.to_vec();
    let mut rest = tree;
    while let Some((&first, after)) = rest.split_first() {
        match first {
            "{" => {
                let body = &after[..after.len().saturating_sub(1)];
                return branches(body).for_each(|branch| add_tree(branch, &path, imports));
            }
            "self" if !path.is_empty() => {}
            "as" => break,
            "::" => {}
            name => path.push(name.to_owned()),
        }
        rest = after;
    }
    let unnamed = matches!(rest.get(1), Some(&"_")) || tree.last() == Some(&"*");
    let name = match rest.get(1) {
        _ if unnamed => path.join("::"),
        Some(&alias) => alias.to_owned(),
        None => path.last().cloned().unwrap_or_default(),
    };
    imports.push((name, path));
}

/// Parts of a use-tree's braces, which commas separate.
fn branches<'a>(body: &'a [&'a str]) -> impl Iterator<Item = &'a [&'a str]> {
    let mut depth = 0;
    body.split(move |&token| {
        depth += i32::from(token == "{") - i32::from(token == "}");
        token == "," && depth == 0
    })
    .filter(|branch| !branch.is_empty())
}

/// Paths of two segments or more that stand in code, outside `use`.
fn named_paths(tokens: &[&str]) -> Vec<Path> {
    let mut paths = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if tokens[at] == "use" {
            at += tokens[at..].iter().position(|&token| token == ";").unwrap_or(1);
        }
        let mut path = vec![tokens[at].to_owned()];
        let is_word = |token: &str| token.chars().all(|c| c.is_alphanumeric() || c == '_');
        let starts = is_word(tokens[at]) && (at == 0 || tokens[at - 1] != "::");
        while starts && tokens.get(at + 1) == Some(&"::") && tokens.get(at + 2).is_some_and(|next| is_word(next)) {
            path.push(tokens[at + 2].to_owned());
            at += 2;
        }
        if path.len() > 1 {
            paths.push(path);
        }
        at += 1;
    }
    paths
}
