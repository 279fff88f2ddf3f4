//! Scenes, read from files or from dictionaries.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lodestar::scene::summary::summarize;
use lodestar::scene::{CameraChoice, EnvironmentChoice, LoadOptions, scene_file};
use lodestar::session::SceneInput;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};

use crate::dictionary::scene_dictionary;
use crate::errors::{raised, refused, warn};
use crate::shared::{detached, from_json};

/// A scene in memory: read once, rendered as often as you like. `lodestar.load` makes it.
#[pyclass(frozen, module = "lodestar")]
pub struct Scene {
    scene: Arc<lodestar::Scene>,
    file: Option<SceneFile>,
}

/// File of a scene, with the choices with which it is read.
#[derive(Debug, Clone, Default)]
pub struct SceneFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Choices with which it is read.
    pub options: LoadOptions,
}

/// A scene to render: in memory, or still in its file.
#[derive(Clone)]
pub struct Subject {
    /// The scene, if it is in memory.
    pub scene: Option<Arc<lodestar::Scene>>,
    /// The scene's file, if it has one.
    pub file: Option<SceneFile>,
}

impl SceneFile {
    /// Reads the scene.
    pub fn read(&self) -> lodestar::Result<lodestar::Scene> {
        lodestar::scene::load(&scene_file(&self.path)?, &self.options)
    }
}

impl Subject {
    /// The scene that an argument stands for: a `Scene`, a path, or a dictionary. Only a path is read with `choices`.
    pub fn of(scene: &Bound<'_, PyAny>, choices: Choices<'_, '_>) -> PyResult<Self> {
        if let Ok(path) = path_of(scene) {
            return Ok(Self { scene: None, file: Some(SceneFile { path, options: choices.options()? }) });
        }
        choices.refuse_for(scene)?;
        if let Ok(scene) = scene.cast::<Scene>() {
            let Scene { scene, file } = scene.get();
            return Ok(Self { scene: Some(Arc::clone(scene)), file: file.clone() });
        }
        if scene.cast::<PyMapping>().is_ok() {
            let scene = from_dictionary(scene, true)?;
            return Ok(Self { scene: Some(scene.scene), file: None });
        }
        path_of(scene).map(|path| Self { scene: None, file: Some(SceneFile { path, options: LoadOptions::default() }) })
    }

    /// The scene as a session takes it.
    pub fn input(&self) -> SceneInput<'_> {
        match (&self.scene, &self.file) {
            (Some(scene), Some(SceneFile { path, options })) => {
                SceneInput::Read { scene, path: path.clone(), options: options.clone() }
            }
            (Some(scene), None) => SceneInput::Memory(scene),
            (None, file) => {
                let SceneFile { path, options } = file.clone().unwrap_or_default();
                SceneInput::File { path, options }
            }
        }
    }

    /// Warnings of a session that were not shown yet. Those of a scene that was loaded before were.
    pub fn unknown(&self, mut warnings: Vec<String>) -> Vec<String> {
        let known = self.scene.as_ref().map_or(&[][..], |scene| &scene.warnings);
        warnings.retain(|warning| !known.contains(warning));
        warnings
    }

    /// The scene. It is read if it is not in memory.
    pub fn scene(&self) -> lodestar::Result<Arc<lodestar::Scene>> {
        match (&self.scene, &self.file) {
            (Some(scene), _) => Ok(Arc::clone(scene)),
            (None, Some(file)) => file.read().map(Arc::new),
            (None, None) => Err(lodestar::Error::Settings("the scene is neither in memory nor in a file".into())),
        }
    }
}

/// Keywords `camera` and `environment`, with which a file is read.
#[derive(Clone, Copy)]
pub struct Choices<'a, 'py> {
    /// Name or index of a camera, or `fit`.
    pub camera: Option<&'a Bound<'py, PyAny>>,
    /// `constant`, or the path of an image.
    pub environment: Option<&'a Bound<'py, PyAny>>,
}

impl Choices<'_, '_> {
    fn options(self) -> PyResult<LoadOptions> {
        let camera = self.camera.map(|camera| match camera.extract::<usize>() {
            Ok(index) => Ok(CameraChoice::Named(index.to_string())),
            Err(_) => camera.extract::<String>().map(|name| name.parse().unwrap_or(CameraChoice::Fit)),
        });
        let camera = camera.transpose().map_err(|_| {
            PyTypeError::new_err("`camera` is the name or the index of a camera of the scene, or \"fit\"")
        })?;
        let environment = self.environment.map(|environment| {
            path_of(environment).map(|path| match path.as_os_str() == "constant" {
                true => EnvironmentChoice::Constant,
                false => EnvironmentChoice::File(path),
            })
        });
        Ok(LoadOptions { camera, environment: environment.transpose()?, ..LoadOptions::default() })
    }

    /// Refuses the keywords for a scene that is not read from a file.
    fn refuse_for(self, scene: &Bound<'_, PyAny>) -> PyResult<()> {
        let given = [("camera", self.camera), ("environment", self.environment)];
        match given.into_iter().find(|(_, value)| value.is_some()) {
            None => Ok(()),
            Some((keyword, _)) if scene.cast::<Scene>().is_ok() => {
                Err(refused(format!("this scene is already read; give `{keyword}` to lodestar.load")))
            }
            Some((keyword, _)) => {
                Err(refused(format!("`{keyword}` is for scenes in files; write it into the dictionary")))
            }
        }
    }
}

/// The path that an argument names.
pub fn path_of(value: &Bound<'_, PyAny>) -> PyResult<PathBuf> {
    value.extract::<PathBuf>().map_err(|_| {
        let name = value.get_type().name().map_or_else(|_| "object".to_owned(), |name| name.to_string());
        PyTypeError::new_err(format!("expected a path or an object of lodestar, not `{name}`"))
    })
}

/// The camera that an argument stands for: a sensor of a dictionary, or that of a `Scene`.
pub fn camera_of(value: &Bound<'_, PyAny>) -> PyResult<lodestar::scene::Camera> {
    let py = value.py();
    if let Ok(scene) = value.cast::<Scene>() {
        return Ok(scene.get().scene.camera);
    }
    if value.cast::<PyMapping>().is_err() {
        let message =
            "`camera` is a dictionary of a sensor, such as {\"type\": \"perspective\"}, or a scene with the camera";
        return Err(PyTypeError::new_err(message));
    }
    let scene = PyDict::new(py);
    scene.set_item("type", "scene")?;
    scene.set_item("camera", value)?;
    Ok(from_dictionary(scene.as_any(), false)?.scene.camera)
}

/// A scene of a dictionary. `warns` whether Python shows its warnings.
fn from_dictionary(value: &Bound<'_, PyAny>, warns: bool) -> PyResult<Scene> {
    let py = value.py();
    let dictionary = scene_dictionary(value)?;
    let scene = detached(py, || lodestar::Scene::from_dictionary(&dictionary))?.map_err(raised)?;
    if warns {
        warn(py, &scene.warnings)?;
    }
    Ok(Scene { scene: Arc::new(scene), file: None })
}

/// Reads a scene.
///
/// Parameters
/// ----------
/// scene : path or dict
///     Mitsuba's XML of any version, a model in glTF or USD, a scene of pbrt-v4, a folder with a `scene.xml`, or Mitsuba's scene
///     dictionary. A dictionary may nest objects, and may hold numpy arrays and transforms (`lodestar.ScalarTransform4f`, Mitsuba's, or arrays of shape (4, 4)). A shape
///     `{"type": "mesh", "vertices": (n, 3), "faces": (m, 3)}` is a mesh of arrays, with optional `normals` (n, 3), `uvs` (n, 2)
///     and `colors` (n, 3). Vertices and normals of the shape (k, n, 3) are those of k times, from the shutter's opening to its closing.
///     Files that a dictionary names are relative to the current folder.
/// camera : str or int
///     Name or index of the file's camera, or `"fit"` for one that shows the whole scene. Default: the first.
/// environment : path
///     Image of light from all sides, or `"constant"`, in place of the scene's own.
/// **defines
///     Values that replace the file's `<default>` values, by name.
///
/// Raises
/// ------
/// lodestar.Error
///     Where the scene cannot be read or asks for something unsupported. The message names the file and the line, or the entry of
///     the dictionary, such as `scene.box.bsdf`.
#[pyfunction]
#[pyo3(signature = (scene, *, camera = None, environment = None, **defines))]
pub fn load(
    scene: &Bound<'_, PyAny>,
    camera: Option<&Bound<'_, PyAny>>,
    environment: Option<&Bound<'_, PyAny>>,
    defines: Option<&Bound<'_, PyDict>>,
) -> PyResult<Scene> {
    let py = scene.py();
    let choices = Choices { camera, environment };
    if scene.cast::<PyMapping>().is_ok() {
        if defines.is_some_and(|defines| !defines.is_empty()) {
            return Err(refused("a dictionary has no <default> values to replace; write them into the dictionary"));
        }
        choices.refuse_for(scene)?;
        return from_dictionary(scene, true);
    }
    let path = path_of(scene)?;
    let options = LoadOptions { defines: pairs(defines)?, ..choices.options()? };
    let read = |path: &Path| {
        let file = SceneFile { path: scene_file(path)?, options };
        Ok((file.read()?, file))
    };
    let (scene, file) = detached(py, || read(&path))?.map_err(raised)?;
    warn(py, &scene.warnings)?;
    Ok(Scene { scene: Arc::new(scene), file: Some(file) })
}

/// Names and values of keywords, as texts.
fn pairs(defines: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<(String, String)>> {
    let defines = defines.into_iter().flat_map(|defines| defines.iter());
    defines.map(|(name, value)| Ok((name.extract()?, value.str()?.extract()?))).collect()
}

/// Writes a scene as a Mitsuba file of version 3.0.0 that renders the same picture, as `lodestar convert` does. The files that the scene
/// names are copied to a folder beside the new file, which has its name without `.xml`.
///
/// Parameters
/// ----------
/// scene : path
///     Mitsuba's XML of any version, a model in glTF or USD, a scene of pbrt-v4, or a folder with a `scene.xml`.
/// output : path
///     File to write, in `.xml`.
/// overwrite : bool
///     Whether files that exist already are replaced.
/// **defines
///     Values that replace the file's `<default>` values, by name.
#[pyfunction]
#[pyo3(signature = (scene, output, *, overwrite = false, **defines))]
pub fn convert(
    py: Python<'_>,
    scene: PathBuf,
    output: PathBuf,
    overwrite: bool,
    defines: Option<&Bound<'_, PyDict>>,
) -> PyResult<()> {
    let defines = pairs(defines)?;
    let convert = || lodestar::scene::convert(&scene_file(&scene)?, &defines, &output, overwrite);
    let converted = detached(py, convert)?.map_err(raised)?;
    warn(py, &converted.warnings)
}

#[pymethods]
impl Scene {
    /// Name of the scene: its file's name, or its folder's; `scene` for a dictionary.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// Width of the film in pixels.
    #[getter]
    fn width(&self) -> u32 {
        self.scene.film.width
    }

    /// Height of the film in pixels.
    #[getter]
    fn height(&self) -> u32 {
        self.scene.film.height
    }

    /// Sentences about things that were read but are not rendered exactly, each with its file and line.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.scene.warnings.clone()
    }

    /// Fingerprint of everything in the scene that a render reads, a text. Scenes with one fingerprint render to the same bits.
    #[getter]
    fn fingerprint(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || lodestar::scene::fingerprint(&self.scene))?.map_err(raised)
    }

    /// Shapes, materials, lights, textures and images of the scene, as `lodestar info --json` prints them.
    #[getter]
    fn summary(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let summary = detached(py, || summarize(&self.scene))?;
        from_json(py, &summary)
    }

    fn __repr__(&self) -> String {
        let lodestar::Scene { name, primitives, film, .. } = &*self.scene;
        format!("<lodestar.Scene '{name}': {} primitives, {} x {} pixels>", primitives.len(), film.width, film.height)
    }
}
