//! Renders a scene file and writes the picture: `render_file SCENE.xml OUT.exr`.

use std::env;
use std::path::Path;

use lodestar::Options;

fn main() -> lodestar::Result<()> {
    let arguments: Vec<String> = env::args().collect();
    let [_, scene, out] = &arguments[..] else { panic!("usage: render_file SCENE.xml OUT.exr") };
    let picture = lodestar::render(scene, &Options::new().samples(64).size(64, 64))?;
    let rgb = picture.rgb();
    println!("{} x {} pixels, the first is {:?}", picture.width, picture.height, rgb[0]);
    picture.write(Path::new(out))
}
