//! Test that the manual has a page for each subcommand. With `LODESTAR_WRITE_MANUAL=DIR`, the test writes the pages into the
//! folder. Packages contain them. The program does not, because few users would need it to write them.

use std::collections::BTreeMap;
use std::path::Path;
use std::{env, fs};

use clap::Command;

use super::command;

/// Pages of the manual by file name: one for the program and one for each subcommand.
fn pages() -> BTreeMap<String, String> {
    let mut root = command().disable_help_subcommand(true);
    root.build();
    let mut pages = BTreeMap::from([("lodestar.1".into(), page(root.clone()))]);
    for subcommand in root.get_subcommands() {
        let name = format!("lodestar-{}", subcommand.get_name());
        // clap_mangen prints the name at the top and the display name in the synopsis.
        pages.insert(format!("{name}.1"), page(subcommand.clone().display_name(name)));
    }
    pages
}

fn page(command: Command) -> String {
    let mut bytes = Vec::new();
    clap_mangen::Man::new(command).render(&mut bytes).expect("memory takes every write");
    String::from_utf8(bytes).expect("help texts are UTF-8")
}

/// Text of a page with roff's escaped hyphens as hyphens.
fn plain(page: &str) -> String {
    page.replace("\\-", "-")
}

#[test]
fn the_manual_covers_every_subcommand_and_option() {
    let pages = pages();
    let root = command();
    let overview = plain(&pages["lodestar.1"]);
    let subcommands: Vec<_> = root.get_subcommands().collect();
    assert_eq!(pages.len(), subcommands.len() + 1);
    for subcommand in subcommands {
        let name = format!("lodestar-{}", subcommand.get_name());
        let page = plain(&pages[&format!("{name}.1")]);
        assert!(overview.contains(&name), "lodestar.1 does not name {name}");
        assert!(page.contains(&format!(".TH {name} 1")), "{name} has no title:\n{page}");
        for argument in subcommand.get_arguments().filter(|argument| !argument.is_hide_set()) {
            let long = argument.get_long().map(|long| format!("--{long}"));
            let shown = long.unwrap_or_else(|| argument.get_value_names().expect("a name")[0].to_string());
            assert!(page.contains(&shown), "{name}.1 does not name {shown}");
        }
    }
    if let Some(folder) = env::var_os("LODESTAR_WRITE_MANUAL") {
        for (name, page) in pages {
            fs::write(Path::new(&folder).join(name), page).expect("the folder of LODESTAR_WRITE_MANUAL takes files");
        }
    }
}
