//! Rules for the documents: links lead somewhere, the book has all pages, and each page says whom it is for.

use std::collections::BTreeMap;
use std::path::Path;

use crate::source::{Source, read_all};

/// Folder of the book's pages.
const BOOK: &str = "docs/";
/// Table of contents of the book.
const CONTENTS: &str = "docs/SUMMARY.md";
/// Page with the paper map.
const METHOD: &str = "docs/method.md";
const PAPER_MAP: &str = "## Paper map";
/// Most bytes of a picture, and of all pictures together.
const MOST_PER_PICTURE: u64 = 200_000;
const MOST_PICTURES: u64 = 3_000_000;

/// Document in Markdown.
pub struct Page {
    /// Path within the repository.
    pub path: String,
    pub text: String,
}

/// Pages of the book, and the documents in the root.
pub fn read_pages(root: &Path) -> Vec<Page> {
    let page = |source: Source| Page { path: source.path, text: source.text };
    let in_root = |name: &str| Page { path: name.into(), text: std::fs::read_to_string(root.join(name)).unwrap() };
    let pages = read_all(root, BOOK.trim_end_matches('/'), "md").into_iter().map(page);
    pages.chain(["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md"].map(in_root)).collect()
}

/// Links that lead nowhere, pages that the book lacks, and pages that do not say whom they are for. `exists` tells
/// whether the repository has a file or folder.
pub fn violations(pages: &[Page], exists: &dyn Fn(&str) -> bool) -> Vec<String> {
    let anchors: BTreeMap<&str, Vec<String>> = pages.iter().map(|page| (&page.path[..], anchors(&page.text))).collect();
    let mut found = Vec::new();
    let mut in_contents = Vec::new();
    for page in pages {
        for (line, target) in links(&page.text) {
            match follow(page, &target, &anchors, exists) {
                Ok(Some(path)) if page.path == CONTENTS => in_contents.push(path),
                Ok(_) => {}
                Err(reason) => found.push(format!("{}:{line}: the link to {target} {reason}", page.path)),
            }
        }
    }
    for page in pages.iter().filter(|page| page.path.starts_with(BOOK) && page.path != CONTENTS) {
        if in_contents.iter().filter(|path| **path == page.path).count() != 1 {
            found.push(format!("{}: must stand once in {CONTENTS}", page.path));
        }
        if !says_whom_it_is_for(&page.text) {
            found.push(format!("{}: the first sentence must say whom the page is for: \"For ...\"", page.path));
        }
    }
    found
}

/// Path in the repository to which a link leads; `None` for a link to another host. Otherwise the reason why it leads nowhere.
fn follow(
    page: &Page,
    target: &str,
    anchors: &BTreeMap<&str, Vec<String>>,
    exists: &dyn Fn(&str) -> bool,
) -> Result<Option<String>, &'static str> {
    if target.starts_with("https://") || target.starts_with("http://") {
        return Ok(None);
    }
    let (file, anchor) = target.split_once('#').map_or((target, None), |(file, anchor)| (file, Some(anchor)));
    let path =
        if file.is_empty() { page.path.clone() } else { resolve(&page.path, file).ok_or("leaves the repository")? };
    if page.path.starts_with(BOOK) && !path.starts_with(BOOK) {
        return Err("leaves the book");
    }
    if !exists(&path) {
        return Err("names no file");
    }
    match anchor {
        Some(anchor) if !anchors.get(&path[..]).is_some_and(|of_page| of_page.iter().any(|known| known == anchor)) => {
            Err("names no heading")
        }
        _ => Ok(Some(path)),
    }
}

/// Path in the repository of the `file` that the document at `from` names; `None` outside of it.
fn resolve(from: &str, file: &str) -> Option<String> {
    let mut parts: Vec<&str> = from.split('/').collect();
    parts.pop();
    for part in file.split('/').filter(|part| !part.is_empty()) {
        match part {
            "." => {}
            ".." => drop(parts.pop()?),
            name => parts.push(name),
        }
    }
    Some(parts.join("/"))
}

/// Targets of the links and pictures in a document, with their lines.
fn links(text: &str) -> Vec<(usize, String)> {
    let mut links = Vec::new();
    for (line, text) in (1..).zip(without_code(text).lines()) {
        for rest in text.split("](").skip(1) {
            links.extend(rest.split_once(')').map(|(target, _)| (line, target.to_owned())));
        }
    }
    links
}

/// Anchors of a document's headings, as GitHub and mdBook form them.
fn anchors(text: &str) -> Vec<String> {
    let mut anchors: Vec<String> = Vec::new();
    for line in without_fences(text).lines().filter(|line| line.starts_with('#')) {
        let heading = without_link_targets(line.trim_start_matches('#').trim());
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        let anchor: String = kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect();
        let numbered = |number: usize| if number == 0 { anchor.clone() } else { format!("{anchor}-{number}") };
        let free = (0..).map(numbered).find(|candidate| !anchors.contains(candidate));
        anchors.extend(free);
    }
    anchors
}

/// Heading without the targets of its links: `[text](target)` becomes `[text]`.
fn without_link_targets(heading: &str) -> String {
    let mut parts = heading.split("](");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| text + part.split_once(')').map_or(part, |(_, after)| after))
}

/// Text with empty lines in place of fenced code.
fn without_fences(text: &str) -> String {
    let mut fenced = false;
    let mut kept = String::new();
    for line in text.lines() {
        let is_fence = line.trim_start().starts_with("```");
        if !fenced && !is_fence {
            kept += line;
        }
        fenced ^= is_fence;
        kept.push('\n');
    }
    kept
}

/// Text without fenced code and without code between backticks. Line breaks stay. Code ends with its paragraph at the latest.
fn without_code(text: &str) -> String {
    let (mut in_code, mut kept, mut last) = (false, String::new(), ' ');
    for c in without_fences(text).chars() {
        match c {
            '`' => in_code = !in_code,
            '\n' => {
                in_code &= last != '\n';
                kept.push(c);
            }
            _ if in_code => {}
            _ => kept.push(c),
        }
        last = c;
    }
    kept
}

/// Whether the first paragraph after the title begins with "For".
fn says_whom_it_is_for(text: &str) -> bool {
    let mut lines = text.lines().filter(|line| !line.trim().is_empty());
    lines.next().is_some_and(|title| title.starts_with("# "))
        && lines.next().is_some_and(|line| line.starts_with("For "))
}

/// Files and functions that the paper map names and the repository lacks. `sources` are all files that it may name.
pub fn paper_map_violations(pages: &[Page], sources: &[Source]) -> Vec<String> {
    let Some(page) = pages.iter().find(|page| page.path == METHOD) else { return vec![format!("{METHOD} is missing")] };
    let Some((_, map)) = page.text.split_once(PAPER_MAP) else {
        return vec![format!("{METHOD}: `{PAPER_MAP}` is missing")];
    };
    let rows: Vec<_> = map.lines().filter(|line| line.starts_with('|')).skip(2).collect();
    if rows.is_empty() {
        return vec![format!("{METHOD}: the paper map has no rows")];
    }
    rows.into_iter().flat_map(|row| row_violations(row, sources)).collect()
}

fn row_violations(row: &str, sources: &[Source]) -> Vec<String> {
    let names: Vec<&str> = row.split('`').skip(1).step_by(2).collect();
    let (files, others): (Vec<&str>, Vec<&str>) =
        names.iter().partition(|name| [".glsl", ".comp", ".rs"].iter().any(|end| name.ends_with(end)));
    let is_named = |source: &&Source, file: &str| source.path == file || source.path.ends_with(&format!("/{file}"));
    let of_row: Vec<&Source> =
        files.iter().filter_map(|file| sources.iter().find(|source| is_named(source, file))).collect();
    let lost = files.iter().filter(|file| !sources.iter().any(|source| is_named(&source, file)));
    let mut found: Vec<_> = lost.map(|file| format!("{METHOD}: no file {file}: {row}")).collect();
    let is_function = |name: &&&str| name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
    let has = |source: &&Source, name: &str| source.code.contains(&format!("{name}("));
    let unknown = others.iter().filter(is_function).filter(|name| !of_row.iter().any(|source| has(source, name)));
    found.extend(unknown.map(|name| format!("{METHOD}: no file of the row has {name}(): {row}")));
    found
}

/// Pictures of the book that are too large, or that no page shows. `sizes` are their paths and bytes.
pub fn picture_violations(pages: &[Page], sizes: &[(String, u64)]) -> Vec<String> {
    let shown: Vec<String> = pages
        .iter()
        .flat_map(|page| links(&page.text).into_iter().filter_map(|(_, target)| resolve(&page.path, &target)))
        .collect();
    let mut found = Vec::new();
    for (path, bytes) in sizes {
        if *bytes > MOST_PER_PICTURE {
            found.push(format!("{path}: {bytes} bytes, more than {MOST_PER_PICTURE}"));
        }
        if !shown.contains(path) {
            found.push(format!("{path}: no page shows it"));
        }
    }
    let all: u64 = sizes.iter().map(|(_, bytes)| bytes).sum();
    if all > MOST_PICTURES {
        found.push(format!("{BOOK}: {all} bytes of pictures, more than {MOST_PICTURES}"));
    }
    found
}

/// Paths and sizes of the files of the book that are not pages.
pub fn read_pictures(root: &Path) -> Vec<(String, u64)> {
    let folder = format!("{BOOK}pictures");
    let entries = std::fs::read_dir(root.join(&folder)).unwrap().map(Result::unwrap);
    entries
        .map(|entry| (format!("{folder}/{}", entry.file_name().to_str().unwrap()), entry.metadata().unwrap().len()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUMMARY: &str = "# Book\n\n- [A](a.md)\n- [B](lab/b.md)\n";
    const A: &str =
        "# A\n\nFor all. See [B](lab/b.md#two-words), [below](#end) and [the web](https://example.org/x).\n\n## End\n";
    const B: &str = "# B\n\nFor few.\n\n## Two `words`!\n\n[up](../a.md#end) ![picture](../pictures/p.png)\n";

    /// Violations of a book of two pages, of which one text is replaced.
    fn found(path: &str, text: &str) -> Vec<String> {
        let texts =
            [(CONTENTS, SUMMARY), ("docs/a.md", A), ("docs/lab/b.md", B), ("README.md", "[A](docs/a.md#end)\n")];
        let replaced = |(own, original): (&str, &str)| Page {
            path: own.to_owned(),
            text: if own == path { text } else { original }.to_owned(),
        };
        let mut pages: Vec<Page> = texts.map(replaced).into();
        if !pages.iter().any(|page| page.path == path) {
            pages.push(Page { path: path.to_owned(), text: text.to_owned() });
        }
        let files: Vec<String> = pages.iter().map(|page| page.path.clone()).collect();
        let others = ["docs/pictures/p.png", "src/lib.rs", "examples"];
        violations(&pages, &|asked| others.contains(&asked) || files.iter().any(|file| file == asked))
    }

    #[test]
    fn a_sound_book_has_no_violations() {
        assert_eq!(found("docs/a.md", A), Vec::<String>::new());
        assert_eq!(found("README.md", "[`examples/`](examples) [code](src/lib.rs)\n"), Vec::<String>::new());
    }

    #[test]
    fn links_in_code_do_not_count() {
        let text = "# A\n\nFor all: `[x](none.md)`,\n`two\nlines [x](none.md)`.\n\n```md\n[x](none.md)\n# Not a heading\n```\n";
        // The page has lost its heading, to which two links lead.
        assert_eq!(found("docs/a.md", text).len(), 2);
        assert!(found("docs/a.md", &(text.to_owned() + "## End\n")).is_empty());
    }

    #[test]
    fn every_planted_fault_is_found() {
        for (path, text, reason) in [
            ("docs/a.md", "# A\n\nFor all.\n\n## End\n\n[x](lab/none.md)\n", "names no file"),
            ("docs/a.md", "# A\n\nFor all.\n\n## End\n\n![x](pictures/none.png)\n", "names no file"),
            (
                "docs/a.md",
                "# A\n\nFor all.\n\n## End\n\n[`x`\ny](none.md)\n",
                "docs/a.md:8: the link to none.md names no file",
            ),
            ("docs/a.md", "# A\n\nFor all.\n\n## End\n\n[x](lab/b.md#two)\n", "names no heading"),
            ("docs/a.md", "# A\n\nFor all.\n\n## End\n\n[x](#ends)\n", "names no heading"),
            ("docs/a.md", "# A\n\nFor all.\n\n## End\n\n[x](#end-1)\n", "names no heading"),
            ("docs/a.md", "# A\n\nFor all.\n\n## End\n\n[x](pictures/p.png#end)\n", "names no heading"),
            ("docs/a.md", "# A\n\nFor all.\n\n## End\n\n[x](../src/lib.rs)\n", "leaves the book"),
            ("docs/a.md", "# A\n\nFor all.\n\n## End\n\n[x](../../y.md)\n", "leaves the repository"),
            ("docs/a.md", "# A\n\nPages.\n\n## End\n", "whom the page is for"),
            ("docs/a.md", "# A\n\n## End\n\nFor all.\n", "whom the page is for"),
            ("docs/c.md", "# C\n\nFor all.\n", "must stand once"),
            (CONTENTS, "# Book\n\n- [A](a.md)\n", "docs/lab/b.md: must stand once"),
            (CONTENTS, "# Book\n\n- [A](a.md)\n- [B](lab/b.md)\n- [A](a.md)\n", "docs/a.md: must stand once"),
            (CONTENTS, "# Book\n\n- [A](a.md)\n- [B](lab/b.md)\n- [C](c.md)\n", "names no file"),
            ("README.md", "[A](docs/a.md#start)\n", "names no heading"),
            ("README.md", "[A](doc/a.md)\n", "names no file"),
        ] {
            let found = found(path, text);
            assert!(found.len() == 1 && found[0].contains(reason), "{text}: {found:#?}");
        }
    }

    #[test]
    fn equal_headings_are_numbered() {
        assert_eq!(anchors("# A b\n## A b\n### `--x N` *\n## [L](t.md) 3\n"), ["a-b", "a-b-1", "--x-n-", "l-3"]);
    }

    /// Violations of a paper map with one row.
    fn map_found(row: &str) -> usize {
        let text = format!("# Method\n\n{PAPER_MAP}\n\n| in the paper | code | tests |\n|---|---|---|\n{row}");
        let sources = [
            Source::new("glsl/include/guide/grid.glsl", "// lost_one()\nfloat learn(float x) { return x; }"),
            Source::new("tests/render/analytic.rs", "fn a() {}"),
        ];
        paper_map_violations(&[Page { path: METHOD.into(), text }], &sources).len()
    }

    #[test]
    fn the_paper_map_is_held_to_the_code() {
        assert_eq!(map_found("| `L(x, w)` | `learn` in `grid.glsl` | `tests/render/analytic.rs` |\n"), 0);
        assert_eq!(map_found("| Eq. 7 | `learns` in `grid.glsl` | `tests/render/analytic.rs` |\n"), 1);
        assert_eq!(map_found("| Eq. 7 | `lost_one` in `grid.glsl` | `tests/render/analytic.rs` |\n"), 1);
        assert_eq!(map_found("| Eq. 7 | `learn` in `id.glsl` | `tests/render/analytic.rs` |\n"), 2);
        assert_eq!(map_found("| Eq. 7 | `learn` in `grid.glsl` | `tests/render/analytics.rs` |\n"), 1);
        assert_eq!(map_found(""), 1);
    }

    #[test]
    fn large_and_hidden_pictures_are_found() {
        let pages = [Page { path: "docs/lab/b.md".into(), text: B.into() }];
        let count = |path: &str, bytes| picture_violations(&pages, &[(path.to_owned(), bytes)]).len();
        assert_eq!(count("docs/pictures/p.png", MOST_PER_PICTURE), 0);
        assert_eq!(count("docs/pictures/p.png", MOST_PER_PICTURE + 1), 1);
        assert_eq!(count("docs/pictures/q.png", 1), 1);
        let many = vec![("docs/pictures/p.png".to_owned(), MOST_PER_PICTURE); 16];
        assert_eq!(picture_violations(&pages, &many).len(), 1);
    }
}
