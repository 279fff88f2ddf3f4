//! Renders a scene file in its own size and writes the picture: `render_file SCENE OUT.exr`.

use std::env;
use std::path::Path;

use lodestar::{Error, Options};

fn main() -> lodestar::Result<()> {
    let arguments: Vec<String> = env::args().collect();
    let [_, scene, out] = &arguments[..] else {
        return Err(Error::Settings("usage: render_file SCENE OUT.exr".into()));
    };
    let picture = lodestar::render(scene, &Options::new().samples(64))?;
    let rgb = picture.rgb();
    println!("{} x {} pixels, the first is {:?}", picture.width, picture.height, rgb[0]);
    picture.write(Path::new(out))
}
