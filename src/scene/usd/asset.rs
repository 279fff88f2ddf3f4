//! An opened stage, with the warnings about it.

use std::cell::RefCell;
use std::collections::HashSet;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use openusd::sdf::{self, Value};
use openusd::usd::{Stage, TimeCode};

use super::files::Files;
use super::values;
use crate::{Error, Result, quoted};

/// Most warnings of a scene.
const MOST_WARNINGS: usize = 100;

/// An opened stage.
pub(super) struct Asset {
    pub path: PathBuf,
    pub files: Files,
    pub stage: Stage,
    /// Time code that is shown; `None` for the default of each attribute, or else its first sample.
    time: Option<TimeCode>,
    warnings: RefCell<Vec<String>>,
}

impl Asset {
    /// Opens the stage at `path` at a moment in seconds.
    pub fn open(path: &Path, seconds: Option<f64>) -> Result<Self> {
        let files = Files::default();
        let fault = |message: String| Error::scene(path, None, message);
        let real = path.canonicalize().map_err(Error::read(path))?;
        let name = real.to_str().ok_or_else(|| fault("its path is no Unicode text; rename it".to_owned()))?;
        let is_archive = real.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("usdz"));
        let root = match is_archive {
            true => {
                let archive = files.archive(&real).map_err(|error| fault(error.to_string()))?;
                let first = archive.first_layer().ok_or_else(|| fault("the archive contains no layer".to_owned()))?;
                openusd::ar::join_package_relative_path(name, first)
            }
            false => {
                crate::inputs::open(&real)?;
                name.to_owned()
            }
        };
        let stage = Stage::builder().resolver(files.clone()).open(&root);
        let stage = stage.map_err(|error| fault(format!("it is no USD file: {}", whole(&error))))?;
        // The crate overlooks a rate that the file gives as a whole number.
        let rate = stage.stage_metadata("timeCodesPerSecond").ok().flatten();
        let rate = rate.as_ref().and_then(values::number).unwrap_or_else(|| stage.time_codes_per_second());
        let time = seconds.map(|seconds| TimeCode::new(seconds * rate));
        Ok(Self { path: path.to_path_buf(), files, stage, time, warnings: RefCell::default() })
    }

    /// Error of the whole file.
    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::scene(&self.path, None, message)
    }

    /// Error of a prim.
    pub fn prim_error(&self, prim: &sdf::Path, message: impl Display) -> Error {
        self.error(format!("{prim}: {message}"))
    }

    /// Error of the library that reads USD.
    pub fn fault(&self, prim: &sdf::Path, error: &impl Display) -> Error {
        self.prim_error(prim, whole(error))
    }

    /// Keeps a warning, once.
    pub fn warn(&self, message: impl Display) {
        let message = format!("{}: {message}", self.path.display());
        let mut warnings = self.warnings.borrow_mut();
        if warnings.len() < MOST_WARNINGS && !warnings.contains(&message) {
            warnings.push(message);
            if warnings.len() == MOST_WARNINGS {
                warnings.push(format!("{}: there are more warnings, which are not told", self.path.display()));
            }
        }
    }

    /// Keeps a warning about a prim.
    pub fn warn_of(&self, prim: &sdf::Path, message: impl Display) {
        self.warn(format!("{prim}: {message}"));
    }

    /// All warnings, with those about layers that could not be composed.
    pub fn into_warnings(self) -> Vec<String> {
        for error in self.stage.composition_errors() {
            self.warn(quoted::message(&error));
        }
        self.warnings.into_inner()
    }

    /// The prim at a path.
    pub fn prim(&self, path: &sdf::Path) -> Result<Prim<'_>> {
        let prim = self.stage.prim(path.clone());
        let fault = |error| self.fault(path, &error);
        let names = prim.property_names().map_err(fault)?;
        let kind = prim.type_name().map_err(fault)?.map_or(String::new(), |kind| kind.as_str().to_owned());
        let names = names.iter().map(|name| name.as_str().to_owned()).collect();
        Ok(Prim { asset: self, path: path.clone(), kind, names })
    }

    /// Value of an attribute at the time that is shown; `None` where it has none.
    fn value(&self, path: &sdf::Path) -> Result<Option<Value>> {
        let attribute = self.stage.attribute(path.clone());
        let is_value = |value: &Value| !matches!(value, Value::ValueBlock | Value::None);
        let at = |time: Option<TimeCode>| match attribute.get_at::<Value>(time) {
            Ok(value) => Ok(value.filter(is_value)),
            Err(error) => Err(self.fault(path, &error)),
        };
        if self.time.is_some()
            && let Some(value) = at(self.time)?
        {
            return Ok(Some(value));
        }
        if let Some(value) = at(None)? {
            return Ok(Some(value));
        }
        let times = attribute.time_sample_times().map_err(|error| self.fault(path, &error))?;
        times.first().map_or(Ok(None), |&first| at(Some(TimeCode::new(first))))
    }
}

/// A prim with the names of its properties.
#[derive(Clone)]
pub(super) struct Prim<'a> {
    pub asset: &'a Asset,
    pub path: sdf::Path,
    /// Name of its type, such as `Mesh`.
    pub kind: String,
    names: HashSet<String>,
}

impl Prim<'_> {
    /// Names of its properties.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// Whether it has a property of this name.
    pub fn has(&self, name: &str) -> bool {
        self.names.contains(name)
    }

    /// Path of a property.
    pub fn property(&self, name: &str) -> Option<sdf::Path> {
        self.path.append_property(name).ok()
    }

    /// Value of an attribute.
    pub fn value(&self, name: &str) -> Result<Option<Value>> {
        if !self.has(name) {
            return Ok(None);
        }
        let Some(path) = self.property(name) else { return Ok(None) };
        self.asset.value(&path)
    }

    /// Value of an attribute that `of` reads. One of another type is told and ignored.
    pub fn read<T>(&self, name: &str, of: impl Fn(&Value) -> Option<T>) -> Result<Option<T>> {
        let Some(value) = self.value(name)? else { return Ok(None) };
        let read = of(&value);
        if read.is_none() {
            self.asset.warn_of(&self.path, format!("the type of `{name}` is another than expected; it is ignored"));
        }
        Ok(read)
    }

    /// Number of an attribute; `default` where it has none, or none that is finite.
    pub fn number(&self, name: &str, default: f64) -> Result<f64> {
        Ok(self.read(name, values::number)?.filter(|value| value.is_finite()).unwrap_or(default))
    }

    /// Text of an attribute.
    pub fn text(&self, name: &str) -> Result<Option<String>> {
        self.read(name, values::text)
    }

    /// Whether an attribute is true.
    pub fn flag(&self, name: &str, default: bool) -> Result<bool> {
        Ok(self.number(name, f64::from(u8::from(default)))? != 0.0)
    }

    /// Color of an attribute.
    pub fn color(&self, name: &str, default: [f64; 3]) -> Result<[f64; 3]> {
        let color = self.read(name, values::triples)?.and_then(|list| list.first().copied());
        Ok(color.filter(|color| color.iter().all(|channel| channel.is_finite())).unwrap_or(default))
    }

    /// Metadata of a property.
    pub fn metadata(&self, name: &str, key: &str) -> Result<Option<Value>> {
        let Some(path) = self.property(name) else { return Ok(None) };
        let value = self.asset.stage.attribute(path.clone()).get_metadata::<Value>(key);
        value.map_err(|error| self.asset.fault(&path, &error))
    }

    /// Targets of a relationship.
    pub fn targets(&self, name: &str) -> Result<Vec<sdf::Path>> {
        let Some(path) = self.property(name).filter(|_| self.has(name)) else { return Ok(Vec::new()) };
        let targets = self.asset.stage.relationship(path.clone()).targets();
        targets.map_err(|error| self.asset.fault(&path, &error))
    }

    /// The prim and the name of its property that an attribute is connected to.
    pub fn connection(&self, name: &str) -> Result<Option<(sdf::Path, String)>> {
        let Some(path) = self.property(name).filter(|_| self.has(name)) else { return Ok(None) };
        let targets = self.asset.stage.attribute(path.clone()).connections();
        let targets = targets.map_err(|error| self.asset.fault(&path, &error))?;
        Ok(targets.first().and_then(|target| {
            let (prim, property) = target.split_property()?;
            Some((prim, property.to_owned()))
        }))
    }

    /// Whether it has an API schema of this name.
    pub fn has_schema(&self, name: &str) -> Result<bool> {
        let schemas = self.asset.stage.prim(self.path.clone()).api_schemas();
        let schemas = schemas.map_err(|error| self.asset.fault(&self.path, &error))?;
        Ok(schemas.iter().any(|schema| schema.as_str() == name))
    }

    /// Prims directly beneath it.
    pub fn children(&self) -> Result<Vec<sdf::Path>> {
        let children = self.asset.stage.prim(self.path.clone()).children();
        let children = children.map_err(|error| self.asset.fault(&self.path, &error))?;
        Ok(children.iter().map(|child| child.path().clone()).collect())
    }

    /// Its name without those of its parents.
    pub fn name(&self) -> &str {
        self.path.name().unwrap_or_default()
    }
}

/// An error with its reasons, in one line.
fn whole(error: &impl Display) -> String {
    quoted::message(&format!("{error:#}"))
}
