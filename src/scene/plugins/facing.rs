//! What a disk that faces what it lights cannot have.

use super::shape::FACING_DISK;
use crate::Result;
use crate::scene::AreaEmitter;
use crate::scene::description::object::Object;

/// Checks the parts of a shape that faces what it lights.
pub(super) fn check(shape: &Object, emitter: Option<&Object>, bsdf: Option<&Object>, bounds: bool) -> Result<()> {
    if emitter.is_none() {
        return Err(shape.error(format!("a `{FACING_DISK}` is a lamp; give it an `area` emitter")));
    }
    if let Some(bsdf) = bsdf {
        return Err(bsdf.error(format!("a `{FACING_DISK}` has no BSDF, because all light passes it; leave it out")));
    }
    match bounds {
        true => Err(shape.error(format!("a `{FACING_DISK}` bounds no medium; leave the medium out"))),
        false => Ok(()),
    }
}

/// Checks the emitter of a shape that faces what it lights.
pub(super) fn check_radiance(emitter: &Object, area: &AreaEmitter) -> Result<()> {
    match area.radiance.texture {
        Some(_) => {
            let message = format!("the `radiance` of a `{FACING_DISK}` cannot be a texture, because the disk turns");
            Err(emitter.error(message + "; give it a color"))
        }
        None => Ok(()),
    }
}
