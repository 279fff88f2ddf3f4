//! What must agree for a render to go on from where another was, or for two pictures to be averaged.

use std::collections::{BTreeMap, BTreeSet};

use crate::film::denoised;
use crate::film::picture_file::PRECISION;
use crate::film::ranges::SampleRanges;
use crate::settings::Settings;

/// Settings that change how fast a render is, and not what it estimates. The traversal may change last bits, as the device may.
const FREE_SETTINGS: [&str; 3] = ["slice_milliseconds", "execution", "traversal"];
/// Attributes of a picture that say which samples it holds and how they came about, not what they estimate.
const FREE_ATTRIBUTES: [&str; 14] = [
    FREE_SETTINGS[0],
    FREE_SETTINGS[1],
    FREE_SETTINGS[2],
    "seed",
    "sample_offset",
    "sample_ranges",
    "spp",
    "seconds",
    "device",
    "scene",
    PRECISION,
    denoised::ATTRIBUTES[0],
    denoised::ATTRIBUTES[1],
    denoised::ATTRIBUTES[2],
];

/// Version, scene and settings of a render: name to value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity(BTreeMap<String, String>);

impl Identity {
    /// Identity of a render: a scene by its fingerprint, the settings, and this version.
    pub fn of_render(scene_hash: &str, settings: &Settings) -> Self {
        Self(
            attributes(scene_hash, settings)
                .into_iter()
                .filter(|(name, _)| !FREE_SETTINGS.contains(&&name[..]))
                .collect(),
        )
    }

    /// Identity of a picture with these attributes: what its samples estimate, whichever they are. An attribute of an
    /// unknown name is part of it.
    pub fn of_picture(attributes: &[(String, String)]) -> Self {
        let binding = attributes.iter().filter(|(name, _)| !FREE_ATTRIBUTES.contains(&&name[..]));
        Self(binding.cloned().collect())
    }

    /// Every name whose value is not the same in `other`, as `seed (3 there, 4 here)`, where `other` is here; `None` where
    /// all are.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let Self(theirs) = self;
        let Self(ours) = other;
        let names: BTreeSet<_> = theirs.keys().chain(ours.keys()).collect();
        let value = |values: &BTreeMap<String, String>, name: &String| {
            values.get(name).cloned().unwrap_or_else(|| "nothing".into())
        };
        let differing = names.into_iter().filter(|&name| theirs.get(name) != ours.get(name));
        let phrases: Vec<_> = differing
            .map(|name| format!("{name} ({} there, {} here)", value(theirs, name), value(ours, name)))
            .collect();
        (!phrases.is_empty()).then(|| phrases.join(", "))
    }
}

/// Version, scene and every setting by name, as a picture's attributes have them.
pub fn attributes(scene_hash: &str, settings: &Settings) -> Vec<(String, String)> {
    let mut attributes = settings.named();
    attributes.extend([("version".into(), env!("CARGO_PKG_VERSION").into()), ("scene_hash".into(), scene_hash.into())]);
    attributes
}

/// The attributes of a picture that was merged from pictures with these: what is the same stays, what differs is listed, and
/// samples and seconds add up. The precision of the parts' colors and
/// their denoised layers are left out.
pub fn merged_attributes(pictures: &[&[(String, String)]], ranges: &SampleRanges) -> Vec<(String, String)> {
    let names: BTreeSet<_> = pictures.iter().flat_map(|attributes| attributes.iter().map(|(name, _)| name)).collect();
    let merged = |name: &String| {
        let values = pictures.iter().flat_map(|attributes| attributes.iter()).filter(|(found, _)| found == name);
        let values: Vec<_> = values.map(|(_, value)| value.as_str()).collect();
        let value = match name.as_str() {
            "sample_ranges" => ranges.to_string(),
            "spp" => values.iter().filter_map(|value| value.parse::<u64>().ok()).sum::<u64>().to_string(),
            "seconds" => format!("{:.3}", values.iter().filter_map(|value| value.parse::<f64>().ok()).sum::<f64>()),
            _ => distinct(&values).join(", "),
        };
        (name.clone(), value)
    };
    let is_kept = |name: &&String| *name != PRECISION && !denoised::ATTRIBUTES.contains(&&name[..]);
    names.into_iter().filter(is_kept).map(merged).collect()
}

/// Every value once, in order.
fn distinct<'a>(values: &[&'a str]) -> Vec<&'a str> {
    let mut seen = BTreeSet::new();
    values.iter().copied().filter(|&value| seen.insert(value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{LoadOptions, load};
    use crate::settings::{AUTO_GRID, Execution, Traversal, Value, options};

    fn settings() -> Settings {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/furnace/scene.xml");
        Settings::for_scene(&load(&path, &LoadOptions::default()).expect("a scene"))
    }

    /// Settings without an option of their own, or with one of another name.
    const OTHERWISE: [(&str, Option<&str>); 4] =
        [("crop", None), ("filter", None), ("hide_emitters", None), ("slice_milliseconds", Some("slice-ms"))];

    /// A setting that is added needs an entry in the table of options, with the name and the value that pictures have.
    #[test]
    fn every_setting_is_an_option() {
        for (name, text) in settings().named() {
            let option = match OTHERWISE.iter().find(|(other, _)| *other == name) {
                Some((_, None)) => continue,
                Some((_, Some(option))) => (*option).to_owned(),
                None => name.replace('_', "-"),
            };
            let entry = options::find(&option).unwrap_or_else(|| panic!("{name} has no entry"));
            let value = (entry.setting.expect("a setting").get)(&settings());
            let value = if value == Value::Nothing { "null".to_owned() } else { value.to_string() };
            assert_eq!(value, text.strip_suffix(".0").unwrap_or(&text), "{name}");
        }
    }

    #[test]
    fn every_setting_is_written_down_and_comes_back() {
        let text = serde_json::to_string(&settings()).expect("JSON");
        assert_eq!(serde_json::from_str::<Settings>(&text).expect("settings"), settings());
        let auto = Settings { grid: Some(AUTO_GRID), ..settings() };
        let text_of_auto = serde_json::to_string(&auto).expect("JSON");
        assert!(text_of_auto.contains("\"grid\":\"auto\""), "{text_of_auto}");
        assert_eq!(serde_json::from_str::<Settings>(&text_of_auto).expect("settings"), auto);
        assert!(serde_json::from_str::<Settings>(&text.replacen('{', "{\"new\":1,", 1)).is_err());
    }

    #[test]
    fn numbers_come_back_to_the_last_bit() {
        for bits in (0x3880_0000..0x3f80_0000u32).step_by(104_729) {
            let (decay, min_uniform) = (f32::from_bits(bits), f32::from_bits(bits ^ 0x55));
            let some = Settings { decay, min_uniform, slice_milliseconds: Some(f64::from(bits) / 3.0), ..settings() };
            let text = serde_json::to_string(&some).expect("JSON");
            assert_eq!(serde_json::from_str::<Settings>(&text).expect("settings"), some);
        }
    }

    #[test]
    fn every_setting_but_the_free_ones_is_compared() {
        let ours = attributes("abc", &settings());
        for (at, (name, _)) in ours.iter().enumerate() {
            let mut theirs = ours.clone();
            theirs[at].1 = "another".into();
            let pictures = Identity::of_picture(&theirs).difference(&Identity::of_picture(&ours));
            assert_eq!(pictures.is_none(), FREE_ATTRIBUTES.contains(&&name[..]), "{name}");
            assert!(pictures.is_none_or(|text| text.starts_with(&format!("{name} (another there, "))), "{name}");
        }
    }

    #[test]
    fn a_render_is_told_from_another() {
        let ours = Identity::of_render("abc", &settings());
        let with = |change: &dyn Fn(&mut Settings)| {
            let mut settings = settings();
            change(&mut settings);
            Identity::of_render("abc", &settings).difference(&ours)
        };
        assert_eq!(with(&|_| {}), None);
        assert_eq!(with(&|s| s.slice_milliseconds = Some(3.0)), None);
        assert_eq!(with(&|s| s.execution = Execution::Wavefront), None);
        assert_eq!(with(&|s| s.traversal = Traversal::Query), None);
        assert_eq!(with(&|s| s.seed = 5).as_deref(), Some("seed (5 there, 0 here)"));
        let two = with(&|s| (s.sample_offset, s.decay) = (Some(8), 0.5));
        assert_eq!(two.as_deref(), Some("decay (0.5 there, 0.95 here), sample_offset (8 there, null here)"));
        let scene = Identity::of_render("def", &settings()).difference(&ours);
        assert_eq!(scene.as_deref(), Some("scene_hash (def there, abc here)"));
    }
}
