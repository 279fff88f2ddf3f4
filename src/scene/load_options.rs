//! Choices of a user about how a scene is read. They suit every format.

use std::convert::Infallible;
use std::path::PathBuf;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Options for reading a scene.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadOptions {
    /// `-D name=value`: replaces the `<default>` of that name. Only Mitsuba's XML has such values.
    pub defines: Vec<(String, String)>,
    /// Camera to use; `None` for the scene's first.
    pub camera: Option<CameraChoice>,
    /// Environment that replaces the scene's own.
    pub environment: Option<EnvironmentChoice>,
}

/// Choices of a camera.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum CameraChoice {
    /// A camera that shows the whole scene.
    Fit,
    /// The scene's camera of this name, or else of this index, counted from 0.
    Named(String),
}

impl FromStr for CameraChoice {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text {
            "fit" => Self::Fit,
            name => Self::Named(name.to_owned()),
        })
    }
}

/// Choices of an environment.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum EnvironmentChoice {
    /// A radiance of 1 from all directions.
    Constant,
    /// An image of the whole sphere, with `+y` up.
    File(PathBuf),
}

impl FromStr for EnvironmentChoice {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text {
            "constant" => Self::Constant,
            path => Self::File(path.into()),
        })
    }
}
