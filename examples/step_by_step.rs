//! Watches a picture come into being: `step_by_step SCENE.xml FOLDER` writes a PNG file every 16 samples per pixel.

use std::ops::ControlFlow;
use std::path::Path;

use lodestar::{Options, Session};

fn main() -> lodestar::Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, scene, folder] = &arguments[..] else { panic!("usage: step_by_step SCENE.xml FOLDER") };
    let mut session = Session::open(scene, &Options::new().samples(64).size(64, 64))?;
    for _ in 0..2 {
        let samples = session.step(16)?.samples;
        session.picture()?.write(Path::new(folder).join(format!("{samples}.png")))?;
    }
    session.run(|session| {
        println!("{:.0} %", 100.0 * session.progress().fraction);
        ControlFlow::Continue(())
    })?;
    session.picture()?.write(Path::new(folder).join("64.png"))
}
