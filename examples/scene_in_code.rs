//! Renders a scene made in code: `scene_in_code OUT.exr`. A mesh and a sphere stand under a lamp.

use lodestar::scene::{Camera, Environment};
use lodestar::{Error, Options, Scene, Session};

fn main() -> lodestar::Result<()> {
    let usage = || Error::Settings("usage: scene_in_code OUT.exr".into());
    let out = std::env::args().nth(1).ok_or_else(usage)?;
    let mut scene = Scene::new(Camera::look_at([0.0, 2.0, 6.0], [0.0, 0.5, 0.0], 45.0), 64, 48);
    let (gray, red) = (scene.add_diffuse([0.6; 3]), scene.add_diffuse([0.7, 0.1, 0.1]));
    let lamp = scene.add_light([12.0; 3]);
    scene.add_parallelogram([0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0], gray);
    scene.add_parallelogram([0.0, 4.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], lamp);
    scene.add_sphere([1.0, 0.8, 0.0], 0.8, red);
    let corners = [[-2.0, 0.0, 1.0], [-0.5, 0.0, 1.0], [-1.2, 0.0, -0.5], [-1.2, 1.5, 0.0]];
    scene.add_mesh(&corners, &[[0, 1, 3], [1, 2, 3], [2, 0, 3]], gray);
    scene.environment = Some(Environment::constant([0.1, 0.15, 0.2].into()));
    let mut session = Session::new(&scene, &Options::new().seed(3))?;
    session.step(32)?;
    session.picture()?.write(out)
}
