//! Directives of a `.pbrt` file and of the files that it includes.

use std::path::Path;
use std::sync::Arc;

use super::builder::Builder;
use super::parameters::Parameters;
use super::tokens::{Place, Token, Tokens, brief};
use super::transforms::Current;
use crate::{Result, quoted};

/// Deepest nesting of included files.
const MAX_DEPTH: usize = 64;
/// Most files that a scene includes, counted as often as it includes them.
const MAX_INCLUDES: usize = 1 << 16;

/// Reads the directives of the file at `path` and of those that it includes.
pub(super) fn read_file(builder: &mut Builder, path: &Path) -> Result<()> {
    let text = builder.files.text(path)?;
    let file: Arc<Path> = Arc::from(path);
    builder.open_files.push(Arc::clone(&file));
    let mut tokens = Tokens::new(&text, file);
    while let Some(token) = tokens.take()? {
        match token {
            Token::Word(word) => directive(builder, word, &mut tokens)?,
            other => {
                return Err(tokens
                    .place()
                    .error(format!("a directive such as `Shape` should stand here, not {other}")));
            }
        }
    }
    builder.open_files.pop();
    Ok(())
}

fn directive(builder: &mut Builder, word: &str, tokens: &mut Tokens) -> Result<()> {
    let place = tokens.place();
    match word {
        "Include" | "Import" => return include(builder, word, tokens, &place),
        "WorldBegin" => builder.begin_world(&place)?,
        "WorldEnd" => builder.warn_once(&place, "WorldEnd belongs to pbrt-v3; ignored"),
        "AttributeBegin" => builder.push(&place)?,
        "AttributeEnd" => builder.pop(&place)?,
        "TransformBegin" | "TransformEnd" => {
            let message =
                "TransformBegin and TransformEnd are deprecated; they are read as AttributeBegin and AttributeEnd";
            builder.warn_once(&place, message);
            if word == "TransformBegin" { builder.push(&place)? } else { builder.pop(&place)? }
        }
        "ObjectBegin" => {
            let name = tokens.quoted("the name of an object")?;
            builder.begin_object(&name, &place)?;
        }
        "ObjectEnd" => builder.end_object(&place)?,
        "ObjectInstance" => {
            let name = tokens.quoted("the name of an object")?;
            builder.add_instance(&name, &place)?;
        }
        "ReverseOrientation" => builder.state.is_reversed = !builder.state.is_reversed,
        "MediumInterface" => medium_interface(builder, tokens)?,
        "MakeNamedMedium" => {
            let name = tokens.quoted("the name of a medium")?.into_owned();
            let parameters = Parameters::read(tokens, place, format!("medium `{}`", brief(&name)))?;
            builder.add_medium(name, parameters)?;
        }
        "NamedMaterial" => {
            let name = tokens.quoted("the name of a material")?;
            builder.use_named_material(&name, &place);
        }
        "ColorSpace" => {
            let name = tokens.quoted("the name of a color space")?;
            builder.set_color_space(&name, &place)?;
        }
        "Option" => option(builder, tokens, &place)?,
        "Texture" => {
            let name = tokens.quoted("the name of a texture")?.into_owned();
            let value = tokens.quoted("`float` or `spectrum`")?.into_owned();
            let kind = tokens.quoted("the class of a texture")?.into_owned();
            let parameters = Parameters::read(tokens, place, format!("texture `{}`", brief(&name)))?;
            builder.add_texture(name, &value, kind, parameters)?;
        }
        "Attribute" => {
            let target = tokens.quoted("`shape`, `light`, `material`, `medium` or `texture`")?.into_owned();
            let parameters = Parameters::read(tokens, place, word.to_owned())?;
            builder.set_attributes(&target, parameters)?;
        }
        "Camera" | "Film" | "PixelFilter" | "Sampler" | "Integrator" | "Accelerator" | "Shape" | "LightSource"
        | "AreaLightSource" | "Material" | "MakeNamedMaterial" => {
            let kind = tokens.quoted("the type of a directive")?.into_owned();
            let owner = format!("{word} `{}`", brief(&kind));
            let parameters = Parameters::read(tokens, place, owner)?;
            builder.add(word, kind, parameters)?;
        }
        _ => transform(builder, word, tokens, &place)?,
    }
    Ok(())
}

fn transform(builder: &mut Builder, word: &str, tokens: &mut Tokens, place: &Place) -> Result<()> {
    let by = match word {
        "Identity" => return builder.set_transform(Current::IDENTITY, place),
        "Transform" => {
            let matrix = Current::of_columns(tokens.numbers(word)?, place)?;
            return builder.set_transform(matrix, place);
        }
        "ConcatTransform" => Current::of_columns(tokens.numbers(word)?, place)?,
        "Translate" => Current::translation(tokens.numbers(word)?),
        "Scale" => Current::scale(tokens.numbers(word)?, place)?,
        "Rotate" => Current::rotation(tokens.numbers(word)?, place)?,
        "LookAt" => Current::look_at(tokens.numbers(word)?, place)?,
        "CoordinateSystem" => {
            let name = tokens.quoted("the name of a coordinate system")?;
            builder.keep_coordinate_system(&name);
            return Ok(());
        }
        "CoordSysTransform" => {
            let name = tokens.quoted("the name of a coordinate system")?;
            return builder.use_coordinate_system(&name, place);
        }
        "TransformTimes" => {
            return builder.set_times(tokens.numbers::<2>(word)?, place);
        }
        "ActiveTransform" => {
            builder.state.is_active = match tokens.require("`All`, `StartTime` or `EndTime`")? {
                Token::Word("All") => [true, true],
                Token::Word("StartTime") => [true, false],
                Token::Word("EndTime") => [false, true],
                other => {
                    return Err(tokens
                        .place()
                        .error(format!("`All`, `StartTime` or `EndTime` should stand here, not {other}")));
                }
            };
            return Ok(());
        }
        _ => {
            return Err(
                place.error(format!("{} is not a directive of pbrt-v4; check its spelling", quoted::word(word)))
            );
        }
    };
    builder.transform_by(&by, place)
}

fn include(builder: &mut Builder, word: &str, tokens: &mut Tokens, place: &Place) -> Result<()> {
    let name = tokens.quoted("the name of a file")?;
    let path = builder.files.existing(&name, "included file", place)?;
    if builder.open_files.len() >= MAX_DEPTH {
        return Err(place
            .error(format!("files are included more than {MAX_DEPTH} deep: does `{}` include itself?", brief(&name))));
    }
    builder.include_count += 1;
    if builder.include_count > MAX_INCLUDES {
        return Err(place.error(format!("the scene includes more than {MAX_INCLUDES} files")));
    }
    match word {
        "Import" => {
            let state = builder.begin_import(place)?;
            read_file(builder, &path)?;
            builder.end_import(state, place)
        }
        _ => read_file(builder, &path),
    }
}

/// Reads the names of the media on both sides of surfaces. One name stands for both.
fn medium_interface(builder: &mut Builder, tokens: &mut Tokens) -> Result<()> {
    let place = tokens.place();
    let inside = tokens.quoted("the name of a medium")?.into_owned();
    let outside = match tokens.peek()? {
        Some(Token::Quoted(_)) => tokens.quoted("the name of a medium")?.into_owned(),
        _ => inside.clone(),
    };
    builder.set_media([inside, outside], &place);
    Ok(())
}

/// Reads an option. Options say how pbrt renders, not what.
fn option(builder: &mut Builder, tokens: &mut Tokens, place: &Place) -> Result<()> {
    let name = tokens.quoted("the name of an option")?.into_owned();
    if tokens.require("the value of an option")? == Token::Open {
        while tokens.require("`]`")? != Token::Close {}
    }
    let name = name.split_ascii_whitespace().next_back().unwrap_or_default();
    if name == "displacementedgescale" {
        builder.warn_once(place, "the option `displacementedgescale` is ignored");
    }
    Ok(())
}
