//! The table of scenes. Each shows one feature, or a pair, on a small stage.

mod bsdfs;
mod cameras;
mod curves;
mod cylinders;
mod emitters;
mod extremes;
mod fibers;
mod lamps;
mod measured;
mod media;
mod passages;
mod paths;
mod shapes;
mod volumes;
pub mod xml;

use std::fmt;

use support::tier;

use crate::verdict::Verdict;
use xml::{diffuse, film, lamp, path, perspective, wall};

/// Classes of features. Each has a twin that must fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    Shapes,
    Bsdfs,
    Emitters,
    Cameras,
    Paths,
    Extremes,
    Curves,
    Passages,
    Media,
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&format!("{self:?}").to_lowercase())
    }
}

/// Where the right picture of a scene comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reference {
    /// Mitsuba's picture of the scene.
    Mitsuba,
    /// Picture of another scene, which this scene must have by closed form.
    Like(&'static str),
    /// The color of every pixel, by closed form.
    Uniform([f64; 3]),
}

/// Known difference from the reference, which only the full tier shows. The test fails there where the difference is gone.
#[derive(Debug, Clone, Copy)]
pub struct Known {
    pub reason: &'static str,
    /// Largest shares by which the mean, and the most improbable block, may differ for that reason.
    pub mean: f64,
    pub block: f64,
}

impl Known {
    /// Whether this run must show the difference, where emitters are sampled.
    pub fn shows(self) -> bool {
        tier::is_full()
    }

    /// Whether it explains what a comparison has found.
    pub fn explains(self, verdict: &Verdict) -> bool {
        (verdict.ratio - 1.0).abs() <= self.mean && (verdict.worst.1 - 1.0).abs() <= self.block
    }
}

/// Row of the table.
pub struct Case {
    pub class: Class,
    /// Number of the scene, from 1. It is the seed, so that noise of different scenes is independent.
    pub number: u32,
    pub name: String,
    pub xml: String,
    pub reference: Reference,
    pub known: Option<Known>,
    /// Whether the lamp is so small that paths hardly ever find it by chance.
    pub is_hard_to_hit: bool,
}

/// Parts of a scene.
pub struct Stage {
    pub integrator: String,
    pub sensor: String,
    pub room: String,
    pub lamp: String,
    pub subject: String,
    pub reference: Reference,
    pub is_hard_to_hit: bool,
}

impl Stage {
    /// A floor, a wall behind it, a lamp above, and no subject.
    fn new() -> Self {
        Self {
            integrator: path(6),
            sensor: perspective("<float name='fov' value='40'/>", &film("<rfilter type='box'/>")),
            room: wall("<rotate x='1' angle='-90'/>", "0.5,0.5,0.55") + &wall("<translate z='-2'/>", "0.6,0.3,0.2"),
            lamp: lamp("9,8,6"),
            subject: String::new(),
            reference: Reference::Mitsuba,
            is_hard_to_hit: false,
        }
    }
}

/// Table that is being written.
#[derive(Default)]
pub struct Table(Vec<Case>);

impl Table {
    /// Adds a scene that differs from the plain stage by `change`.
    fn add(&mut self, class: Class, name: impl Into<String>, change: impl FnOnce(&mut Stage)) {
        let mut stage = Stage::new();
        change(&mut stage);
        let Stage { integrator, sensor, room, lamp, subject, reference, is_hard_to_hit } = stage;
        let parts = [integrator, sensor, room, lamp, subject].join("\n");
        let xml = format!("<scene version='3.0.0'>\n{parts}\n</scene>\n");
        let number = self.0.len() as u32 + 1;
        self.0.push(Case { class, number, name: name.into(), xml, reference, known: None, is_hard_to_hit });
    }

    /// Notes a known difference of the scene that was added last.
    fn known(&mut self, known: Known) {
        if let Some(case) = self.0.last_mut() {
            case.known = Some(known);
        }
    }

    /// Adds a scene with this subject.
    fn show(&mut self, class: Class, name: impl Into<String>, subject: impl Into<String>) {
        self.add(class, name, |stage| stage.subject = subject.into());
    }
}

/// All scenes. Names differ.
pub fn all() -> Vec<Case> {
    let mut table = Table::default();
    shapes::add(&mut table);
    bsdfs::add(&mut table);
    emitters::add(&mut table);
    cameras::add(&mut table);
    paths::add(&mut table);
    extremes::add(&mut table);
    cylinders::add(&mut table);
    curves::add(&mut table);
    passages::add(&mut table);
    media::add(&mut table);
    volumes::add(&mut table);
    lamps::add(&mut table);
    fibers::add(&mut table);
    measured::add(&mut table);
    table.0
}

/// Fault in one scene of a class: a `<default>` of the scene and a wrong value for it, which is 2 % off or changes the picture's
/// mean by 2 %; and a value that is wrong by so much that few samples show it.
pub struct Twin {
    pub scene: &'static str,
    pub parameter: &'static str,
    pub wrong: &'static str,
    pub far: &'static str,
}

/// The twin of a class.
pub fn twin(class: Class) -> Twin {
    let (scene, parameter, wrong, far) = match class {
        Class::Shapes => ("sphere-plain", "size", "0.714", "0.9"),
        Class::Bsdfs => ("diffuse", "albedo", "0.714", "0.9"),
        Class::Emitters => ("lamp-sphere-plain", "radiance", "4.08", "5"),
        Class::Cameras => ("perspective-x", "fov", "40.8", "48"),
        Class::Paths => ("depth-3", "depth", "4", "2"),
        Class::Extremes => ("scale-1", "size", "0.714", "0.9"),
        Class::Passages => ("mask-sun", "opacity", "0.42", "0.6"),
        Class::Media => ("fog-twin", "density", "0.206", "0.3"),
        Class::Curves => ("bsplinecurve-plain", "file", "bsplinecurve-thicker.txt", "bsplinecurve-thick.txt"),
    };
    Twin { scene, parameter, wrong, far }
}

/// A diffuse subject of the given albedo.
fn plain_subject(albedo: &str) -> String {
    xml::ball(&diffuse(albedo)) + &xml::block(&diffuse(albedo))
}
