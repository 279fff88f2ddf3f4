//! Scenes that the benches measure.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use lodestar::encode::bvh::Bvh;
use lodestar::scene::{self, LoadOptions, Scene};

use crate::bench::relief::tessellated;
use crate::scenes_folder;

/// Number of triangles of the Cornell box of relief.
const RELIEF_TRIANGLES: usize = 100_000;
/// Scenes in the project's folder `scenes`.
const OWN: [&str; 2] = ["cornell-box", "door-ajar"];
/// Scenes in the folder that `LODESTAR_SCENES` names.
const SHARED: [&str; 2] = ["staircase2", "kitchen"];

/// Scene with its hierarchy.
pub struct Subject {
    pub name: String,
    /// File of the scene; `None` for a scene that this program creates.
    pub file: Option<PathBuf>,
    pub scene: Scene,
    pub bvh: Bvh,
}

impl Subject {
    fn load(folder: &Path, name: &str) -> Option<Rc<Self>> {
        let file = folder.join(name).join("scene.xml");
        if !file.is_file() {
            println!("{name}: skipped, {} is not there", file.display());
            return None;
        }
        let scene = scene::load(&file, &LoadOptions::default()).expect("the scene loads");
        let bvh = Bvh::of_scene(&scene);
        Some(Rc::new(Self { name: name.into(), file: Some(file), scene, bvh }))
    }

    fn relief() -> Rc<Self> {
        let scene = tessellated(RELIEF_TRIANGLES);
        let bvh = Bvh::of_scene(&scene);
        Rc::new(Self { name: "relief".into(), file: None, scene, bvh })
    }
}

/// The project's own scenes, and the shared scenes if they are available.
pub fn all() -> Vec<Rc<Subject>> {
    let own = scenes_folder();
    let mut subjects: Vec<_> = OWN.iter().filter_map(|name| Subject::load(&own, name)).collect();
    subjects.push(Subject::relief());
    match std::env::var_os("LODESTAR_SCENES").map(PathBuf::from) {
        Some(shared) => subjects.extend(SHARED.iter().filter_map(|name| Subject::load(&shared, name))),
        None => println!("{} are skipped: LODESTAR_SCENES names no folder", SHARED.join(" and ")),
    }
    subjects
}
