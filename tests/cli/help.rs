//! Help texts, and the page of options, which is generated from the same table.

use lodestar::settings::options::document;

use crate::support::Folder;

const SUBCOMMANDS: [&str; 13] = [
    "render",
    "resume",
    "inspect",
    "devices",
    "info",
    "convert",
    "compare",
    "merge",
    "denoise",
    "radiance",
    "view",
    "reproduce",
    "completions",
];

fn help(arguments: &[&str]) -> String {
    let output = Folder::new().run(arguments);
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_short_help_of_render_is_one_page() {
    let text = help(&["render", "-h"]);
    assert!(text.lines().count() <= 45, "{} lines:\n{text}", text.lines().count());
    let wide: Vec<_> = text.lines().filter(|line| line.chars().count() > 100).collect();
    assert!(wide.is_empty(), "{wide:?}");
    for option in ["--output", "--spp", "--time", "--noise", "--sampler", "--nee", "--seed", "--checkpoint", "--device"]
    {
        assert!(text.contains(option), "{option} is not in\n{text}");
    }
    assert!(!text.contains("Research") && !text.contains("--epsilon"), "{text}");
}

#[test]
fn the_long_help_of_render_has_research_under_one_heading() {
    let text = help(&["render", "--help"]);
    let (before, research) = text.split_once("\nResearch:\n").expect("a heading");
    let (research, _) = research.split_once("\nDevice:\n").expect("the next heading");
    for option in ["--learner", "--epsilon", "--max-tries", "--grid"] {
        assert!(research.contains(option) && !before.contains(&format!(" {option} <")), "{option}");
    }
}

/// A checkpoint keeps files and length, so the defaults of a new render are not those of `resume`.
#[test]
fn the_help_of_resume_has_its_own_defaults() {
    let [render, resume] = ["render", "resume"].map(|subcommand| help(&[subcommand, "--help"]));
    for default in ["[default: the scene's, or 64]", "[default: the scene's name with .exr]", "[default: srgb]"] {
        assert!(render.contains(default) && !resume.contains(default), "{default}:\n{resume}");
    }
    assert_eq!(resume.matches("[default: as in the checkpoint]").count(), 5, "{resume}");
}

/// Options that a map refuses are not in its help.
#[test]
fn the_help_of_radiance_has_no_option_that_it_refuses() {
    let text = help(&["radiance", "--help"]);
    for option in ["--steps <", "--sample-weights <", "--nee <"] {
        assert!(!text.contains(option), "{option}:\n{text}");
    }
    assert!(text.contains("--spp-per-step <") && text.contains("--sampler <"), "{text}");
}

/// Help texts have no links to the crate's documentation.
#[test]
fn no_help_has_links_of_the_documentation() {
    for subcommand in SUBCOMMANDS {
        for flag in ["-h", "--help"] {
            let text = help(&[subcommand, flag]);
            assert!(!text.contains("[`") && !text.contains("]("), "{subcommand} {flag}:\n{text}");
        }
    }
}

/// The page of options equals the page generated from the table. With `LODESTAR_WRITE_DOCS=1`, the test writes it.
#[test]
fn the_page_of_options_is_that_of_the_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/options.md");
    if std::env::var_os("LODESTAR_WRITE_DOCS").is_some_and(|value| value == "1") {
        std::fs::write(path, document()).unwrap();
    }
    let page = std::fs::read_to_string(path).unwrap_or_default();
    assert!(page == document(), "docs/options.md is out of date: run this test with LODESTAR_WRITE_DOCS=1");
    let help = help(&["render", "--help"]);
    for name in ["output", "quiet"] {
        let letter = &name[..1];
        assert!(
            help.contains(&format!("-{letter}, --{name}")) && page.contains(&format!("### `-{letter}`, `--{name}"))
        );
    }
}

#[test]
fn completions_of_each_shell_name_every_subcommand() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = help(&["completions", shell]);
        for subcommand in SUBCOMMANDS {
            assert!(script.contains(subcommand), "{shell} does not complete {subcommand}");
        }
        assert!(script.contains("max-depth"), "{shell} does not complete options of render");
    }
}
