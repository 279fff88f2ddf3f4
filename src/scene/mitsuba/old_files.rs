//! Differences between Mitsuba 0.6 and 3 that change the picture of an old file.

use super::element::Element;

/// Nested elements of a `<bsdf>` or parameters that choose a conductor's metal.
const METAL: [&str; 3] = ["material", "eta", "k"];

/// Warning that names the first element of an old file that Mitsuba 0.6 renders in another way. The picture is that of
/// Mitsuba 3.
pub(super) fn warning(elements: &[Element]) -> Option<String> {
    let mut found = Vec::new();
    collect(elements, &mut found);
    let (first, _) = found.first()?;
    let mut differences: Vec<&str> = found.iter().map(|&(_, difference)| difference).collect();
    differences.sort_unstable();
    differences.dedup();
    Some(format!(
        "{}: a file of Mitsuba 0.6 is rendered as Mitsuba 3 renders it; {}",
        first.location,
        differences.join("; ")
    ))
}

fn collect<'a>(elements: &'a [Element], found: &mut Vec<(&'a Element, &'static str)>) {
    for element in elements.iter().filter(|element| element.is_old) {
        let children = &element.children;
        if element.tag == "emitter" {
            found.extend(children.iter().find(|child| is_uniform_spectrum(child)).map(|child| {
                (child, "the light of a <spectrum> with one value is tinted, where 0.6 made it white: give an <rgb>")
            }));
        }
        let names_metal = children.iter().filter_map(Element::key).any(|key| METAL.contains(&&key[..]));
        let is_conductor = matches!(element.attribute("type"), Some("conductor" | "roughconductor"));
        if element.tag == "bsdf" && is_conductor && !names_metal {
            found.push((element, "a conductor without a `material` is a perfect mirror, where 0.6 took copper"));
        }
        let hides = |child: &&Element| child.key().as_deref() == Some("hide_emitters") && is_true(child);
        if element.tag == "integrator" {
            found.extend(children.iter().find(hides).map(|child| {
                (child, "hidden emitters let the camera see what is behind them, where 0.6 made them black")
            }));
        }
        collect(children, found);
    }
}

/// Whether an element is a `<spectrum>` with one value, which is not 0.
fn is_uniform_spectrum(element: &Element) -> bool {
    let value = element.attribute("value").and_then(|value| value.trim().parse::<f32>().ok());
    element.tag == "spectrum" && value.is_some_and(|value| value != 0.0)
}

fn is_true(element: &Element) -> bool {
    element.attribute("value").is_some_and(|value| value.trim().eq_ignore_ascii_case("true"))
}
