//! Choice of one of a scene's cameras.

use std::path::Path;

use crate::scene::description::object::Object;
use crate::scene::load_options::CameraChoice;
use crate::{Error, Result};

/// Sensor that the user has chosen, or else the first, with a warning where there are more; `None` for a fitted one. `path` is the scene's
/// file.
pub(super) fn chosen<'a>(
    sensors: &[&'a Object],
    choice: Option<&CameraChoice>,
    path: &Path,
    warnings: &mut Vec<String>,
) -> Result<Option<&'a Object>> {
    let name = match choice {
        None => {
            warnings.extend(warning_of_others(sensors));
            return Ok(sensors.first().copied());
        }
        Some(CameraChoice::Fit) => return Ok(None),
        Some(CameraChoice::Named(name)) => name,
    };
    let named = sensors.iter().find(|sensor| sensor.id.as_ref() == Some(name));
    let found = named.or_else(|| sensors.get(name.parse::<usize>().ok()?));
    found.copied().map(Some).ok_or_else(|| {
        let known = names(sensors).join(", ");
        let list = if known.is_empty() { "none".to_owned() } else { known };
        Error::scene(path, None, format!("there is no camera `{name}`; the scene's cameras are: {list}; or use `fit`"))
    })
}

/// Warning that lists the cameras where there are several.
fn warning_of_others(sensors: &[&Object]) -> Option<String> {
    let second = sensors.get(1)?;
    let (word, names) = (second.origin.word(second.kind.name()), names(sensors).join(", "));
    let message = format!(
        "a second {word}; the scene's cameras are {names}; the first is used; --camera chooses another, or all"
    );
    Some(format!("{}: {message}", second.origin))
}

/// Cameras as `--camera` names them: an index, with the name if there is one.
fn names(sensors: &[&Object]) -> Vec<String> {
    let of = |(index, sensor): (usize, &&Object)| match &sensor.id {
        Some(id) => format!("{index} (`{id}`)"),
        None => index.to_string(),
    };
    sensors.iter().enumerate().map(of).collect()
}
