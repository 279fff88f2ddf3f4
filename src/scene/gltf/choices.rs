//! Choices of a user about a model: the moment of its animation, and the variant of its materials.

use serde_json::{Value as Json, json};

use super::usual::list;
use crate::quoted;

/// Choices of a user about a model.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Choices {
    /// Moment of the first animation in seconds.
    pub time: Option<f64>,
    /// Name of a variant of the materials.
    pub variant: Option<String>,
}

impl Choices {
    /// Reads the choices from definitions of names. The error says which one is wrong.
    pub fn of(defines: &[(String, String)]) -> Result<Self, String> {
        let mut choices = Self::default();
        for (name, value) in defines {
            match name.as_str() {
                "time" => {
                    let time = value.trim().parse().ok().filter(|time: &f64| time.is_finite());
                    let word = quoted::word(value);
                    choices.time = Some(time.ok_or_else(|| format!("the time {word} should be a number of seconds"))?);
                }
                "variant" => choices.variant = Some(value.clone()),
                _ => {
                    return Err(format!(
                        "-D {name}: a glTF model has only the values `time` and `variant`; leave it out"
                    ));
                }
            }
        }
        Ok(choices)
    }
}

/// Gives each primitive the material of a variant (`KHR_materials_variants`). Returns the names of all variants. The error says that the
/// variant is not there.
pub(super) fn choose_variant(raw: &mut Json, variant: Option<&str>) -> Result<Vec<String>, String> {
    const EXTENSION: &str = "KHR_materials_variants";
    let variants = raw.get("extensions").and_then(|all| all.get(EXTENSION)?.get("variants")?.as_array());
    let name = |variant: &Json| variant.get("name").and_then(Json::as_str).unwrap_or_default().to_owned();
    let names: Vec<String> = variants.into_iter().flatten().map(name).collect();
    let Some(variant) = variant else { return Ok(names) };
    let Some(chosen) = names.iter().position(|name| name == variant) else {
        let word = quoted::word(variant);
        return Err(match names.is_empty() {
            true => format!("there is no variant {word}: the model has no variants"),
            false => format!("there is no variant {word}; choose one of {}", told(&names)),
        });
    };
    for primitive in list(raw.get_mut("meshes")).iter_mut().flat_map(|mesh| list(mesh.get_mut("primitives"))) {
        let mappings = primitive.get("extensions").and_then(|all| all.get(EXTENSION)?.get("mappings")?.as_array());
        let has_variant = |mapping: &&Json| {
            let variants = mapping.get("variants").and_then(Json::as_array);
            variants.into_iter().flatten().any(|variant| variant.as_u64() == Some(chosen as u64))
        };
        let material =
            mappings.into_iter().flatten().find(has_variant).and_then(|mapping| mapping.get("material")?.as_u64());
        if let (Some(material), Some(primitive)) = (material, primitive.as_object_mut()) {
            primitive.insert("material".to_owned(), json!(material));
        }
    }
    Ok(names)
}

/// Names of variants for a sentence.
pub(super) fn told(names: &[String]) -> String {
    const MOST: usize = 12;
    let told: Vec<_> = names.iter().take(MOST).map(|name| quoted::word(name)).collect();
    let more = if names.len() > MOST { format!(" and {} more", names.len() - MOST) } else { String::new() };
    told.join(", ") + &more
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shoe() -> Json {
        json!({
            "extensions": {"KHR_materials_variants": {"variants": [{"name": "beach"}, {"name": "street"}]}},
            "meshes": [{"primitives": [
                {"material": 0, "extensions": {"KHR_materials_variants": {"mappings": [
                    {"material": 1, "variants": [0]}, {"material": 2, "variants": [1, 7]}]}}},
                {"material": 5}]}]
        })
    }

    #[test]
    fn primitives_get_the_material_of_the_variant() {
        for (variant, right) in [(None, 0), (Some("beach"), 1), (Some("street"), 2)] {
            let mut model = shoe();
            assert_eq!(choose_variant(&mut model, variant), Ok(vec!["beach".to_owned(), "street".to_owned()]));
            let material = |at: usize| model["meshes"][0]["primitives"][at]["material"].clone();
            assert_eq!((material(0), material(1)), (json!(right), json!(5)));
        }
        let error = choose_variant(&mut shoe(), Some("desert")).unwrap_err();
        assert_eq!(error, "there is no variant `desert`; choose one of `beach`, `street`");
        assert!(choose_variant(&mut json!({}), Some("a")).unwrap_err().contains("the model has no variants"));
        assert!(choose_variant(&mut json!({"extensions": 5, "meshes": [3]}), None).unwrap().is_empty());
    }

    #[test]
    fn choices_are_named() {
        let of = |name: &str, value: &str| Choices::of(&[(name.to_owned(), value.to_owned())]);
        assert_eq!(of("time", "1.5").unwrap().time, Some(1.5));
        assert_eq!(of("variant", "beach").unwrap().variant.as_deref(), Some("beach"));
        assert!(of("time", "soon").unwrap_err().contains("a number of seconds"));
        assert!(of("spp", "4").unwrap_err().contains("only the values `time` and `variant`"));
    }
}
