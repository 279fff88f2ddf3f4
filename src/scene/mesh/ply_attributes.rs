//! Attributes of PLY files, as Mitsuba finds them: properties whose names share a beginning and end in the letters of a vector or a color.

use glam::Vec3;

use super::triangles::{MeshAttribute, set_attribute};
use crate::scene::deformation::MOST_INTERVALS;

/// Last letters of the names of an attribute's properties, in their order, for each way to call them.
const ENDINGS: [[char; 4]; 4] =
    [['x', 'y', 'z', 'w'], ['r', 'g', 'b', 'a'], ['0', '1', '2', '3'], ['1', '2', '3', '4']];
/// Place of the color's letters in [`ENDINGS`].
const OF_COLOR: usize = 1;

/// Attributes of an element that are kept, and the properties that make them.
#[derive(Default)]
pub(super) struct Kept {
    attributes: Vec<MeshAttribute>,
    /// Properties of each attribute: one or three.
    places: Vec<Vec<usize>>,
    /// Values of the current item.
    current: Vec<Vec3>,
}

impl Kept {
    /// Attributes of an element whose properties have these names; `None` stands for a list. `kind` is `vertex_` or `face_`. Those that are
    /// not `wanted` are left out.
    pub fn of(kind: &str, names: &[Option<&str>], wanted: &[&str]) -> Self {
        let mut kept = Self::default();
        let mut add = |name: String, places: Vec<usize>| {
            let is_new = kept.attributes.iter().all(|attribute| attribute.name != name);
            if is_new && wanted.contains(&&*name) && matches!(places.len(), 1 | 3) {
                kept.attributes.push(MeshAttribute { name, values: Vec::new() });
                kept.places.push(places);
            }
        };
        if kind == "face_" {
            let place =
                |one: &str, other: &str| names.iter().position(|name| *name == Some(one) || *name == Some(other));
            if let (Some(r), Some(g), Some(b)) = (place("r", "red"), place("g", "green"), place("b", "blue")) {
                add("face_color".to_owned(), vec![r, g, b]);
            }
        }
        let mut at = 0;
        while at < names.len() {
            let (ending, count) = run(&names[at..]);
            if let Some((prefix, _)) = names[at].and_then(|name| name.rsplit_once('_')).filter(|_| count > 0) {
                let color = if ending == OF_COLOR { "_color" } else { "" };
                add(format!("{kind}{prefix}{color}"), (at..at + count).collect());
            }
            at += count.max(1);
        }
        kept.current = vec![Vec3::ZERO; kept.attributes.len()];
        kept
    }

    /// Checks that properties which look like sets of vertices are whole sets: x, y and z of `position1`, `position2` and so on, and of
    /// their normals.
    pub fn check_sets(&self, names: &[Option<&str>]) -> Result<(), String> {
        let set = |name: &&str| {
            let (base, _) = name.split_once('_')?;
            let number = base.strip_prefix("position").or_else(|| base.strip_prefix("normal"))?;
            let is_number = number.bytes().all(|digit| digit.is_ascii_digit());
            is_number.then(|| number.parse().ok()).flatten().filter(|&number: &usize| number > 0)
        };
        let is_whole = |attribute: &str| {
            let at = self.attributes.iter().position(|own| own.name == attribute);
            at.is_some_and(|at| self.places[at].len() == 3)
        };
        for name in names.iter().flatten().filter(|name| set(name).is_some()) {
            let number = set(name).unwrap_or_default();
            if number > MOST_INTERVALS {
                let most = MOST_INTERVALS + 1;
                return Err(format!("`{name}` is one of more than {most} sets of vertices; leave some out"));
            }
            let (base, _) = name.split_once('_').unwrap_or((name, ""));
            let mut needed = (1..=number).map(|at| set_attribute("position", at)).chain([format!("vertex_{base}")]);
            if !needed.all(|attribute| is_whole(&attribute)) {
                return Err(format!(
                    "the sets of vertices are not whole: `{name}` needs x, y and z of `position1` to `position{number}`, each after the \
                     other, and of `{base}`"
                ));
            }
        }
        Ok(())
    }

    /// Notes the number of a property of the current item.
    pub fn note(&mut self, place: usize, number: f64) {
        for (value, places) in self.current.iter_mut().zip(&self.places) {
            let Some(component) = places.iter().position(|&own| own == place) else { continue };
            match places.len() {
                1 => *value = Vec3::splat(number as f32),
                _ => value[component] = number as f32,
            }
        }
    }

    /// Gives the current item's values to the next `count` vertices or triangles.
    pub fn push(&mut self, count: usize) {
        for (attribute, &value) in self.attributes.iter_mut().zip(&self.current) {
            attribute.values.extend(std::iter::repeat_n(value, count));
        }
    }

    /// The attributes with all values.
    pub fn finish(self) -> Vec<MeshAttribute> {
        self.attributes
    }
}

/// The way of calling, and the number, of the properties at the beginning of a list that make one attribute; 0 where the first makes none.
fn run(names: &[Option<&str>]) -> (usize, usize) {
    let parted =
        |name: &Option<&str>| name.and_then(|name| name.rsplit_once('_')).map(|(a, b)| (a.to_owned(), b.to_owned()));
    let Some((prefix, first)) = names.first().and_then(parted) else { return (0, 0) };
    let is = |ending: &str, letter: char| ending.len() == 1 && ending.starts_with(letter);
    let Some(way) = ENDINGS.iter().position(|letters| is(&first, letters[0])) else { return (0, 0) };
    let goes_on = |(name, letter): &(&Option<&str>, char)| {
        parted(name).is_some_and(|(own, ending)| own == prefix && is(&ending, *letter))
    };
    (way, names.iter().zip(ENDINGS[way]).take_while(goes_on).count())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(kind: &str, properties: &str, wanted: &[&str]) -> Vec<(String, usize)> {
        let names: Vec<_> = properties.split(' ').map(|name| (name != "list").then_some(name)).collect();
        let kept = Kept::of(kind, &names, wanted);
        kept.attributes.iter().map(|attribute| attribute.name.clone()).zip(kept.places.iter().map(Vec::len)).collect()
    }

    #[test]
    fn names_are_those_of_mitsuba() {
        let all =
            ["vertex_heat", "vertex_tint_color", "vertex_flow", "vertex_two", "face_color", "face_age", "vertex_f_dc"];
        let properties =
            "x y z heat_0 tint_r tint_g tint_b flow_x flow_y flow_z two_x two_y quality f_dc_1 f_dc_2 f_dc_3";
        let found = [("vertex_heat", 1), ("vertex_tint_color", 3), ("vertex_flow", 3), ("vertex_f_dc", 3)];
        assert_eq!(names("vertex_", properties, &all), found.map(|(name, count)| (name.to_owned(), count)));
        let found = [("face_color", 3), ("face_age", 1)];
        assert_eq!(
            names("face_", "list red green blue age_0", &all),
            found.map(|(name, count)| (name.to_owned(), count))
        );
        assert!(names("vertex_", properties, &[]).is_empty());
    }

    #[test]
    fn items_have_their_values() {
        let mut kept = Kept::of(
            "face_",
            &[None, Some("age_0"), Some("tint_x"), Some("tint_y"), Some("tint_z")],
            &["face_age", "face_tint"],
        );
        for (place, number) in [(0, 9.0), (1, 0.5), (2, 1.0), (3, 2.0), (4, 3.0)] {
            kept.note(place, number);
        }
        kept.push(2);
        kept.note(1, 0.25);
        kept.push(1);
        let found = kept.finish();
        assert_eq!(found[0].values, [0.5, 0.5, 0.25].map(Vec3::splat));
        assert_eq!(found[1].values, [Vec3::new(1.0, 2.0, 3.0); 3]);
    }
}
