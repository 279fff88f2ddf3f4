//! Readers of `<volume>`: `constvolume` and `gridvolume`, with the parameters and defaults of Mitsuba 3.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat4, UVec3, Vec3};

use super::grid_file;
use super::properties::Properties;
use super::scope::Scope;
use crate::scene::description::kinds::Kind;
use crate::scene::grids::Grid;
use crate::scene::medium::{Volume, VolumeWrap};
use crate::{Result, inputs};

/// Largest file of a grid, in bytes.
const MOST_BYTES: u64 = 1 << 30;

/// What a `<volume>`, or the color in its place, gives.
pub(super) enum Varying {
    /// A value that is the same everywhere, over the box of its `to_world`.
    Constant(Vec3, DMat4),
    /// A grid.
    Grid(Volume),
}

impl Varying {
    /// Value in single precision, with the box of Mitsuba's `constvolume` as a grid of one voxel.
    pub fn into_volume(self) -> Volume {
        match self {
            Self::Grid(volume) => volume,
            Self::Constant(value, unit_from_world) => Volume {
                unit_from_world,
                size: UVec3::ONE,
                values: Arc::new(value.to_array().to_vec()),
                has_colors: true,
                is_nearest: true,
                wrap: VolumeWrap::Clamp,
            },
        }
    }
}

/// Grids of a scene while it is read: each file is read once.
#[derive(Default)]
pub(super) struct Grids {
    known: HashMap<(PathBuf, bool), Arc<Grid>>,
}

impl Grids {
    /// Reads a parameter of a medium that a color or a volume gives; `None` where it is not given.
    pub fn varying<'a>(
        &mut self,
        properties: &mut Properties<'a>,
        name: &str,
        scope: &Scope<'a>,
        warnings: &mut Vec<String>,
    ) -> Result<Option<Varying>> {
        let Some(volume) = properties.nested(name, Kind::Volume)? else {
            return Ok(properties.color(name)?.map(|value| Varying::Constant(value, DMat4::IDENTITY)));
        };
        let mut inner = Properties::new(volume, scope)?;
        let location = inner.location("to_world");
        let unit_from_world = inner.take_to_world()?.inverse();
        if !unit_from_world.is_finite() {
            return Err(location.error("the `to_world` of a volume flattens it; no box remains"));
        }
        let varying = match inner.plugin() {
            "constvolume" => {
                let value = inner.color("value")?.unwrap_or(Vec3::ONE);
                Varying::Constant(value, unit_from_world)
            }
            "gridvolume" => Varying::Grid(self.grid_volume(&mut inner, unit_from_world)?),
            _ => return Err(volume.unsupported(&["constvolume", "gridvolume"])),
        };
        inner.finish(warnings)?;
        Ok(Some(varying))
    }

    fn grid_volume(&mut self, properties: &mut Properties, unit_from_world: DMat4) -> Result<Volume> {
        let object = properties.owner();
        let (mut is_nearest, mut wrap) = (false, VolumeWrap::Clamp);
        let location = properties.location("filter_type");
        if let Some(filter) = properties.string("filter_type")? {
            is_nearest = match filter {
                "trilinear" => false,
                "nearest" => true,
                _ => return Err(location.error("`filter_type` of a volume should be `trilinear` or `nearest`")),
            };
        }
        let location = properties.location("wrap_mode");
        if let Some(mode) = properties.string("wrap_mode")? {
            wrap = match mode {
                "clamp" => VolumeWrap::Clamp,
                "repeat" => VolumeWrap::Repeat,
                "mirror" => VolumeWrap::Mirror,
                // pbrt's grids.
                "zero" => VolumeWrap::Zero,
                _ => return Err(location.error("`wrap_mode` of a volume should be `clamp`, `repeat` or `mirror`")),
            };
        }
        let uses_box = properties.boolean("use_grid_bbox")?.unwrap_or(false);
        // They choose how Mitsuba looks values up. In its variants of three colors, `raw` changes nothing.
        properties.ignore(&["raw", "accel"]);
        let grid = match properties.grid("grid") {
            Some(grid) => grid,
            None => self.file(properties)?,
        };
        let mut unit_from_world = unit_from_world;
        if uses_box {
            let [low, high] = grid.corners;
            let box_from_unit = DMat4::from_translation(low) * DMat4::from_scale(high - low);
            unit_from_world = box_from_unit.inverse() * unit_from_world;
            if !unit_from_world.is_finite() {
                return Err(object.error("the box in the file of the volume is flat; set `use_grid_bbox` to false"));
            }
        }
        let Grid { size, has_colors, ref values, .. } = *grid;
        Ok(Volume { unit_from_world, size, values: Arc::clone(values), has_colors, is_nearest, wrap })
    }

    /// Grid of the file that the parameter `filename` names.
    fn file(&mut self, properties: &mut Properties) -> Result<Arc<Grid>> {
        let (found, parameter) = properties.file("filename", "volume")?;
        let key = (found.path.clone(), found.bytes.is_some());
        if let Some(known) = self.known.get(&key) {
            return Ok(Arc::clone(known));
        }
        let content = match &found.bytes {
            Some(bytes) => bytes.to_vec(),
            None => inputs::read(&found.path, MOST_BYTES)?,
        };
        let grid = grid_file::read(&content)
            .map_err(|message| parameter.error(format!("the volume `{}` {message}", parameter.text())))?;
        let grid = Arc::new(grid);
        self.known.insert(key, Arc::clone(&grid));
        Ok(grid)
    }
}
