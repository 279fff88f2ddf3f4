//! Scene loader from outside: the scenes that it accepts, and the words in which it refuses others.

mod accepts;
mod convert;
mod curves;
mod cylinder;
mod emitters;
mod facing;
mod forms;
mod fuzz;
mod fuzz_renders;
mod geometry;
mod gltf;
mod gltf_choices;
mod gltf_compressed;
mod gltf_cornell;
mod gltf_surfaces;
mod hair;
mod lobes;
mod mapped;
mod materials;
mod measured;
mod media;
mod meshes;
mod motion;
mod obj;
mod ours;
mod pbrt;
mod programs;
mod refuses;
mod strangers;
mod sunsky;
mod textures;
mod usd;
mod usd_rules;

use std::path::PathBuf;

use lodestar::Result;
use lodestar::scene::{LoadOptions, Scene, load};

/// Temporary folder of files.
struct Folder(tempfile::TempDir);

impl Folder {
    /// Folder with the given files. [`Folder::load`] reads the first one.
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            folder.write(name, text.as_bytes());
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: &[u8]) {
        std::fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        std::fs::write(self.path(name), content).unwrap();
    }

    fn load(&self, defines: &[(&str, &str)]) -> Result<Scene> {
        let defines = defines.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
        let mut scene = load(&self.path("scene.xml"), &LoadOptions { defines, ..LoadOptions::default() })?;
        // Most scenes of these tests are dark.
        scene.warnings.retain(|warning| !warning.contains("the scene has no light"));
        Ok(scene)
    }
}

/// Scene with a sensor and `body`, which begins on line 2.
fn with_sensor(body: &str) -> String {
    format!("<scene version=\"3.0.0\"><sensor type=\"perspective\"/>\n{body}\n</scene>")
}

/// Loads `body` beside a sensor.
fn load_body(body: &str) -> Result<Scene> {
    Folder::new(&[("scene.xml", &with_sensor(body))]).load(&[])
}

/// Loads a single shape beside a sensor, with an OBJ file `mesh.obj`.
fn load_mesh(obj: &str, parameters: &str) -> Result<Scene> {
    let body = format!(r#"<shape type="obj"><string name="filename" value="mesh.obj"/>{parameters}</shape>"#);
    Folder::new(&[("scene.xml", &with_sensor(&body)), ("mesh.obj", obj)]).load(&[])
}
