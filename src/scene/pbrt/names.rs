//! Names of objects: labels for messages, and ids.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::tokens::Place;
use crate::scene::description::object::Object;

/// Maker of the names of a scene's objects.
pub(super) struct Names {
    main: PathBuf,
    ids: RefCell<Ids>,
}

impl Names {
    /// Names within the scene whose main file is at `main`, which every message names.
    pub fn new(main: &Path) -> Self {
        Self { main: main.to_path_buf(), ids: RefCell::default() }
    }

    /// Label of a thing at a place: the line, and the file where it is not the main one.
    pub fn label(&self, place: &Place, what: &str) -> String {
        match *place.file == *self.main {
            true => format!("line {}: {what}", place.line),
            false => {
                let file = place.file.file_name().unwrap_or_default().to_string_lossy();
                format!("{file}, line {}: {what}", place.line)
            }
        }
    }

    /// An id that no other object has: `wanted`, or else with a number behind it.
    pub fn id(&self, wanted: &str) -> String {
        self.ids.borrow_mut().give(wanted)
    }

    /// Entry of the scene for an object with that label, whose id is new.
    pub fn entry(&self, label: String, wanted_id: &str, object: Object) -> (String, Object) {
        let id = self.id(wanted_id);
        (label, object.with_id(id))
    }
}

/// Ids given so far.
#[derive(Default)]
struct Ids {
    /// Number of the last object of each wanted id.
    counts: HashMap<String, usize>,
}

impl Ids {
    fn give(&mut self, wanted: &str) -> String {
        let mut id = wanted.to_owned();
        while let Some(count) = self.counts.get_mut(&id) {
            *count += 1;
            // The number may itself be the end of an id that was wanted.
            id = format!("{wanted} {count}");
            if !self.counts.contains_key(&id) {
                break;
            }
        }
        self.counts.insert(id.clone(), 1);
        id
    }
}

#[cfg(test)]
mod tests {
    use super::Ids;

    #[test]
    fn no_id_comes_twice() {
        let mut ids = Ids::default();
        let given = ["a", "a", "a 2", "a", "a 2", "b", "a 2 2"].map(|wanted| ids.give(wanted));
        let distinct: std::collections::HashSet<_> = given.iter().collect();
        assert_eq!(distinct.len(), given.len(), "{given:?}");
        assert_eq!(given[..2], ["a", "a 2"]);
    }
}
