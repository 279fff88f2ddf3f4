//! Another view of a render that has begun: the camera and the size of the film change, and the film begins anew.

use crate::scene::Camera;
use crate::session::history::History;
use crate::session::origin::Origin;
use crate::session::running::Running;
use crate::settings::Settings;
use crate::{Error, Result};

impl Running {
    /// Camera of the picture.
    pub fn camera(&self) -> &Camera {
        self.renderer().camera()
    }

    /// Shows the scene from now on by `camera` on a film of this size. The guide stays; samples and time are counted anew.
    pub fn change_view(&mut self, camera: &Camera, size: [u32; 2]) -> Result<()> {
        if self.checkpoints.is_some() {
            let message = "a render that keeps a checkpoint cannot change its camera or its size, because the checkpoint is that of the \
                           scene's file; leave out the checkpoint";
            return Err(Error::Settings(message.into()));
        }
        let (of_camera, old) = (*camera != *self.camera(), [self.settings.width, self.settings.height]);
        self.fleet.change_view(camera, size)?;
        let Settings { width, height, crop, seed, .. } = self.renderer().settings().clone();
        self.settings = Settings { width, height, crop, seed, ..self.settings.clone() };
        (self.history, self.origin) = (History::default(), Origin::default());
        self.subject.change_view(of_camera.then_some(camera))?;
        self.output.begin_anew(of_camera || size != old);
        Ok(())
    }
}
