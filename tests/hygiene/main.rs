//! Rules about layering and prose that the crate's documentation promises, checked on the sources and documents themselves.

mod book;
mod commands;
mod faults;
mod features;
mod glsl;
mod graph;
mod inputs;
mod modules;
mod prose;
mod rust;
mod source;
mod switches;

use std::path::Path;

/// Fails with the list of `violations` unless it is empty.
fn assert_none(violations: Vec<String>) {
    assert!(violations.is_empty(), "\n{}", violations.join("\n"));
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn files_use_what_is_theirs_to_use() {
    let sources = source::read_all(root(), "src", "rs");
    assert!(!sources.is_empty());
    assert_none(rust::violations(&sources));
}

#[test]
fn one_file_opens_what_others_have_made() {
    let sources = source::read_all(root(), "src", "rs");
    assert_none(inputs::violations(&sources));
    assert_none(inputs::stale_exceptions(&sources));
}

#[test]
fn neither_files_nor_rooms_use_each_other_in_circles() {
    let files = graph::files(&source::read_all(root(), "src", "rs"));
    let rooms = graph::rooms(&files);
    assert_none(graph::circles(&files));
    assert_none(graph::circles(&rooms));
    let layers = graph::layers(&rooms);
    print!("{}\n{}", graph::describe("rooms", &layers), graph::describe("files", &graph::layers(&files)));
    assert!(layers.len() <= graph::MOST_LAYERS, "{}", graph::describe("too high a house", &layers));
}

#[test]
fn rooms_do_not_reach_what_they_must_not_know() {
    assert_none(graph::reaches(&graph::files(&source::read_all(root(), "src", "rs"))));
}

#[test]
fn only_the_declaring_file_names_a_glsl_binding() {
    assert_none(glsl::violations(&read_glsl()));
}

#[test]
fn neither_files_nor_folders_of_glsl_include_each_other_in_circles() {
    let files = glsl::includes(&read_glsl());
    let folders = glsl::folders(&files);
    assert!(folders.len() > 8, "{folders:?}");
    assert_none(graph::circles(&files));
    assert_none(graph::circles(&folders));
    print!("{}", graph::describe("folders of GLSL", &graph::layers(&folders)));
}

#[test]
fn one_file_tells_samplers_apart_and_one_learners() {
    assert_none(switches::violations(&read_glsl()));
}

#[test]
fn the_library_compiles_no_crate_of_the_program() {
    assert_none(features::violations(root()));
}

#[test]
fn no_fault_ships() {
    let mut sources = source::read_all(root(), "src", "rs");
    sources.extend(read_glsl());
    assert_none(faults::violations(&sources));
}

fn read_glsl() -> Vec<source::Source> {
    let mut sources = source::read_all(root(), "glsl", "comp");
    sources.extend(source::read_all(root(), "glsl", "glsl"));
    sources
}

#[test]
fn doc_comments_name_their_subject() {
    let mut sources = source::read_all(root(), "src", "rs");
    for folder in ["build", "benches", "examples", "tests"] {
        sources.extend(source::read_all(root(), folder, "rs"));
    }
    sources.extend(source::read_all(root(), "glsl", "comp"));
    sources.extend(source::read_all(root(), "glsl", "glsl"));
    assert_none(prose::violations(&sources));
}

#[test]
fn documents_lead_somewhere() {
    let pages = book::read_pages(root());
    assert!(pages.len() > 10, "{} documents", pages.len());
    assert_none(book::violations(&pages, &|path| root().join(path).exists()));
    assert_none(book::picture_violations(&pages, &book::read_pictures(root())));
}

#[test]
fn commands_of_contributors_and_workflows_run_what_there_is() {
    let texts = commands::read(root());
    assert!(texts.len() > 3, "{} files with commands", texts.len());
    assert_none(commands::violations(&texts, &|path| root().join(path).exists()));
}

#[test]
fn the_paper_map_names_what_there_is() {
    let mut sources = read_glsl();
    for folder in ["src", "tests"] {
        sources.extend(source::read_all(root(), folder, "rs"));
    }
    assert_none(book::paper_map_violations(&book::read_pages(root()), &sources));
}
