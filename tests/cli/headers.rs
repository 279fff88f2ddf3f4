//! Channels and attributes of EXR files that viewers use: alpha, half floats, the camera, the date.

use lodestar::film::{Picture, read_picture};
use lodestar::image::exr::read_layers;

use crate::support::{Folder, SCENE, assert_sentence, assert_written, attribute};

/// Center of the only shape of [`with_a_lamp`].
const CENTER: [f32; 3] = [0.9, 0.6, 5.0];

/// Scene with a small shining sphere in front of nothing, seen by `sensor`.
fn with_a_lamp(sensor: &str) -> String {
    let [x, y, z] = CENTER;
    let sphere = format!(
        r#"<shape type="sphere"><point name="center" x="{x}" y="{y}" z="{z}"/><float name="radius" value="0.3"/>
        <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape></scene>"#
    );
    let (head, _) = SCENE.split_once("<emitter").unwrap();
    head.replace(r#"type="perspective">"#, sensor) + &sphere
}

fn read(folder: &Folder, name: &str) -> (Picture, Vec<f32>) {
    let path = folder.path(name);
    let alpha = read_layers(&path).unwrap().0.floats("A").unwrap().to_vec();
    (read_picture(&path).unwrap().0, alpha)
}

/// Centroid, in pixels from the top left of the film, of all samples that hit something.
fn centroid(picture: &Picture) -> [f32; 2] {
    let mut sums = [0.0; 3];
    for (at, &hits) in picture.hit_count.iter().enumerate() {
        let (x, y) = (at as u32 % picture.width + picture.offset[0], at as u32 / picture.width + picture.offset[1]);
        for (sum, value) in sums.iter_mut().zip([x as f32 + 0.5, y as f32 + 0.5, 1.0]) {
            *sum += value * hits as f32;
        }
    }
    [sums[0] / sums[2], sums[1] / sums[2]]
}

/// The matrices take the center of a sphere to the middle of the pixels that show it, on the whole film and in a crop.
#[test]
fn a_point_is_projected_to_its_pixel() {
    let folder = Folder::new();
    let size = ["--width", "96", "--height", "72", "--spp", "16", "--sampler", "bsdf", "-o", "a.exr"];
    let to_world = r#"<transform name="to_world"><rotate y="1" angle="4"/><translate x="0.1" z="-1"/></transform>"#;
    let wide = r#"<float name="fov" value="60"/><float name="principal_point_offset_x" value="0.1"/>"#;
    let scaled = r#"<transform name="to_world"><scale x="2" y="2"/></transform>"#;
    for (kind, more, crop) in [
        ("perspective", "", None),
        ("perspective", to_world, Some("10,0,60,60")),
        ("perspective", wide, None),
        ("orthographic", scaled, None),
    ] {
        folder.write("scene.xml", &with_a_lamp(&format!(r#"type="{kind}">{more}"#)));
        let crop: Vec<_> = crop.iter().flat_map(|crop| ["--crop", crop]).collect();
        folder.render(&[&size[..], &crop].concat());
        let (picture, _) = read(&folder, "a.exr");
        let view = picture.view.unwrap();
        let film = view.film_from_world.project_point3(CENTER.into());
        let (pixel, seen) = ([film.x * 96.0, film.y * 72.0], centroid(&picture));
        // A sphere off the axis is seen as an ellipse whose center lies a little further out.
        let distance = (pixel[0] - seen[0]).hypot(pixel[1] - seen[1]);
        assert!(distance < 0.7, "{kind} {more}: {pixel:?} is seen at {seen:?}");
        let depth = view.camera_from_world.transform_point3(CENTER.into());
        assert!(depth.z > 4.0 && (more == wide || (depth.x < 0.0) == (pixel[0] < 48.0)), "{kind} {more}: {depth}");
    }
}

#[test]
fn alpha_is_the_covered_share_and_one_where_an_environment_is_seen() {
    let folder = Folder::new();
    let render = |scene: &str| {
        folder.write("scene.xml", scene);
        folder.render(&["--spp", "16", "--sampler", "bsdf", "--width", "64", "-o", "a.exr"]);
        read(&folder, "a.exr")
    };
    let (lamp, alpha) = render(&with_a_lamp(r#"type="perspective">"#));
    let share = |at: usize| lamp.hit_count[at] as f32 / lamp.sample_count[at] as f32;
    assert!((0..alpha.len()).all(|at| alpha[at] == share(at)));
    assert!(alpha.contains(&0.0) && alpha.contains(&1.0) && alpha.iter().any(|&alpha| alpha > 0.0 && alpha < 1.0));
    // The lamp shines with radiance 1 before black, so each color is multiplied by alpha.
    assert!(lamp.radiance.iter().zip(&alpha).all(|(color, alpha)| (color[0] - alpha).abs() < 1e-5));
    assert!(lamp.depth().iter().zip(&alpha).all(|(depth, &alpha)| depth.is_finite() == (alpha > 0.0)));
    let small = SCENE.replace("z=\"5\"", "z=\"9\"");
    let (sky, alpha) = render(&small);
    assert!(alpha.iter().all(|&alpha| alpha == 1.0) && sky.hit_count.contains(&0) && sky.has_background);
    let hidden =
        small.replace(r#"type="path"/>"#, r#"type="path"><boolean name="hide_emitters" value="true"/></integrator>"#);
    let (hidden, alpha) = render(&hidden);
    assert!(alpha.contains(&0.0) && alpha.contains(&1.0) && hidden.hit_count == sky.hit_count);
}

#[test]
fn half_floats_are_for_colors_and_merge_only_with_sums() {
    let folder = Folder::new();
    let render = |more: &[&str]| {
        folder.render(&[&["--spp", "8", "--sampler", "bsdf", "--pattern", "independent"], more].concat());
    };
    render(&["-o", "float.exr"]);
    render(&["-o", "half.exr", "--half"]);
    let ((float, _), (half, _)) = (read(&folder, "float.exr"), read(&folder, "half.exr"));
    assert_eq!((half.depth(), &half.variance), (float.depth(), &float.variance));
    let pairs = half.radiance.iter().flatten().zip(float.radiance.iter().flatten());
    assert!(
        pairs.clone().all(|(half, float)| (half - float).abs() <= float / 2048.0) && half.radiance != float.radiance
    );
    let sizes = ["half.exr", "float.exr"].map(|name| folder.path(name).metadata().unwrap().len());
    assert!(sizes[0] < sizes[1], "{sizes:?}");
    assert!(folder.run(&["compare", "half.exr", "float.exr"]).status.success());

    render(&["-o", "next.exr", "--half", "--sample-offset", "8"]);
    let output = folder.run(&["merge", "half.exr", "next.exr", "-o", "c.exr"]);
    assert_sentence(&output, 1, &["half.exr: its colors were rounded to half floats", "without --half"]);
    for (first, second, merged, more) in
        [("a.exr", "b.exr", "ab.exr", None), ("c.exr", "d.exr", "cd.exr", Some("--half"))]
    {
        for (name, offset) in [(first, "0"), (second, "8")] {
            let more: Vec<_> = more.into_iter().collect();
            render(&[&["-o", name, "--sample-offset", offset], &more[..]].concat());
        }
        assert_written(&folder.run(&["merge", first, second, "-o", merged]), merged);
    }
    // Sums are not rounded.
    assert_eq!(read(&folder, "cd.exr").0, read(&folder, "ab.exr").0);
    let attributes = lodestar::image::exr::read_attributes(&folder.path("cd.exr")).unwrap();
    assert!(attributes.iter().all(|(name, _)| name != "precision"));
}

/// A checkpoint remembers that colors are half floats, and colors that are too bright for them are said.
#[test]
fn half_floats_are_resumed_and_their_limit_is_said() {
    let folder = Folder::new();
    folder.write(
        "scene.xml",
        &with_a_lamp(r#"type="perspective">"#).replace(r#"value="1"/></emitter>"#, r#"value="1e6"/></emitter>"#),
    );
    let arguments = ["render", "scene.xml", "--quiet", "--spp", "8", "--half", "--checkpoint", "a.ckpt", "-o", "a.exr"];
    for arguments in [&arguments[..], &["resume", "a.ckpt", "--quiet", "--spp", "16"]] {
        let said = String::from_utf8(folder.run(arguments).stderr).unwrap();
        assert!(said.lines().count() == 1 && said.contains("brighter than 65504") && said.contains("--half"), "{said}");
        assert_eq!(attribute(&folder.path("a.exr"), "precision"), "half");
        let (picture, _) = read(&folder, "a.exr");
        assert_eq!(picture.radiance.iter().flatten().copied().fold(0.0, f32::max), 65504.0);
    }
}

/// SOURCE_DATE_EPOCH fixes the date, and the pixels stay as they are. Without it, the date is that of the writing.
#[test]
fn the_date_can_be_fixed() {
    let folder = Folder::new();
    for (name, offset) in [("a.exr", "0"), ("b.exr", "8")] {
        folder.render(&["--spp", "8", "--sampler", "bsdf", "--sample-offset", offset, "-o", name]);
    }
    let merge = |name: &str, date: Option<&str>| {
        let mut command = folder.command(&["merge", "a.exr", "b.exr", "-o", name]);
        command.env_remove("SOURCE_DATE_EPOCH").envs(date.map(|date| ("SOURCE_DATE_EPOCH", date)));
        assert_written(&command.output().unwrap(), name);
        std::fs::read(folder.path(name)).unwrap()
    };
    let has = |bytes: &[u8], text: &[u8]| bytes.windows(text.len()).any(|found| found == text);
    let fixed = merge("c.exr", Some("1709210096"));
    assert!(has(&fixed, b"2024:02:29 12:34:56"));
    assert!(has(&merge("d.exr", Some("-1")), b"1969:12:31 23:59:59"));
    let now = merge("e.exr", None);
    assert!(has(&now, b"capDate") && !has(&now, b"2024:02:29 12:34:56"));
    assert_eq!(read(&folder, "c.exr").0, read(&folder, "e.exr").0);
}

/// A date that no header can hold is refused before the render.
#[test]
fn what_is_no_date_is_refused() {
    let folder = Folder::new();
    for date in ["tomorrow", "253402300800"] {
        let output = folder.command(&["render", "scene.xml"]).env("SOURCE_DATE_EPOCH", date).output().unwrap();
        assert_sentence(&output, 1, &["SOURCE_DATE_EPOCH", date, "years 0 to 9999"]);
        assert_eq!(folder.names(), ["scene.xml"]);
    }
}

/// The number of samples in the header is that of the pixels, also where a step was cut short.
#[test]
fn the_number_of_samples_is_that_of_the_pixels() {
    let folder = Folder::new();
    let arguments =
        ["render", "scene.xml", "--spp", "1000000", "--width", "160", "--spp-per-step", "64", "--steps", "even"];
    let mut running = folder.start(&[&arguments[..], &["--sampler", "bsdf", "-o", "a.exr"]].concat());
    running.wait_for_line("/1000000 spp");
    std::thread::sleep(std::time::Duration::from_millis(100));
    running.signal("INT");
    assert_eq!(running.wait().0, Some(130));
    let most = read(&folder, "a.exr").0.sample_count.into_iter().max().unwrap();
    assert_eq!(attribute(&folder.path("a.exr"), "spp"), most.to_string());
    assert_eq!(attribute(&folder.path("a.exr"), "sample_ranges"), format!("0:0..{most}"));
}
