//! Watches a picture come into being: `step_by_step SCENE FOLDER` writes a PNG file every 16 samples per pixel, up to 64.

use std::path::Path;

use lodestar::{Error, Options, Session};

fn main() -> lodestar::Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, scene, folder] = &arguments[..] else {
        return Err(Error::Settings("usage: step_by_step SCENE FOLDER".into()));
    };
    let mut session = Session::open(scene, &Options::new().samples(64).size(64, 64))?;
    for _ in 0..4 {
        let progress = session.step(16)?;
        println!("{:.0} %", 100.0 * progress.fraction);
        session.picture()?.write(Path::new(folder).join(format!("{}.png", progress.samples)))?;
    }
    Ok(())
}
