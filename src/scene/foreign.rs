//! Files that are no scenes, by their extensions: what each is, and what to do with it.

use super::formats;

const EXPORT: &str = "open it in a program such as Blender, and export it as glTF 2.0";

/// Extensions, with what their files are and what to do with one.
const KINDS: [(&[&str], &str, &str); 6] = [
    (&["blend"], "a file of Blender", "render it in Blender with Lodestar's add-on, or export it there as glTF 2.0"),
    (
        &["obj", "ply", "serialized"],
        "a mesh without camera and lights",
        "name it in a <shape> of a scene in Mitsuba's XML",
    ),
    (
        &["3ds", "abc", "c4d", "dae", "fbx", "lwo", "ma", "max", "mb", "stl", "wrl", "x3d"],
        "of a format that is not read",
        EXPORT,
    ),
    (&["7z", "bz2", "gz", "rar", "tar", "tgz", "xz", "zip"], "an archive", "unpack it, and name the scene in it"),
    (&["exr", "hdr", "jpeg", "jpg", "png", "tga", "tif", "tiff"], "a picture", "name the scene that shows it"),
    (&["ckpt"], "a checkpoint", "go on from it with `lodestar resume`"),
];

/// Sentence about a file with this extension in lower case; `None` where it may be a scene.
pub(super) fn refusal(extension: &str) -> Option<String> {
    let (_, what, advice) = KINDS.iter().find(|(extensions, ..)| extensions.contains(&extension))?;
    Some(format!("it is {what}, not a scene in {}; {advice}", formats::with_extensions()))
}
