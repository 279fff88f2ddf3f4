//! Results of another renderer, written by the scripts in `tests/data`.

use std::path::Path;

use glam::DVec3;
use serde_json::Value;

/// Case of a file.
#[derive(Debug)]
pub struct Row(Value);

impl Row {
    pub fn number(&self, name: &str) -> f64 {
        self.0[name].as_f64().unwrap_or_else(|| panic!("{name} in {}", self.0))
    }

    pub fn numbers<const N: usize>(&self, name: &str) -> [f64; N] {
        std::array::from_fn(|i| self.0[name][i].as_f64().unwrap_or_else(|| panic!("{name}[{i}] in {}", self.0)))
    }

    pub fn vector(&self, name: &str) -> DVec3 {
        self.numbers(name).into()
    }

    pub fn text(&self, name: &str) -> &str {
        self.0[name].as_str().unwrap_or_else(|| panic!("{name} in {}", self.0))
    }

    pub fn is(&self, name: &str) -> bool {
        self.0[name].as_bool().unwrap_or_else(|| panic!("{name} in {}", self.0))
    }
}

/// All cases of a file below `tests/data`.
pub fn rows(file: &str) -> Vec<Row> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(file);
    let text = std::fs::read_to_string(path).expect("the fixture");
    serde_json::from_str::<Vec<Value>>(&text).expect("JSON").into_iter().map(Row).collect()
}
