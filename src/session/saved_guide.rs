//! Guides in their files. A guide's file has a header and parts (`sealed.rs`): the header names version, scene, settings, grid, lights and
//! samples, and the parts are what was learned. It may come from somebody else, so everything in it is checked before it is used.

use std::path::Path;

use glam::{UVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::encode::cells::{Cells, Grid};
use crate::film::ranges::SampleRanges;
use crate::renderer::StatePart;
use crate::renderer::guide_state::check_learns_radiance;
use crate::renderer::guide_tables::{GuideTables, TableSizes};
use crate::session::sealed::{Kind, PartEntry, Reader, SavedParts, VERSION};
use crate::settings::Settings;
use crate::{Error, Result, files};

/// Files of guides.
pub(super) const GUIDE: Kind = Kind {
    magic: *b"LDSTG\r\n\x1a",
    refusal: "it is no guide; give a file of --guide-out",
    of_other_version: "may learn otherwise; learn it anew",
    of_other_build: "learn it anew",
    of_damage: "give another copy",
};
/// Names of the parts, in their order.
const PARTS: [&str; 5] = ["cells", "learned", "lights", "shares", "marks"];
/// Most places along an axis, and most groups of lights, of a guide that is read.
const MOST_PLACES: u32 = 64;
const MOST_GROUPS: usize = 1 << 10;

/// The scene that a guide has learned.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuideScene {
    /// Name of the scene.
    pub name: String,
    /// Fingerprint of the scene without its camera and film.
    pub hash: String,
}

/// A guide as its file holds it.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedGuide {
    /// The scene that it has learned.
    pub scene: GuideScene,
    /// What it has learned.
    pub tables: GuideTables,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    version: String,
    scene: GuideScene,
    settings: Settings,
    grid: GridEntry,
    light_groups: Vec<f32>,
    samples: SampleRanges,
    parts: Vec<PartEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct GridEntry {
    origin: Vec3,
    per_unit: Vec3,
    size: UVec3,
}

impl SavedGuide {
    /// Whether the file at `path` begins as a guide does.
    ///
    /// # Errors
    /// [`Error::Read`].
    pub fn is_in(path: &Path) -> Result<bool> {
        GUIDE.is_of(path)
    }

    /// Writes the guide whole or not at all.
    ///
    /// # Errors
    /// [`Error::Write`], or [`Error::Checkpoint`] if it holds radiance that its file cannot have. An older file then stays as it was.
    pub fn write(&self, path: &Path) -> Result<()> {
        if !files::has_extension(path, "guide") {
            return Err(Error::checkpoint(path, "a guide's file has a name that ends in .guide"));
        }
        if !self.tables.are_sound() {
            let message = "the guide has learned radiance so bright that its sums overflow, so it is not written; give the scene \
                           darker lamps and a higher --exposure";
            return Err(Error::checkpoint(path, message));
        }
        self.write_unchecked(path)
    }

    fn write_unchecked(&self, path: &Path) -> Result<()> {
        let GuideTables { settings, cells, group_powers, samples, learned, lights, shares, marks } = &self.tables;
        let contents = [
            cells.occupancy(),
            bytemuck::cast_slice(learned).to_vec(),
            bytemuck::cast_slice(lights).to_vec(),
            bytemuck::cast_slice(shares).to_vec(),
            marks.clone(),
        ];
        let parts = PARTS.into_iter().zip(contents).map(|(name, bytes)| StatePart { name: name.into(), bytes });
        let parts: Vec<_> = parts.collect();
        let Grid { origin, per_unit, size } = cells.grid;
        let header = Header {
            version: VERSION.into(),
            scene: self.scene.clone(),
            settings: settings.clone(),
            grid: GridEntry { origin, per_unit, size },
            light_groups: group_powers.clone(),
            samples: samples.clone(),
            parts: parts.iter().map(PartEntry::from).collect(),
        };
        GUIDE.write(path, &header, &parts)
    }

    /// Reads a guide of this version, and checks all that it holds.
    ///
    /// # Errors
    /// [`Error::Read`], or [`Error::Checkpoint`] if the file is no guide, is of another version, was cut short or altered, or holds what
    /// no render learns.
    pub fn read(path: &Path) -> Result<Self> {
        let refuse = |fault: &str| Error::checkpoint(path, format!("{fault}; {}", GUIDE.of_damage));
        let mut reader = Reader::open(path, &GUIDE)?;
        let header: Header = reader.header()?;
        let Header { scene, settings, grid, light_groups, samples, parts, .. } = header;
        let settings_checked = settings.validate().and_then(|()| check_learns_radiance(&settings));
        settings_checked.map_err(|error| Error::checkpoint(path, error.to_string()))?;
        let is_text = |text: &String| !text.chars().any(char::is_control);
        if !is_text(&scene.name) || !is_text(&scene.hash) {
            return Err(refuse("it names its scene by control characters"));
        }
        if !samples.is_sound() {
            return Err(refuse("it has sample numbers that no render takes"));
        }
        let grid = grid.checked().ok_or_else(|| refuse("its grid has no finite place or size"))?;
        if light_groups.len() > MOST_GROUPS {
            return Err(refuse("it has more groups of lights than any scene"));
        }
        reader.check_lengths(&parts)?;
        let parts = reader.into_parts(parts)?;
        let lacks = || refuse("its parts are not those of its cells");
        let occupancy = part(&parts, "cells", grid.place_count().div_ceil(8) as u64)?.ok_or_else(lacks)?;
        let cells = Cells::of_occupancy(grid, &occupancy);
        let sizes = TableSizes::new(&settings, cells.count(), light_groups.len() as u32);
        let part = |name: &str, bytes: u64| part(&parts, name, bytes)?.ok_or_else(lacks);
        let tables = GuideTables {
            learned: bytemuck::pod_collect_to_vec(&part("learned", 8 * sizes.learned)?),
            lights: bytemuck::pod_collect_to_vec(&part("lights", 8 * sizes.lights)?),
            shares: bytemuck::pod_collect_to_vec(&part("shares", 4 * sizes.shares)?),
            marks: part("marks", sizes.marks)?,
            settings,
            cells,
            group_powers: light_groups,
            samples,
        };
        if !tables.are_sound() {
            return Err(refuse("it holds radiance that no render learns"));
        }
        Ok(Self { scene, tables })
    }
}

impl GridEntry {
    /// The grid, if its numbers are such as a scene has.
    fn checked(self) -> Option<Grid> {
        let Self { origin, per_unit, size } = self;
        let is_placed = origin.is_finite() && per_unit.is_finite() && per_unit.cmpgt(Vec3::ZERO).all();
        let has_places = size.cmpge(UVec3::ONE).all() && size.cmple(UVec3::splat(MOST_PLACES)).all();
        (is_placed && has_places).then_some(Grid { origin, per_unit, size })
    }
}

/// Content of the part `name`, if it has this length in bytes.
fn part(parts: &SavedParts, name: &str, bytes: u64) -> Result<Option<Vec<u8>>> {
    let found = parts.read(|found, length| found == name && length == bytes)?;
    Ok(found.into_iter().next().map(|part| part.bytes))
}

/// Merges guides of one scene that have learned from different samples, and names the files at fault by `paths`.
///
/// # Errors
/// [`Error::Checkpoint`] where two guides have learned in different ways, in different cells or scenes, or from the same samples.
pub fn merge(guides: Vec<SavedGuide>, paths: &[impl AsRef<Path>]) -> Result<SavedGuide> {
    let refuse = |at: usize, fault: String| {
        Err(Error::checkpoint(&paths[at], format!("it cannot be merged with {}: {fault}", paths[0].as_ref().display())))
    };
    let Some(first) = guides.first().cloned() else {
        return Err(Error::Settings("name two guides or more".into()));
    };
    let mut samples = SampleRanges::default();
    for (at, guide) in guides.iter().enumerate() {
        if let Some(fault) = first.tables.difference(&guide.tables) {
            return refuse(at, fault);
        }
        if first.scene.hash != guide.scene.hash {
            let [ours, theirs] = [&first.scene.hash, &guide.scene.hash];
            return refuse(at, format!("they have learned other scenes ({ours} and {theirs})"));
        }
        if let Some(overlap) = samples.overlap(&guide.tables.samples) {
            let message = format!(
                "an earlier guide has learned from its samples {overlap}, too; guides are merged that have learned from others"
            );
            return Err(Error::checkpoint(&paths[at], message));
        }
        samples = samples.union(guide.tables.samples.clone());
    }
    let tables = GuideTables::merged(guides.into_iter().map(|guide| guide.tables).collect());
    Ok(SavedGuide { tables: tables.unwrap_or(first.tables), scene: first.scene })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    use xxhash_rust::xxh3::xxh3_128;

    use crate::generated::layout::LearnedRadiance;
    use crate::scene::{FilmDescription, IntegratorDescription, ReconstructionFilter};
    use crate::session::sealed::PREFIX_BYTES;
    use crate::settings::Sampler;

    fn example() -> SavedGuide {
        let film = FilmDescription { width: 8, height: 8, crop: None, filter: ReconstructionFilter::Box };
        let settings = Settings { directions: 16, ..Settings::for_film(&film, &IntegratorDescription::default()) };
        let grid =
            Grid { origin: Vec3::new(0.1, -2.0, 3.0), per_unit: Vec3::splat(1.0 / 3.0), size: UVec3::new(3, 2, 2) };
        let cells = Cells::of_occupancy(grid, &[0b1011_0101, 0b1]);
        let sizes = TableSizes::new(&settings, cells.count(), 2);
        let learned = LearnedRadiance { mean: 0.1, weight: 3.0 };
        let tables = GuideTables {
            settings,
            cells,
            group_powers: vec![0.25, 0.75],
            samples: "7:0..64".parse().unwrap(),
            learned: vec![learned; sizes.learned as usize],
            lights: vec![learned; sizes.lights as usize],
            shares: vec![0.5; sizes.shares as usize],
            marks: vec![5; sizes.marks as usize],
        };
        SavedGuide { scene: GuideScene { name: "küche".into(), hash: "00ff".into() }, tables }
    }

    fn written() -> (tempfile::TempDir, std::path::PathBuf, Vec<u8>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.guide");
        example().write(&path).unwrap();
        let bytes = fs::read(&path).unwrap();
        (folder, path, bytes)
    }

    /// Writes `bytes` to the file, checks that reading them fails in one sentence that names the file, and returns the sentence.
    fn refused(path: &Path, bytes: &[u8]) -> String {
        fs::write(path, bytes).unwrap();
        let text = SavedGuide::read(path).unwrap_err().to_string();
        assert!(text.contains("a.guide: ") && !text.contains('\n'), "{text}");
        text
    }

    #[test]
    fn what_is_written_comes_back() {
        let (_folder, path, _) = written();
        assert_eq!(SavedGuide::read(&path).unwrap(), example());
        assert!(SavedGuide::is_in(&path).unwrap());
    }

    #[test]
    fn no_cut_and_no_altered_byte_goes_unnoticed() {
        let (_folder, path, whole) = written();
        for length in (0..whole.len()).step_by(61) {
            refused(&path, &whole[..length]);
        }
        refused(&path, &[&whole[..], &[0]].concat());
        for position in (0..whole.len()).step_by(3) {
            let mut bytes = whole.clone();
            bytes[position] ^= 0x10;
            refused(&path, &bytes);
        }
    }

    /// The file with a header that `change` has changed, whose hash is right.
    fn forged(whole: &[u8], change: impl FnOnce(&mut Header)) -> Vec<u8> {
        let length = u64::from_le_bytes(whole[8..16].try_into().unwrap()) as usize;
        let (header, parts) = whole[PREFIX_BYTES as usize..].split_at(length);
        let mut header: Header = serde_json::from_slice(header).unwrap();
        change(&mut header);
        let header = serde_json::to_vec(&header).unwrap();
        let length = (header.len() as u64).to_le_bytes();
        [&whole[..8], &length, &xxh3_128(&header).to_le_bytes(), &header, parts].concat()
    }

    /// A change of the header, and a word of the sentence that refuses it.
    type Forged = (fn(&mut Header), &'static str);

    #[test]
    fn forged_headers_are_refused() {
        let changes: [Forged; 12] = [
            (|header| header.version = "9.8.7".into(), "version 9.8.7"),
            (|header| header.scene.name = "a\u{1b}[2J".into(), "control characters"),
            (|header| header.settings.sampler = Sampler::Bsdf, "learns nothing"),
            (|header| header.settings.directions = 32, "not those of its cells"),
            (|header| header.grid.size = UVec3::ZERO, "no finite place or size"),
            (|header| header.grid.size = UVec3::MAX, "no finite place or size"),
            (|header| header.grid.size = UVec3::new(1, 1, MOST_PLACES + 1), "no finite place or size"),
            (|header| header.grid.size.x += 7, "not those of its cells"),
            (|header| header.grid.per_unit.y = 0.0, "no finite place or size"),
            (|header| header.light_groups.push(0.5), "not those of its cells"),
            (|header| header.light_groups = vec![0.0; MOST_GROUPS + 1], "more groups of lights"),
            (|header| header.light_groups[0] = 3.0, "radiance that no render learns"),
        ];
        let (_folder, path, whole) = written();
        for (change, word) in changes {
            let text = refused(&path, &forged(&whole, change));
            assert!(text.contains(word), "{text}");
        }
        fs::write(&path, forged(&whole, |_| {})).unwrap();
        assert_eq!(SavedGuide::read(&path).unwrap(), example());
    }

    #[test]
    fn forged_radiance_is_refused() {
        let (_folder, path, _) = written();
        let mut guide = example();
        guide.tables.learned[0].mean = f32::NAN;
        assert!(guide.write(&path).unwrap_err().to_string().contains("so bright"));
        guide.write_unchecked(&path).unwrap();
        let text = refused(&path, &fs::read(&path).unwrap());
        assert!(text.contains("radiance that no render learns"), "{text}");
    }

    #[test]
    fn what_is_no_guide_is_told_so() {
        let (_folder, path, whole) = written();
        assert!(refused(&path, b"<scene version=\"3.0.0\"></scene>        ").contains("it is no guide"));
        assert!(!SavedGuide::is_in(&path).unwrap());
        // The magic number of a checkpoint.
        let mut checkpoint = whole;
        checkpoint[4] = b'R';
        assert!(refused(&path, &checkpoint).contains("it is no guide"));
    }

    #[test]
    fn guides_are_merged_or_the_fault_is_named() {
        let paths = ["a.guide", "b.guide"];
        let mut other = example();
        other.tables.samples = "8:0..64".parse().unwrap();
        let both = merge(vec![example(), other.clone()], &paths).unwrap();
        assert_eq!(both.tables.samples.to_string(), "7:0..64, 8:0..64");
        assert_eq!(both.tables.learned[0], LearnedRadiance { mean: 0.1, weight: 6.0 });
        let fault = |other: SavedGuide| merge(vec![example(), other], &paths).unwrap_err().to_string();
        let text = fault(example());
        assert!(text.contains("b.guide: ") && text.contains("7:0..64"), "{text}");
        let mut changed = other.clone();
        changed.scene.hash = "00aa".into();
        assert!(fault(changed).contains("other scenes (00ff and 00aa)"));
        let mut changed = other;
        changed.tables.cells = Cells::of_occupancy(changed.tables.cells.grid, &[0xff, 0xff]);
        assert!(fault(changed).contains("b.guide: it cannot be merged with a.guide: they have other cells"));
    }
}
