//! Files of pbrt-v3: names and defaults that v4 has changed, as `pbrt --upgrade` changes them, or nearer to v3 where a texture or a
//! factor would be lost.

use super::parameters::{Parameter, Parameters, Values};
use crate::Result;

/// Warning about a file of pbrt-v3, once for a scene.
pub(super) const WARNING: &str = "the scene is one of pbrt-v3; it is read as `pbrt --upgrade` would make it: its \
     plastics look a little different, its `disney` materials are diffuse, and the `sigma` of `matte` and the `Kr` and \
     `Kt` of `glass` and `uber` are left out";

/// Factor of the colors of v3's plastics where the file gives none.
const PLASTIC: f64 = 0.25;

/// A directive as v4 knows it: changes its type and its parameters. Returns whether it was one of v3. `is_known` says that the scene is
/// one of v3 by an earlier directive.
pub(super) fn upgrade(directive: &str, kind: &mut String, parameters: &mut Parameters, is_known: bool) -> Result<bool> {
    let (old_kind, count) = (kind.clone(), parameters.count());
    let is_old = match directive {
        "Material" => material(kind, parameters)?,
        "MakeNamedMaterial" => match parameters.text("type")?.map(str::to_owned) {
            Some(mut of) => {
                let is_old = material(&mut of, parameters)?;
                if is_old {
                    parameters.set("string", "type", Values::Texts(vec![of]));
                }
                is_old
            }
            None => false,
        },
        "Texture" => texture(kind, parameters)?,
        "LightSource" | "AreaLightSource" => light(kind, parameters)? | (is_known && warm_light(parameters)?),
        "Shape" => shape(kind, parameters),
        "Film" => film(kind, parameters)?,
        "PixelFilter" => filter(parameters)?,
        "Integrator" => integrator(kind, parameters),
        "Camera" => match parameters.remove("halffov") {
            Some(half) => {
                parameters.set("float", "fov", Values::Numbers(vec![2.0 * half.number()?]));
                true
            }
            None => false,
        },
        "MakeNamedMedium" if parameters.text("type")? == Some("heterogeneous") => {
            parameters.set("string", "type", Values::Texts(vec!["uniformgrid".to_owned()]));
            true
        }
        _ => false,
    };
    Ok(is_old || *kind != old_kind || parameters.count() != count)
}

/// Changes a material. Returns whether it was one of v3.
fn material(kind: &mut String, parameters: &mut Parameters) -> Result<bool> {
    const SILVER: [(&str, &str); 2] = [("eta", "metal-Ag-eta"), ("k", "metal-Ag-k")];
    let old = kind.clone();
    let mut is_old = parameters.rename("bumpmap", "displacement");
    let upgraded = match &*old {
        "matte" => {
            parameters.rename("Kd", "reflectance");
            parameters.remove("sigma");
            "diffuse"
        }
        "plastic" | "uber" | "substrate" => {
            parameters.rename("index", "eta");
            parameters.rename("Kd", "reflectance");
            if old != "substrate" {
                parameters.default("rgb", "reflectance", Values::Numbers(vec![PLASTIC; 3]));
            }
            let shines = parameters.remove("Ks").is_none_or(|specular| !is_gray(&specular, 0.0));
            ["Kr", "Kt"].iter().for_each(|name| _ = parameters.remove(name));
            if shines {
                roughness(parameters, 0.1)?;
                "coateddiffuse"
            } else {
                ["eta", "roughness", "uroughness", "vroughness", "remaproughness"]
                    .iter()
                    .for_each(|name| _ = parameters.remove(name));
                "diffuse"
            }
        }
        "glass" => {
            parameters.rename("index", "eta");
            ["Kr", "Kt"].iter().for_each(|name| _ = parameters.remove(name));
            roughness(parameters, 0.0)?;
            "dielectric"
        }
        "metal" => {
            roughness(parameters, 0.01)?;
            "conductor"
        }
        "mirror" => {
            match parameters.rename("Kr", "reflectance") {
                true => {}
                false => SILVER.iter().for_each(|(name, metal)| {
                    parameters.set("spectrum", name, Values::Texts(vec![(*metal).to_owned()]));
                }),
            }
            "conductor"
        }
        "translucent" => {
            translucent(parameters)?;
            "diffusetransmission"
        }
        "disney" => {
            parameters.rename("color", "reflectance");
            let others = [
                "anisotropic",
                "clearcoat",
                "clearcoatgloss",
                "eta",
                "metallic",
                "roughness",
                "scatterdistance",
                "sheen",
                "sheentint",
                "spectrans",
                "speculartint",
                "thin",
                "difftrans",
                "flatness",
            ];
            others.iter().for_each(|name| _ = parameters.remove(name));
            "diffuse"
        }
        "kdsubsurface" => {
            parameters.rename("Kd", "reflectance");
            parameters.default("rgb", "reflectance", Values::Numbers(vec![0.5; 3]));
            ["Kr", "Kt"].iter().for_each(|name| _ = parameters.remove(name));
            roughness(parameters, 0.0)?;
            "subsurface"
        }
        "hair" => {
            is_old |= parameters.rename("color", "reflectance");
            "hair"
        }
        "mix" => {
            is_old |= mixture(parameters)?;
            "mix"
        }
        _ => return Ok(is_old),
    };
    upgraded.clone_into(kind);
    Ok(is_old || old != upgraded)
}

/// The roughness of v3, where it is a number: its remapping is another. A texture is remapped as in v4.
fn roughness(parameters: &mut Parameters, default: f64) -> Result<()> {
    let names = ["roughness", "uroughness", "vroughness"];
    if !names.iter().any(|name| parameters.has(name)) {
        parameters.set("float", "roughness", Values::Numbers(vec![default]));
    }
    if !parameters.boolean("remaproughness", true)? || names.iter().any(|name| parameters.is_texture(name)) {
        return Ok(());
    }
    for name in names {
        let Some(given) = parameters.remove(name) else { continue };
        // Light would pass straight through what is not rough at all.
        let given = given.number()?;
        let x = given.max(1.0e-3).ln();
        let alpha = 1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)));
        parameters.set("float", name, Values::Numbers(vec![if given > 0.0 { alpha } else { 0.0 }]));
    }
    parameters.set("bool", "remaproughness", Values::Booleans(vec![false]));
    Ok(())
}

/// v3's `translucent` reflects and transmits shares of one color.
fn translucent(parameters: &mut Parameters) -> Result<()> {
    ["Ks", "roughness", "remaproughness"].iter().for_each(|name| _ = parameters.remove(name));
    let mut share = |name: &str| match parameters.remove(name) {
        None => Ok(0.5),
        Some(given) => given.numbers().map(|numbers| numbers.iter().sum::<f64>() / numbers.len().max(1) as f64),
    };
    let shares = [("reflectance", share("reflect")?), ("transmittance", share("transmit")?)];
    let color = parameters.remove("Kd");
    let most = shares[0].1.max(shares[1].1);
    let is_texture = color.as_ref().is_some_and(|color| color.kind == "texture");
    for (name, share) in shares {
        match &color {
            // The shares of a texture are both or none of it.
            Some(color) if is_texture && share > 0.0 => parameters.set("texture", name, color.values.clone()),
            Some(color) if !is_texture && color.kind != "spectrum" => {
                let values = color.numbers()?.iter().map(|value| value * share).collect();
                parameters.set("rgb", name, Values::Numbers(values));
            }
            Some(color) if !is_texture => parameters.set("spectrum", name, color.values.clone()),
            _ => {
                let value = if color.is_none() { PLASTIC * share } else { 0.0 };
                parameters.set("rgb", name, Values::Numbers(vec![value; 3]));
            }
        }
    }
    if color.is_some_and(|color| matches!(&*color.kind, "texture" | "spectrum")) {
        parameters.set("float", "scale", Values::Numbers(vec![most]));
    }
    Ok(())
}

/// v3's `mix` names its materials one by one, and its amount is that of the first.
fn mixture(parameters: &mut Parameters) -> Result<bool> {
    let (Some(first), Some(second)) = (parameters.remove("namedmaterial1"), parameters.remove("namedmaterial2")) else {
        return Ok(false);
    };
    let names = vec![second.text()?.to_owned(), first.text()?.to_owned()];
    parameters.set("string", "materials", Values::Texts(names));
    if let Some(amount) = parameters.get("amount").filter(|amount| matches!(&*amount.kind, "rgb" | "color")) {
        let mean = amount.three()?.iter().sum::<f64>() / 3.0;
        parameters.set("float", "amount", Values::Numbers(vec![mean]));
    }
    Ok(true)
}

fn texture(kind: &str, parameters: &mut Parameters) -> Result<bool> {
    let mut is_old = false;
    match kind {
        "scale" => {
            let [first, second] = ["tex1", "tex2"].map(|name| parameters.remove(name));
            is_old = first.is_some() || second.is_some();
            // The factor is a number in v4.
            let is_number = |part: &Option<Parameter>| part.as_ref().is_some_and(|part| gray_of(part).is_some());
            let (inner, factor) =
                if is_number(&first) && !is_number(&second) { (second, first) } else { (first, second) };
            if let Some(inner) = inner {
                parameters.set(&inner.kind, "tex", inner.values);
            }
            match factor {
                Some(factor) if factor.kind == "texture" => parameters.set("texture", "scale", factor.values),
                Some(factor) => match gray_of(&factor) {
                    Some(gray) => parameters.set("float", "scale", Values::Numbers(vec![gray])),
                    None => {
                        return Err(
                            factor.error("of a `scale` in pbrt-v3 must be gray beside a texture; use one `rgb`")
                        );
                    }
                },
                None => {}
            }
        }
        "imagemap" => {
            if let Some(trilinear) = parameters.remove("trilinear") {
                let is_trilinear = matches!(&trilinear.values, Values::Booleans(values) if values == &[true]);
                let filter = if is_trilinear { "trilinear" } else { "bilinear" };
                parameters.set("string", "filter", Values::Texts(vec![filter.to_owned()]));
                is_old = true;
            }
            if let Some(gamma) = parameters.remove("gamma") {
                let encoding = match &gamma.values {
                    Values::Numbers(numbers) => format!("gamma {}", numbers.first().copied().unwrap_or(1.0)),
                    Values::Booleans(values) if values == &[false] => "linear".to_owned(),
                    Values::Texts(texts) if texts == &["false"] => "linear".to_owned(),
                    _ => "sRGB".to_owned(),
                };
                parameters.set("string", "encoding", Values::Texts(vec![encoding]));
                is_old = true;
            }
        }
        _ => {}
    }
    Ok(is_old)
}

fn light(kind: &mut String, parameters: &mut Parameters) -> Result<bool> {
    let mut is_old = false;
    if kind == "area" {
        "diffuse".clone_into(kind);
        is_old = true;
    }
    ["samples", "nsamples"].iter().for_each(|name| is_old |= parameters.remove(name).is_some());
    if let Some(scale) = parameters.get("scale").filter(|scale| scale.numbers().is_ok_and(|numbers| numbers.len() == 3))
    {
        let scale = scale.clone();
        match gray_of(&scale) {
            Some(gray) => parameters.set("float", "scale", Values::Numbers(vec![gray])),
            None => {
                let factor = scale.three()?;
                let name = if matches!(&**kind, "point" | "spot" | "goniometric" | "projection") { "I" } else { "L" };
                let own = match parameters.get(name) {
                    None => [1.0; 3],
                    Some(own) if matches!(&*own.kind, "rgb" | "color") => own.three()?,
                    Some(_) => return Err(scale.error("of pbrt-v3 may be a color only beside an `rgb`; make it gray")),
                };
                let product = (0..3).map(|channel| own[channel] * factor[channel]).collect();
                parameters.set("rgb", name, Values::Numbers(product));
                parameters.remove("scale");
            }
        }
        is_old = true;
    }
    if parameters.has("mapname") {
        // v3's maps are those of longitude and latitude, which the reader of infinite lights knows by this name.
        is_old = true;
    }
    Ok(is_old)
}

/// A temperature of v3 has a factor beside it, which v4 refuses.
fn warm_light(parameters: &mut Parameters) -> Result<bool> {
    let mut is_old = false;
    for name in ["I", "L"] {
        let Some(color) = parameters.get(name).filter(|color| color.kind == "blackbody") else { continue };
        if let &[temperature, factor] = color.numbers()? {
            let scale = factor * parameters.number("scale", 1.0)?;
            parameters.set("blackbody", name, Values::Numbers(vec![temperature]));
            parameters.set("float", "scale", Values::Numbers(vec![scale]));
            is_old = true;
        }
    }
    Ok(is_old)
}

fn shape(kind: &str, parameters: &mut Parameters) -> bool {
    let mut is_old = false;
    match kind {
        "loopsubdiv" => is_old |= parameters.rename("nlevels", "levels"),
        "trianglemesh" | "plymesh" => {
            ["discarddegenerateUVs", "shadowalpha"].iter().for_each(|name| is_old |= parameters.remove(name).is_some());
            if !parameters.has("uv") {
                is_old |= parameters.rename("st", "uv");
            }
        }
        _ => {}
    }
    is_old
}

fn film(kind: &mut String, parameters: &mut Parameters) -> Result<bool> {
    if kind != "image" {
        return Ok(false);
    }
    "rgb".clone_into(kind);
    parameters.remove("maxsampleluminance");
    if let Some(scale) = parameters.remove("scale") {
        parameters.set("float", "iso", Values::Numbers(vec![100.0 * scale.number()?]));
    }
    Ok(true)
}

fn filter(parameters: &mut Parameters) -> Result<bool> {
    let mut is_old = parameters.rename("xwidth", "xradius");
    is_old |= parameters.rename("ywidth", "yradius");
    if let Some(alpha) = parameters.remove("alpha") {
        let alpha = alpha.number()?;
        if alpha > 0.0 {
            parameters.set("float", "sigma", Values::Numbers(vec![(2.0 * alpha).sqrt().recip()]));
        }
        is_old = true;
    }
    Ok(is_old)
}

fn integrator(kind: &mut String, parameters: &mut Parameters) -> bool {
    let mut is_old = false;
    if kind == "directlighting" || kind == "whitted" {
        if kind == "directlighting" {
            parameters.set("integer", "maxdepth", Values::Numbers(vec![1.0]));
        }
        "path".clone_into(kind);
        is_old = true;
    }
    for name in ["imagewritefrequency", "numiterations", "lightsamplestrategy", "strategy", "pixelbounds"] {
        is_old |= parameters.remove(name).is_some();
    }
    is_old
}

/// The number that all channels of a color have.
fn gray_of(parameter: &Parameter) -> Option<f64> {
    match (&*parameter.kind, parameter.numbers()) {
        ("float", Ok(&[number])) => Some(number),
        ("rgb" | "color", Ok(&[red, green, blue])) if red == green && red == blue => Some(red),
        _ => None,
    }
}

fn is_gray(parameter: &Parameter, value: f64) -> bool {
    gray_of(parameter) == Some(value)
}
