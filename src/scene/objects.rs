//! Names of the objects that a scene shows, for the layers that compositors read. No picture depends on them.

use std::collections::HashMap;
use std::sync::Arc;

/// Objects of a scene: which primitives and instances belong to which.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Objects {
    /// Names, each once.
    pub names: Vec<Arc<str>>,
    /// Runs of the scene's primitives.
    pub of_primitives: Vec<Run>,
    /// Runs of the primitives of all groups, which follow each other.
    pub of_groups: Vec<Run>,
    /// Index of each instance's name; `None` where the primitives of its group have names of their own.
    pub of_instances: Vec<Option<u32>>,
}

/// Primitives that follow each other and belong to one object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Index of the first primitive behind them.
    pub end: usize,
    /// Index of the object's name.
    pub name: u32,
}

impl Objects {
    /// Index of the name of the object that a primitive of the scene belongs to; `None` where it has none.
    pub fn of_primitive(&self, index: usize) -> Option<u32> {
        of_run(&self.of_primitives, index)
    }

    /// Index of the name of the object that an instance shows with a primitive of its group; the primitives of all groups are counted.
    pub fn of_instance(&self, instance: usize, primitive: usize) -> Option<u32> {
        let own = self.of_instances.get(instance).copied().flatten();
        own.or_else(|| of_run(&self.of_groups, primitive))
    }
}

fn of_run(runs: &[Run], index: usize) -> Option<u32> {
    runs.get(runs.partition_point(|run| run.end <= index)).map(|run| run.name)
}

/// Names with their indices.
#[derive(Default)]
pub(crate) struct Names {
    list: Vec<Arc<str>>,
    known: HashMap<Arc<str>, u32>,
}

impl Names {
    /// Index of a name.
    pub fn index(&mut self, name: &Arc<str>) -> u32 {
        *self.known.entry(Arc::clone(name)).or_insert_with(|| {
            self.list.push(Arc::clone(name));
            self.list.len() as u32 - 1
        })
    }

    /// All names in the order of their indices.
    pub fn into_list(self) -> Vec<Arc<str>> {
        self.list
    }
}

/// Name of the object whose shape has this `id`. Shapes whose ids differ in what follows the last `#` are parts of one object.
pub(crate) fn name_of_id(id: &str) -> &str {
    id.rsplit_once('#').map_or(id, |(name, _)| name)
}

#[test]
fn primitives_have_the_names_of_their_runs() {
    let run = |end, name| Run { end, name };
    let objects = Objects {
        names: vec!["a".into(), "b".into(), "c".into()],
        of_primitives: vec![run(2, 0), run(3, 1)],
        of_groups: vec![run(1, 1), run(5, 0)],
        of_instances: vec![None, Some(2)],
    };
    assert_eq!([0, 1, 2, 3].map(|index| objects.of_primitive(index)), [Some(0), Some(0), Some(1), None]);
    assert_eq!([0, 1, 4, 5].map(|index| objects.of_instance(0, index)), [Some(1), Some(0), Some(0), None]);
    assert_eq!(objects.of_instance(1, 0), Some(2));
    assert_eq!(["tree", "tree#2", "a#b#3"].map(name_of_id), ["tree", "tree", "a#b"]);
}
