//! `lodestar render --frames`: a picture for each frame, whose guide goes from frame to frame.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lodestar::scene::{LoadOptions, scene_file, scene_name};
use lodestar::session::saved_guide::SavedGuide;
use lodestar::session::{Event, OutputFiles, SceneInput, Start};
use lodestar::settings::options::form::frames;
use lodestar::{Error, Result};

use super::cameras::ALL;
use super::console::Console;
use super::given::{Given, OfRender};
use super::interrupt::Interrupt;
use super::print::report;
use super::render::{Kept, RenderArgs, check_several, options, render_one};

/// Options that belong to one picture.
const OF_ONE_PICTURE: [&str; 6] = ["checkpoint", "stats", "profile", "reference", "view", "display-server"];
/// Sign in the value of a definition that stands for the frame's number.
const FRAME: &str = "$frame";

/// Renders a scene at each frame, in turn. A frame that fails or is stopped ends all; the frames before it are written.
pub fn render_all(args: RenderArgs) -> Result<ExitCode> {
    let RenderArgs { scene, given } = args;
    check_several(&given, "--frames", &OF_ONE_PICTURE, "render each frame by a command of its own")?;
    if given.text("camera") == Some(ALL) {
        return Err(Error::Settings("--frames and --camera all together are not supported; name a camera".into()));
    }
    let frames = given.text("frames").map_or(Ok(Vec::new()), frames).map_err(Error::Settings)?;
    let (choices, files) = (given.load(), given.files());
    let keeps_guide = !given.has("fresh-guide");
    let seeds = seeds(&given, &frames)?;
    let pictures = pictures(&scene, &files)?;
    if !has_number(&scene) && !choices.defines.iter().any(|(_, value)| value.contains(FRAME)) {
        return Err(Error::Settings(format!(
            "{}: each frame would be the same picture; write #### in the scene's name, or {FRAME} in the value of a -D, in single \
             quotes: -D turn='{FRAME}*2'",
            scene.display()
        )));
    }
    let interrupt = Interrupt::catch(!given.has("quiet") && given.text("log") != Some("json"))?;
    let consoles: Vec<_> = frames.iter().map(|_| Console::new(&given, given.has("output"))).collect();
    // Indices and names of several devices have commas between them.
    let has_one_device = given.device().is_none_or(|device| device != "all" && !device.contains(','));
    let mut options = options(given);
    let mut kept = Kept::default();
    for (index, ((&frame, seed), console)) in frames.iter().zip(seeds).zip(consoles).enumerate() {
        if interrupt.is_raised() {
            break;
        }
        console.show(Event::Note(&format!("frame {frame}, {} of {}", index + 1, frames.len())));
        let defines = choices.defines.iter().map(|(name, value)| Ok((name.clone(), defined(value, frame)?)));
        let defines = defines.collect::<Result<_>>()?;
        let input =
            SceneInput::File { path: numbered(&scene, frame), options: LoadOptions { defines, ..choices.clone() } };
        let files = OutputFiles {
            pictures: pictures.iter().map(|picture| numbered(picture, frame)).collect(),
            guide: files.guide.as_ref().map(|guide| numbered(guide, frame)),
            ..files.clone()
        };
        let of_frame = options.clone().files(files).seed(seed);
        let rendered = render_one(Start::Anew(input), &of_frame, &console, &interrupt, Some(&mut kept));
        match (keeps_guide, &kept.guide) {
            // The guide of the frame before has all that the file knows.
            (true, Some(_)) => options = options.without_guide(),
            _ => kept.guide = None,
        }
        if let Some(context) = kept.context.as_ref().filter(|_| has_one_device) {
            options = options.context(context);
        }
        match rendered {
            Ok(code) if code == ExitCode::SUCCESS => {}
            Ok(code) => return Ok(code),
            Err(error) => {
                report("error", &format!("frame {frame}: {error}"));
                return Ok(ExitCode::FAILURE);
            }
        }
    }
    Ok(interrupt.exit_code())
}

/// Seeds of the frames: the given one plus the frame's number. Refuses those that there are not, and those whose samples the guide of
/// `--guide` has learned from, before anything is rendered.
fn seeds(given: &Given<OfRender>, frames: &[u32]) -> Result<Vec<u32>> {
    let seed = given.value("seed", str::parse::<u32>).unwrap_or(0);
    let offset = given.value("sample-offset", str::parse::<u32>).unwrap_or(0);
    let file = given.path("guide").filter(|file| SavedGuide::is_in(file).unwrap_or(false));
    let learned = file.map(|file| Ok::<_, Error>((SavedGuide::read(&file)?.tables.samples, file))).transpose()?;
    let of_frame = |&frame: &u32| {
        let sum = seed.checked_add(frame).ok_or_else(|| {
            Error::Settings(format!(
                "frame {frame} has the seed {seed} + {frame}, which is above {}; choose a smaller --seed",
                u32::MAX
            ))
        })?;
        match &learned {
            Some((samples, file)) if samples.end(sum).is_some_and(|end| end > u64::from(offset)) => {
                Err(Error::Settings(format!(
                    "{}: the guide has learned from the seed {sum}, which frame {frame} would have; give another --seed",
                    file.display()
                )))
            }
            _ => Ok(sum),
        }
    };
    frames.iter().map(of_frame).collect()
}

/// Picture files whose names have a place for the frame's number. An empty list means the name of a numbered scene.
fn pictures(scene: &Path, files: &OutputFiles) -> Result<Vec<PathBuf>> {
    if let Some(picture) = files.pictures.iter().find(|picture| !has_number(picture)) {
        return Err(Error::Settings(format!(
            "{}: all frames would be written into it; write #### in its name for the frame's number",
            picture.display()
        )));
    }
    if !files.pictures.is_empty() || has_number(scene) {
        return Ok(files.pictures.clone());
    }
    Ok(vec![PathBuf::from(format!("{}.####.exr", scene_name(&scene_file(scene)?)))])
}

/// Whether the name of a file has a place for a number.
fn has_number(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().contains('#'))
}

/// `out.####.exr` of frame 7 is `out.0007.exr`.
fn numbered(path: &Path, frame: u32) -> PathBuf {
    if !has_number(path) {
        return path.to_path_buf();
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut numbered = String::new();
    let mut rest = &name[..];
    while let Some(at) = rest.find('#') {
        let width = rest[at..].chars().take_while(|&sign| sign == '#').count();
        numbered += &format!("{}{frame:0width$}", &rest[..at]);
        rest = &rest[at + width..];
    }
    path.with_file_name(numbered + rest)
}

/// Value of a definition at a frame: `$frame` is the frame's number, and `$frame*N` and `$frame/N` are its product and quotient with a
/// number. Nothing that would make another word or number of it may follow.
fn defined(value: &str, frame: u32) -> Result<String> {
    let Some((before, after)) = value.split_once(FRAME) else { return Ok(value.to_owned()) };
    let is_of_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e' | 'E');
    let (number, rest) = match after.strip_prefix(['*', '/']) {
        None => (frame.to_string(), after),
        Some(factor) => {
            let end = factor.find(|c| !is_of_number(c)).unwrap_or(factor.len());
            let number = factor[..end]
                .parse()
                .ok()
                .filter(|&number: &f64| number.is_finite() && (number != 0.0 || after.starts_with('*')));
            let number = number.ok_or_else(|| {
                Error::Settings(format!(
                    "-D with {value}: a number follows {FRAME}* and {FRAME}/, which is not 0 after the second; write it as {FRAME}*0.5 or {FRAME}/24"
                ))
            })?;
            let frame = f64::from(frame);
            let number = if after.starts_with('*') { frame * number } else { frame / number };
            (number.to_string(), &factor[end..])
        }
    };
    if rest.starts_with(|c: char| c.is_alphanumeric() || c == '_') {
        return Err(Error::Settings(format!(
            "-D with {value}: a letter, a digit or _ follows {FRAME} or its number; write something else between them"
        )));
    }
    Ok(format!("{before}{number}{}", defined(rest, frame)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_a_place_for_the_number() {
        let name = |name: &str, frame| numbered(Path::new(name), frame).display().to_string();
        assert_eq!(name("a#/out.####.exr", 7), "a#/out.0007.exr");
        assert_eq!(name("out.##.exr", 12345), "out.12345.exr");
        assert_eq!(name("#-##.exr", 3), "3-03.exr");
        assert_eq!(name("küche.xml", 3), "küche.xml");
        assert!(has_number(Path::new("a.#.exr")) && !has_number(Path::new("#/a.exr")));
    }

    #[test]
    fn definitions_have_the_number_of_the_frame() {
        for (value, at_7) in [
            ("plain", "plain"),
            ("$frame", "7"),
            ("$frame/2", "3.5"),
            ("0, $frame*1.5, 0", "0, 10.5, 0"),
            ("$frame $frame", "7 7"),
            ("$frame*-2", "-14"),
            ("$frame*0", "0"),
            ("$frame/1e3", "0.007"),
            ("$frame*2.5E+1,1", "175,1"),
            ("tree-$frame.ply", "tree-7.ply"),
        ] {
            assert_eq!(defined(value, 7).unwrap(), at_7);
        }
        for value in ["$frame/0", "$frame*", "$frame/1.2.3", "$frame*1-2", "$frame*1e", "$frame*2+1"] {
            assert!(defined(value, 7).unwrap_err().to_string().contains("a number follows"), "{value}");
        }
        for value in ["$frame_rate", "$frames", "0 $frame1", "$frame*2px"] {
            assert!(defined(value, 7).unwrap_err().to_string().contains("a letter, a digit or _ follows"), "{value}");
        }
    }
}
