//! The page of a picture file.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use crate::Result;
use crate::files::has_extension;
use crate::image::layers::{Layers, Samples};
use crate::image::{color, exr};
use crate::view::board::{Board, Phase};
use crate::view::names::file_name;
use crate::view::server::Server;
use crate::view::shot::{Content, Shot};

/// A page that shows a picture file. The picture is read again when the file changes.
pub struct FileView {
    board: Arc<Board>,
    server: Server,
    path: PathBuf,
    changed: Option<SystemTime>,
    shots: u64,
}

impl FileView {
    /// Serves the picture in the file `path` at `address`.
    ///
    /// # Errors
    /// Where the file is no picture, or the address cannot be used.
    pub fn start(path: &Path, address: &str) -> Result<Self> {
        let layers = read(path)?;
        let board = Arc::new(Board::default());
        let server = Server::start(address, Arc::clone(&board))?;
        let mut view = Self { board, server, path: path.to_path_buf(), changed: changed(path), shots: 0 };
        view.show(layers);
        Ok(view)
    }

    /// Address of the page.
    pub fn url(&self) -> String {
        self.server.url()
    }

    /// Reads the picture again if its file has changed. A file that cannot be read is tried again when it changes.
    pub fn refresh(&mut self) {
        let now = changed(&self.path);
        if now.is_some() && now != self.changed {
            self.changed = now;
            if let Ok(layers) = read(&self.path) {
                self.show(layers);
            }
        }
    }

    fn show(&mut self, layers: Layers) {
        self.shots += 1;
        let attributes = exr::read_attributes(&self.path).unwrap_or_default();
        let text = |name: &str| attributes.iter().find(|(found, _)| found == name).map(|(_, value)| value.clone());
        let samples = text("spp").and_then(|spp| spp.parse().ok()).unwrap_or(0);
        let seconds = text("seconds").and_then(|seconds| seconds.parse().ok()).unwrap_or(0.0);
        let shot = Shot::new(self.shots, samples, seconds, Content::Read(layers));
        self.board.change(|pinned| {
            let state = &mut pinned.state;
            (state.phase, state.shot) = (Phase::File, self.shots);
            (state.samples, state.seconds, state.fraction) = (samples, seconds, 1.0);
            state.scene = file_name(&self.path);
            state.device = text("device").unwrap_or_default();
            state.sampler = text("sampler").unwrap_or_default();
            state.no_guide =
                Some("A file has no guide. Watch the render with --view to see what the guide learns.".into());
            pinned.shot = Some(Arc::new(shot));
        });
    }
}

/// Layers of a picture that lodestar has written, or the color of another one.
fn read(path: &Path) -> Result<Layers> {
    let layers = if has_extension(path, "exr") { exr::read_layers(path).ok() } else { None };
    layers.map(|(layers, _)| Ok(layers)).unwrap_or_else(|| {
        let (image, _) = color::read(path)?;
        let (width, height) = (image.width, image.height);
        let channel = |c: usize| Samples::Floats(image.pixels.iter().map(|pixel| pixel[c]).collect());
        let channels = ["R", "G", "B"].into_iter().enumerate().map(|(c, name)| (name.to_owned(), channel(c)));
        Ok(Layers { width, height, offset: [0, 0], full_size: [width, height], channels: channels.collect() })
    })
}

fn changed(path: &Path) -> Option<SystemTime> {
    std::fs::metadata(path).and_then(|metadata| metadata.modified()).ok()
}
