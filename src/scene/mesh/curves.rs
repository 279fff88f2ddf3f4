//! Mitsuba's text files of curves: a control point `x y z radius` on each line, an empty line between two curves.

use std::path::Path;

use glam::{DMat4, DVec3, DVec4};

use super::rings::{Curve, Kind};
use super::triangles::{MAX_TRIANGLES, Mesh};
use super::tubes;
use super::words::Words;
use crate::{Error, Result};

/// Curves that a shape makes of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(in crate::scene) struct CurveFormat {
    pub kind: Kind,
    /// Bits of the transform of the control points, column by column. Two shapes share the mesh of a file only if they
    /// place it alike, because radii stay as they are.
    to_world: [u64; 16],
}

impl CurveFormat {
    /// Curves of a kind whose control points are placed by `to_world`. Their radii are not scaled, as in Mitsuba.
    pub fn new(kind: Kind, to_world: &DMat4) -> Self {
        Self { kind, to_world: to_world.to_cols_array().map(f64::to_bits) }
    }

    fn to_world(self) -> DMat4 {
        DMat4::from_cols_array(&self.to_world.map(f64::from_bits))
    }
}

/// Reads the curves in the file at `path`, which holds `text`, and makes a mesh of them.
pub(super) fn parse(path: &Path, text: &[u8], format: &CurveFormat) -> Result<Mesh> {
    let curves = read(text, format).map_err(|(line, message)| Error::scene(path, Some(line), message))?;
    tubes::mesh(&curves).map_err(|message| Error::scene(path, None, message))
}

/// Curves of a text. An error names the line at fault.
fn read(text: &[u8], format: &CurveFormat) -> std::result::Result<Vec<Curve>, (u32, String)> {
    let mut reader = Reader { format, to_world: format.to_world(), curves: Vec::new(), open: None, count: 0 };
    let mut words = Words::new(text);
    loop {
        let line = words.line();
        match words.peek() {
            b"" => reader.finish_curve()?,
            _ => reader.add_point(&mut words).map_err(|message| (line, message))?,
        }
        if !words.next_line() {
            break;
        }
    }
    reader.finish_curve()?;
    match reader.curves.is_empty() {
        true => Err((1, "the file has no control points; give each a line `x y z radius`".into())),
        false => Ok(reader.curves),
    }
}

/// Curves read so far.
struct Reader<'a> {
    format: &'a CurveFormat,
    to_world: DMat4,
    curves: Vec<Curve>,
    /// Curve being read, with its first line.
    open: Option<(u32, Curve)>,
    /// Number of control points.
    count: usize,
}

impl Reader<'_> {
    fn add_point(&mut self, words: &mut Words) -> std::result::Result<(), String> {
        let line = words.line();
        // As in Mitsuba, what follows the radius is ignored.
        let [x, y, z, radius] =
            words.floats::<4>().map_err(|message| format!("{message}; a control point is `x y z radius`"))?;
        if radius < 0.0 {
            return Err(format!("the radius {radius} is negative; give 0 or more"));
        }
        self.count += 1;
        if self.count > MAX_TRIANGLES {
            return Err(format!("no more than {MAX_TRIANGLES} control points fit; leave some out"));
        }
        let place = self.to_world.transform_point3(DVec3::new(x.into(), y.into(), z.into()));
        let kind = self.format.kind;
        let (_, curve) = self.open.get_or_insert_with(|| (line, Curve { kind, points: Vec::new() }));
        curve.points.push(DVec4::new(place.x, place.y, place.z, radius.into()));
        Ok(())
    }

    fn finish_curve(&mut self) -> std::result::Result<(), (u32, String)> {
        let Some((line, curve)) = self.open.take() else { return Ok(()) };
        let (least, count) = (curve.kind.least_points(), curve.points.len());
        if count < least {
            let needs = format!("a curve of the shape `{}` needs at least {least} control points", curve.kind.plugin());
            return Err((
                line,
                format!("{needs}, but the one that begins here has {count}; an empty line ends a curve"),
            ));
        }
        self.curves.push(curve);
        Ok(())
    }
}
