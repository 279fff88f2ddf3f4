//! Another scene for a render that has begun: the guide and what has not changed stay, and the film begins anew.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use crate::encode::bvh::Bvh;
use crate::encode::surfaces::Surfaces;
use crate::renderer::another_scene::AnotherScene;
use crate::scene::fingerprint::{Fingerprints, fingerprints};
use crate::session::history::History;
use crate::session::origin::Origin;
use crate::session::progress::{Event, Preparation, Watch};
use crate::session::running::Running;
use crate::session::start::SceneInput;
use crate::session::statistics::{SetupTimes, timed};
use crate::settings::Settings;
use crate::{Error, Result};

impl Running {
    /// Renders another scene from now on. The guide stays; samples and time are counted anew. Where this fails, nothing has changed.
    pub fn change_scene(&mut self, input: SceneInput<'_>, watch: &Watch<'_>) -> Result<()> {
        if self.checkpoints.is_some() {
            let message = "a render that keeps a checkpoint cannot change its scene, because the checkpoint is that of the scene's file; \
                           leave out the checkpoint";
            return Err(Error::Settings(message.into()));
        }
        let begin = Instant::now();
        let input = input.in_folder(watch)?;
        let (scene, load_seconds) = timed(|| input.load(Some(&self.subject.meshes), watch))?;
        watch.warn_once(&scene.warnings);
        let Fingerprints { scene: scene_hash, world: world_hash, geometry } = fingerprints(&scene)?;
        let (settings, length) = self.subject.options.for_another_scene(&scene, &self.settings)?;

        let primitive_count = scene.stored_primitives();
        watch.tell(Event::Preparing(Preparation::Hierarchy(primitive_count)));
        let keeps_geometry = geometry == self.subject.geometry;
        let known = self.subject.bvh.as_ref().filter(|_| keeps_geometry);
        let hierarchy = || known.map_or_else(|| Arc::new(Bvh::of_scene(&scene)), Arc::clone);
        let prepare = || rayon::join(hierarchy, || Surfaces::new(&scene));
        let ((bvh, surfaces), bvh_seconds) = timed(|| Ok(prepare()))?;
        watch.tell(Event::Preparing(Preparation::Kernels));
        let registry = self.subject.kernel_files.registry();
        let another = AnotherScene { scene: &scene, bvh: &bvh, keeps_geometry, settings, registry };
        let (guide, pipeline_seconds) = timed(|| self.fleet.change_scene(&another, surfaces))?;

        let seed = self.renderer().settings().seed;
        (self.settings, self.length) = (Settings { seed, ..another.settings }, length);
        (self.history, self.origin) = (History::default(), Origin { guide, ..Origin::default() });
        let back_end = self.renderer().back_end();
        let subject = &mut self.subject;
        subject.scene_path = input.absolute_path().unwrap_or_else(|| PathBuf::from(&scene.name));
        subject.scene_name.clone_from(&scene.name);
        (subject.scene_hash, subject.world_hash) = (scene_hash, world_hash);
        (subject.geometry, subject.bvh, subject.is_changed) = (geometry, Some(bvh), true);
        subject.kernels = subject.kernel_files.used(back_end);
        let setup_seconds = begin.elapsed().as_secs_f64();
        subject.times = SetupTimes { load_seconds, bvh_seconds, pipeline_seconds, setup_seconds, primitive_count };
        self.output.begin_anew(true);
        Ok(())
    }
}
