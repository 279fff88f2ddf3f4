//! `lodestar compare`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lodestar::image::comparison::Comparison;
use lodestar::image::report::{Report, ReportPicture};
use lodestar::image::{Image, ToneCurve, color, exr};
use lodestar::settings::options::form::finite;
use lodestar::{Error, Result, files};
use serde::Serialize;

use super::print::{print_json, print_line, report};

/// Layer that the report shows beside the radiance.
const DENOISED: &str = "denoised";

/// Measures the errors of pictures against a reference.
///
/// Pictures are EXR files. A .png or .jpg file has 8 bits per channel, which are made linear, and is told.
///
/// --html writes one page that needs no other file: it flips between the pictures, splits them, and shows their error maps. A
/// picture with a layer denoised stands there twice, with and without.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct CompareArgs {
    /// The pictures, and last the reference. All have one size.
    #[arg(value_names = ["A.exr", "REF.exr"], required = true, num_args = 2..)]
    pictures: Vec<PathBuf>,
    /// Layer of the pictures that is measured, such as denoised. The reference has none.
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Print JSON: one object, or a list of objects for several pictures.
    #[arg(long)]
    json: bool,
    /// Page to write.
    #[arg(long, value_name = "REPORT.html")]
    html: Option<PathBuf>,
    /// Tone curve with which the page opens.
    #[arg(long, value_enum, requires = "html", default_value_t = ToneCurve::Srgb)]
    tone: ToneCurve,
    /// Exposure with which the page opens: brighter by 2^STOPS.
    #[arg(long, value_name = "STOPS", requires = "html", default_value_t = 0.0, value_parser = finite)]
    exposure: f32,
}

/// Errors of one of several pictures.
#[derive(Serialize)]
struct Named<'a> {
    picture: &'a str,
    #[serde(flatten)]
    errors: Comparison,
}

/// Prints the errors of the pictures, and writes the report.
pub fn run(args: &CompareArgs) -> Result<ExitCode> {
    args.html.as_deref().map_or(Ok(()), files::check_writable)?;
    let Some((reference_path, paths)) = args.pictures.split_last() else { return Ok(ExitCode::SUCCESS) };
    let read = |path: &PathBuf| match &args.layer {
        Some(layer) => exr::read_layer(path, layer),
        None => color(path),
    };
    let images = paths.iter().map(read).collect::<Result<Vec<_>>>()?;
    let reference = color(reference_path)?;
    let layer = args.layer.as_ref().map_or_else(String::new, |layer| format!(", {layer}"));
    let mut pictures = Vec::new();
    for (path, image) in paths.iter().zip(images) {
        pictures.push(compare(path, &layer, image, &reference, reference_path)?);
        if args.html.is_some()
            && args.layer.is_none()
            && files::has_extension(path, "exr")
            && has_layer(path, DENOISED)?
        {
            let image = exr::read_layer(path, DENOISED)?;
            pictures.push(compare(path, &format!(", {DENOISED}"), image, &reference, reference_path)?);
        }
    }
    print(&pictures, args.json)?;
    if let Some(html) = &args.html {
        let (reference_name, tone, exposure) = (reference_path.display().to_string(), args.tone, args.exposure);
        Report { pictures, reference_name, reference, tone, exposure }.write(html)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn compare(path: &Path, layer: &str, image: Image, reference: &Image, reference_path: &Path) -> Result<ReportPicture> {
    let (errors, flip) = Comparison::new(&image, reference).map_err(|error| {
        Error::Settings(format!("{}{layer} against {}: {error}", path.display(), reference_path.display()))
    })?;
    Ok(ReportPicture { name: format!("{}{layer}", path.display()), image, errors, flip })
}

/// Color of a picture. What its format lacks is told.
fn color(path: &Path) -> Result<Image> {
    let (image, note) = color::read(path)?;
    note.iter().for_each(|note| report("note", note));
    Ok(image)
}

fn has_layer(path: &Path, layer: &str) -> Result<bool> {
    let prefix = format!("{layer}.");
    Ok(exr::channel_names(path)?.iter().any(|name| name.starts_with(&prefix)))
}

/// Prints one picture's errors alone, and the errors of several below the pictures' names.
fn print(pictures: &[ReportPicture], is_json: bool) -> Result<()> {
    let named = pictures.iter().map(|picture| Named { picture: &picture.name, errors: picture.errors });
    match (pictures, is_json) {
        ([only], true) => print_json(&only.errors),
        ([only], false) => print_line(&table(&only.errors)),
        (_, true) => print_json(&named.collect::<Vec<_>>()),
        (_, false) => {
            let blocks: Vec<_> = named.map(|named| format!("{}\n{}", named.picture, table(&named.errors))).collect();
            print_line(&blocks.join("\n\n"))
        }
    }
}

fn table(errors: &Comparison) -> String {
    let Comparison { metrics, smape, flip } = *errors;
    let rows = [
        ("mae_ldr", metrics.mae_ldr, "mean absolute difference under the paper's tone curve"),
        ("mae", metrics.mae, "mean absolute difference"),
        ("mse", metrics.mse, "mean squared difference"),
        ("relmse", metrics.relmse, "relative mean squared difference"),
        ("relmse_trim", metrics.relmse_trim, "relative mean squared difference without the worst 0.1 % of the pixels"),
        ("smape", smape, "symmetric mean absolute difference: over the sum of both"),
        ("flip", flip, "difference that a viewer sees, from 0 to 1 (FLIP)"),
        ("mean_ratio", metrics.mean_ratio, "mean of the picture over mean of the reference"),
    ];
    rows.map(|(name, value, what)| format!("{name:<12} {value:>12.6e}  {what}")).join("\n")
}
