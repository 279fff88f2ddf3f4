//! Texture plugins and image files.

use glam::{DVec2, DVec3, Mat3, Vec3};
use image::{DynamicImage, GrayAlphaImage, GrayImage, ImageBuffer, Luma, Rgb, RgbImage, Rgba, RgbaImage};
use lodestar::film::Picture;
use lodestar::math::srgb::{linear_from_srgb, luminance};
use lodestar::scene::bsdf::Relief;
use lodestar::scene::texture::{Pattern, TexelFilter, Texels, WrapMode};
use lodestar::scene::texture_lookup::sample;
use lodestar::scene::{Bsdf, MaterialKind, Scene, Textured};
use support::twins::texture::gradient;

use super::{Folder, with_sensor};

const WIDTH: u32 = 4;
const HEIGHT: u32 = 3;

/// Color of a texel. All texels differ.
fn pixel(x: u32, y: u32) -> [u8; 3] {
    [x * 61 + y * 97 + 5, x * 17 + y * 151 + 90, x * 131 + y * 29 + 200].map(|value| (value % 256) as u8)
}

fn rgb() -> RgbImage {
    RgbImage::from_fn(WIDTH, HEIGHT, |x, y| Rgb(pixel(x, y)))
}

/// Folder with `a.png` and a scene of a disk whose reflectance is the texture.
fn folder(texture: &str) -> Folder {
    let body = format!(r#"<shape type="disk"><bsdf type="diffuse">{texture}</bsdf></shape>"#);
    let folder = Folder::new(&[("scene.xml", &with_sensor(&body))]);
    rgb().save(folder.path("a.png")).unwrap();
    folder
}

fn bitmap(file: &str, parameters: &str) -> String {
    format!(
        r#"<texture name="reflectance" type="bitmap"><string name="filename" value="{file}"/>{parameters}</texture>"#
    )
}

fn load(texture: &str) -> Scene {
    folder(texture).load(&[]).unwrap()
}

fn error(folder: &Folder) -> String {
    let message = folder.load(&[]).map(drop).expect_err("this should be refused").to_string();
    assert!(message.contains("scene.xml:2: ") && !message.contains('\n'), "{message}");
    message
}

fn reflectance(scene: &Scene) -> Textured<Vec3> {
    let MaterialKind::Surface(surface) = &scene.materials[0].kind else { panic!() };
    let Bsdf::Diffuse { reflectance } = surface.bsdf else { panic!() };
    reflectance
}

/// Small image files, one of every format that the content identifies.
pub fn image_files() -> Vec<Vec<u8>> {
    let folder = Folder::new(&[]);
    let mut names = vec!["a.png", "a.jpg", "a.bmp", "a.webp", "a.tif"];
    names.iter().for_each(|name| rgb().save(folder.path(name)).unwrap());
    save_exr(&folder.path("a.exr"), 0.75);
    save_hdr(&folder.path("a.hdr"));
    names.extend(["a.exr", "a.hdr"]);
    let files = names.into_iter().map(|name| std::fs::read(folder.path(name)).unwrap());
    files.chain([ktx2([200, 100, 50, 255])]).collect()
}

/// KTX2 image of 4 x 4 equal texels in UASTC: one block of the mode 8, which has one color.
pub fn ktx2([red, green, blue, alpha]: [u8; 4]) -> Vec<u8> {
    let mode = 23_u128;
    let color = u32::from_le_bytes([red, green, blue, alpha]);
    let block = (mode | u128::from(color) << 5).to_le_bytes();
    // Format, size of a type, sides, depth, layers, faces, levels and packing; place of the description; no keys.
    let header = [0_u32, 1, 4, 4, 0, 0, 1, 1, 0, 104, 44, 0, 0];
    // No common data. The level's place, its length, and its length when unpacked.
    let long = [0_u64, 0, 148, 16, 16];
    // A description of UASTC with red, green, blue and alpha, in sRGB.
    let description =
        [44_u32, 0, 2 | 40 << 16, 166 | 1 << 8 | 2 << 16, 3 | 3 << 8, 16, 0, 127 << 16 | 3 << 24, 0, 0, u32::MAX];
    let words = |list: &[u32]| list.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>();
    let long = long.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>();
    [&b"\xabKTX 20\xbb\r\n\x1a\n"[..], &words(&header), &long, &words(&description), &block].concat()
}

fn save_hdr(path: &std::path::Path) {
    let pixels = vec![Rgb([0.5f32, 0.25, 0.125]); (WIDTH * HEIGHT) as usize];
    let file = std::fs::File::create(path).unwrap();
    image::codecs::hdr::HdrEncoder::new(file).encode(&pixels, WIDTH as usize, HEIGHT as usize).unwrap();
}

/// Bitmaps have the values and slopes of Mitsuba 3.9's `bitmap` for the same image.
#[test]
fn bitmaps_are_mitsubas() {
    let turned = r#"<transform name="to_uv"><rotate z="1" angle="30"/><scale x="2" y="0.5"/>
        <translate x="0.2" y="0.1"/></transform>"#;
    let nearest = r#"<string name="wrapMode" value="clamp"/><string name="filterType" value="nearest"/>"#;
    let expected = [
        ("", [0.4, 0.2], [0.103647, 0.137352, 0.133307], [0.45717, -0.09365]),
        ("", [-0.3, 1.7], [0.269944, 0.262219, 0.298819], [-0.02786, 0.51181]),
        ("", [0.05, 0.95], [0.353721, 0.26194, 0.200769], [-0.57766, -0.48667]),
        (r#"<boolean name="raw" value="true"/>"#, [0.4, 0.2], [0.320784, 0.385098, 0.356863], [0.54251, -0.61612]),
        (r#"<float name="gamma" value="1"/>"#, [-0.3, 1.7], [0.455608, 0.449804, 0.421098], [0.08498, 0.93727]),
        (
            r#"<string name="wrap_mode" value="mirror"/>"#,
            [-0.3, 1.7],
            [0.14165, 0.18588, 0.266301],
            [0.98485, -0.46853],
        ),
        (r#"<string name="wrap_mode" value="mirror"/>"#, [0.05, 0.95], [0.571125, 0.246201, 0.000607], [0.0, 0.0]),
        (nearest, [0.4, 0.2], [0.05448, 0.147027, 0.07036], [0.0, 0.0]),
        (nearest, [-0.3, 1.7], [0.571125, 0.246201, 0.000607], [0.0, 0.0]),
        (turned, [0.4, 0.2], [0.382991, 0.143718, 0.535276], [-0.26464, -0.029]),
        (turned, [0.05, 0.95], [0.313108, 0.147915, 0.234729], [-3.98115, 1.84284]),
    ];
    for (parameters, uv, color, slope) in expected {
        let scene = load(&bitmap("a.png", parameters));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let (texture, uv) = (&scene.textures[0], DVec2::from_array(uv));
        let found = sample(texture, &scene.images, uv).to_array();
        assert!(found.iter().zip(color).all(|(a, b)| (a - b).abs() < 3e-6), "{parameters} {uv}: {found:?}");
        let found = gradient(texture, &scene.images, uv).to_array();
        assert!(found.iter().zip(slope).all(|(a, b)| (a - b).abs() < 3e-5), "{parameters} {uv}: {found:?}");
    }
}

#[test]
fn old_offsets_and_scales_are_applied_as_mitsuba_3_does() {
    let given = r#"<float name="uscale" value="2"/><float name="vscale" value="3"/>
        <float name="uoffset" value="0.3"/><float name="voffset" value="0.1"/>"#;
    let expected = Mat3::from_cols(Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 3.0, 0.0), Vec3::new(0.6, 0.3, 1.0));
    assert!(load(&bitmap("a.png", given)).textures[0].to_uv.abs_diff_eq(expected, 1e-6));
    let matrix = r#"<transform name="toUV"><matrix value="1 2 3 0.5 4 5 6 0.25 7 8 9 0.1 0 0 0 1"/></transform>"#;
    let expected = Mat3::from_cols(Vec3::new(1.0, 4.0, 0.0), Vec3::new(2.0, 5.0, 0.0), Vec3::new(0.5, 0.25, 1.0));
    assert_eq!(load(&bitmap("a.png", matrix)).textures[0].to_uv, expected);
}

#[test]
fn checkerboards() {
    let texture = r#"<texture name="reflectance" type="checkerboard"><rgb name="color0" value="1, 0, 0"/></texture>"#;
    let scene = load(texture);
    let expected = Pattern::Checkerboard { color0: Vec3::X, color1: Vec3::splat(0.2) };
    assert_eq!(scene.textures[0].pattern, expected);
    // As a number Mitsuba 3.9 gives the other color, and the mean of its channels.
    let body = r#"<shape type="disk"><bsdf type="mask"><texture name="opacity" type="checkerboard">
        <rgb name="color0" value="0.9, 0.3, 0.3"/></texture><bsdf type="diffuse"/></bsdf></shape>"#;
    let scene = Folder::new(&[("scene.xml", &with_sensor(body))]).load(&[]).unwrap();
    let Pattern::Checkerboard { color0, color1 } = scene.textures[0].pattern else { panic!() };
    assert!(color0.abs_diff_eq(Vec3::splat(0.2), 1e-6) && color1.abs_diff_eq(Vec3::splat(0.5), 1e-6));
}

#[test]
fn scales_are_factors() {
    let inner = r#"<texture type="bitmap"><string name="filename" value="a.png"/></texture>"#;
    let scale = |inside: &str, factor: &str, name: &str| {
        format!(r#"<texture {name} type="scale"><rgb name="scale" value="{factor}"/>{inside}</texture>"#)
    };
    let texture = scale(&scale(inner, "0.5", ""), "0.2, 0.4, 0.6", r#"name="reflectance""#);
    let scene = load(&texture);
    assert_eq!(reflectance(&scene), Textured { value: Vec3::new(0.1, 0.2, 0.3), texture: Some(0) });
    assert_eq!(scene.textures.len(), 1);
}

/// Images are shared: one image however often it is named, two if its bytes have two meanings.
#[test]
fn images_are_shared() {
    let shape = |parameters: &str| {
        format!(r#"<shape type="disk"><bsdf type="diffuse">{}</bsdf></shape>"#, bitmap("a.png", parameters))
    };
    let raw = r#"<boolean name="raw" value="true"/>"#;
    let body = [shape(""), shape(r#"<string name="filter_type" value="nearest"/>"#), shape(raw)].concat();
    let folder = Folder::new(&[("scene.xml", &with_sensor(&body))]);
    rgb().save(folder.path("a.png")).unwrap();
    let scene = folder.load(&[]).unwrap();
    assert_eq!((scene.textures.len(), scene.images.len()), (3, 2));
    let is_srgb = |image: usize| matches!(scene.images[image].texels, Texels::Bytes { srgb: true, .. });
    assert!(is_srgb(0) && !is_srgb(1));
}

/// Heights of a file of floats keep their precision, beside the colors of the file. A file of bytes is one image for both.
#[test]
fn heights_keep_their_precision() {
    let body = |file: &str| {
        let bump = bitmap(file, r#"<boolean name="raw" value="true"/>"#).replace(r#"name="reflectance" "#, "");
        let diffuse =
            format!(r#"<bsdf type="diffuse">{}</bsdf>"#, bitmap(file, r#"<boolean name="raw" value="true"/>"#));
        format!(r#"<shape type="disk"><bsdf type="bumpmap">{bump}{diffuse}</bsdf></shape>"#)
    };
    let folder =
        Folder::new(&[("scene.xml", &with_sensor(&body("a.exr"))), ("bytes.xml", &with_sensor(&body("a.png")))]);
    rgb().save(folder.path("a.png")).unwrap();
    save_exr(&folder.path("a.exr"), 3.000_123_4);
    let scene = folder.load(&[]).unwrap();
    let image = |scene: &Scene, texture: usize| match scene.textures[texture].pattern {
        Pattern::Bitmap { image, .. } => image as usize,
        Pattern::Checkerboard { .. } | Pattern::Program(_) => panic!("no image"),
    };
    let MaterialKind::Surface(surface) = &scene.materials[0].kind else { panic!("no surface") };
    let Some(Relief::Bump { texture, .. }) = surface.relief else { panic!("no bump map") };
    let color = reflectance(&scene).texture.expect("a texture") as usize;
    let Texels::Heights(heights) = &scene.images[image(&scene, texture as usize)].texels else { panic!("no heights") };
    assert_eq!((heights[0], heights[6]), (0.25, luminance([0.5, f64::from(3.000_123_4f32), 0.0]) as f32));
    assert!(matches!(scene.images[image(&scene, color)].texels, Texels::Floats(_)));

    let bytes = Scene::load(folder.path("bytes.xml")).unwrap();
    assert_eq!((bytes.textures.len(), bytes.images.len()), (2, 1));
}

#[test]
fn textures_that_nobody_uses_are_not_read() {
    let unused = format!(r#"<bsdf type="diffuse">{}</bsdf>"#, bitmap("a.png", ""));
    let folder = Folder::new(&[("scene.xml", &with_sensor(&unused))]);
    folder.write("a.png", b"no image");
    let scene = folder.load(&[]).unwrap();
    assert!(scene.textures.is_empty() && scene.images.is_empty());
}

fn bytes_of(file: &str, image: impl Into<DynamicImage>) -> Vec<[u8; 4]> {
    let folder = folder(&bitmap(file, ""));
    image.into().save(folder.path(file)).unwrap();
    let mut scene = folder.load(&[]).unwrap();
    assert_eq!((scene.images[0].width, scene.images[0].height), (WIDTH, HEIGHT));
    let Texels::Bytes { srgb: true, data } = scene.images.remove(0).texels else { panic!("{file}") };
    data
}

fn floats_of(file: &str, parameters: &str, save: impl FnOnce(&std::path::Path)) -> Scene {
    let folder = folder(&bitmap(file, parameters));
    save(&folder.path(file));
    folder.load(&[]).unwrap()
}

fn float_texels(scene: &Scene) -> &[[f32; 4]] {
    let Texels::Floats(data) = &scene.images[0].texels else { panic!() };
    data
}

#[test]
fn bytes_of_every_format() {
    let expected: Vec<_> = rgb().pixels().map(|Rgb([r, g, b])| [*r, *g, *b, 255]).collect();
    for file in ["b.png", "b.tga", "b.bmp", "b.tiff"] {
        assert_eq!(bytes_of(file, rgb()), expected, "{file}");
    }
    let jpeg = bytes_of("b.jpg", RgbImage::from_pixel(WIDTH, HEIGHT, Rgb([200, 100, 50])));
    assert!(jpeg.iter().all(|texel| texel.iter().zip([200, 100, 50, 255]).all(|(a, b)| a.abs_diff(b) < 8)), "{jpeg:?}");
    let alpha = RgbaImage::from_fn(WIDTH, HEIGHT, |x, y| Rgba([1, 2, 3, (x + y) as u8]));
    assert_eq!(bytes_of("b.png", alpha)[5], [1, 2, 3, 2]);
    let gray = GrayImage::from_fn(WIDTH, HEIGHT, |x, _| Luma([x as u8 * 50]));
    assert_eq!(bytes_of("b.png", gray)[2], [100, 100, 100, 255]);
    let gray_alpha = GrayAlphaImage::from_pixel(WIDTH, HEIGHT, image::LumaA([9, 8]));
    assert_eq!(bytes_of("b.png", gray_alpha)[0], [9, 9, 9, 8]);
}

/// Misnamed files are read, because the content counts, not the name.
#[test]
fn misnamed_files_are_read() {
    let folder = folder(&bitmap("b.jpg", ""));
    std::fs::copy(folder.path("a.png"), folder.path("b.jpg")).unwrap();
    assert_eq!(folder.load(&[]).unwrap().images.len(), 1);
}

#[test]
fn sixteen_bits_keep_their_precision() {
    let save = |path: &std::path::Path| {
        ImageBuffer::from_pixel(WIDTH, HEIGHT, Luma([32768u16])).save(path).unwrap();
    };
    let raw = floats_of("b.png", r#"<boolean name="raw" value="true"/>"#, save);
    assert!((float_texels(&raw)[0][0] - 32768.0 / 65535.0).abs() < 1e-6);
    let srgb = floats_of("b.png", "", save);
    // ((0.500007 + 0.055) / 1.055)^2.4
    assert!((float_texels(&srgb)[0][1] - 0.214_048).abs() < 1e-5);
}

fn picture(value: f32) -> Picture {
    let count = (WIDTH * HEIGHT) as usize;
    let mut radiance = vec![[0.25; 3]; count];
    radiance[6] = [0.5, value, 0.0];
    Picture {
        radiance,
        sample_count: vec![1; count],
        hit_count: vec![1; count],
        ..Picture::empty(WIDTH, HEIGHT, [0; 2], [WIDTH, HEIGHT])
    }
}

fn save_exr(path: &std::path::Path, value: f32) {
    lodestar::film::write_picture(path, &picture(value), &[]).unwrap();
}

#[test]
fn floating_point_files() {
    let exr = floats_of("b.exr", "", |path| save_exr(path, 0.75));
    assert_eq!(float_texels(&exr)[6], [0.5, 0.75, 0.0, 1.0]);
    assert!(exr.warnings.is_empty(), "{:?}", exr.warnings);
    // A negative reflectance is 0, with a warning. Heights keep their sign.
    let negative = floats_of("b.exr", "", |path| save_exr(path, -0.75));
    assert_eq!(float_texels(&negative)[6], [0.5, 0.0, 0.0, 1.0]);
    assert!(negative.warnings.len() == 1 && negative.warnings[0].contains("negative"), "{:?}", negative.warnings);
    let body = format!(
        r#"<shape type="disk"><bsdf type="bumpmap">{}<bsdf type="diffuse"/></bsdf></shape>"#,
        bitmap("b.exr", "").replace("reflectance", "heights")
    );
    let relief = Folder::new(&[("scene.xml", &with_sensor(&body))]);
    save_exr(&relief.path("b.exr"), -0.75);
    let Texels::Heights(heights) = relief.load(&[]).unwrap().images.remove(0).texels else { panic!("no heights") };
    assert_eq!(heights[6], luminance([0.5, -0.75, 0.0]) as f32);
    // A reflectance above 1 gives a warning and is kept, as in Mitsuba.
    let bright = floats_of("b.exr", "", |path| save_exr(path, 7.0));
    assert_eq!(float_texels(&bright)[6][1], 7.0);
    assert!(bright.warnings.len() == 1 && bright.warnings[0].contains("`b.exr`"), "{:?}", bright.warnings);
    let hdr = floats_of("b.hdr", "", save_hdr);
    assert!(float_texels(&hdr)[3].iter().zip([0.5, 0.25, 0.125]).all(|(a, b)| (a - b).abs() < 0.01));
}

#[test]
fn values_that_are_no_numbers_are_refused() {
    for value in [f32::NAN, f32::INFINITY] {
        let folder = folder(&bitmap("b.exr", ""));
        save_exr(&folder.path("b.exr"), value);
        let message = error(&folder);
        assert!(message.contains("`b.exr`") && message.contains("(2, 1)"), "{message}");
    }
}

#[test]
fn broken_images_are_one_sentence() {
    let large = RgbImage::from_fn(64, 64, |x, y| Rgb([(x * y % 251) as u8, x as u8 * 4, y as u8 * 4]));
    for file in ["b.jpg", "b.png", "b.bmp", "b.tga", "b.tif"] {
        let folder = folder(&bitmap(file, ""));
        large.save(folder.path(file)).unwrap();
        let whole = std::fs::read(folder.path(file)).unwrap();
        for keep in [0, 1, 10, 30, whole.len() / 2, whole.len() - 30] {
            folder.write(file, &whole[..keep]);
            let message = error(&folder);
            assert!(message.contains(file), "{file} cut to {keep}: {message}");
        }
        folder.write(file, &whole);
        assert!(folder.load(&[]).is_ok(), "{file}");
    }
    let folder = folder(&bitmap("b.exr", ""));
    save_exr(&folder.path("b.exr"), 0.5);
    let whole = std::fs::read(folder.path("b.exr")).unwrap();
    folder.write("b.exr", &whole[..whole.len() / 2]);
    assert!(error(&folder).contains("b.exr"));
    folder.write("b.exr", b"GIF89a and more");
    assert!(error(&folder).contains("images of the format GIF are not read"));
}

/// Images of absurd sizes are refused before anything is allocated for them.
#[test]
fn images_of_absurd_sizes_are_refused() {
    let folder = folder(&bitmap("b.bmp", ""));
    rgb().save(folder.path("b.bmp")).unwrap();
    let mut bytes = std::fs::read(folder.path("b.bmp")).unwrap();
    // Width and height are at bytes 18 and 22.
    bytes[18..26].copy_from_slice(&[0xff, 0xff, 0, 0, 0xff, 0xff, 0, 0]);
    folder.write("b.bmp", &bytes);
    assert!(error(&folder).contains("b.bmp"));
}

#[test]
fn what_is_not_supported_is_said() {
    let refused = |texture: &str, part: &str| {
        let message = error(&folder(texture));
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    };
    refused(&bitmap("gone.png", ""), "`gone.png`");
    refused(&bitmap("a.png", r#"<string name="wrap_mode" value="zero"/>"#), "`zero`");
    refused(&bitmap("a.png", r#"<string name="filter_type" value="sharp"/>"#), "`sharp`");
    refused(&bitmap("a.png", r#"<float name="raw" value="1"/>"#), "`raw`");
    refused(r#"<texture name="reflectance" type="bitmap"/>"#, "`filename`");
    refused(r#"<texture name="reflectance" type="marble"/>"#, "`marble`");
    let twice = format!(r#"<rgb name="reflectance" value="0.5"/>{}"#, bitmap("a.png", ""));
    refused(&twice, "twice");
    let itself = r#"<texture name="reflectance" type="scale" id="t"><ref id="t"/></texture>"#;
    refused(itself, "itself");
    let warned = |parameters: &str, part: &str| {
        let warnings = load(&bitmap("a.png", parameters)).warnings;
        assert!(warnings.len() == 1 && warnings[0].contains(part) && warnings[0].contains("scene.xml:2: "));
    };
    warned(r#"<string name="filterType" value="ewa"/>"#, "`ewa`");
    warned(r#"<float name="gamma" value="1.8"/>"#, "1.8");
    warned(r#"<float name="wobble" value="1"/>"#, "`wobble`");
}

#[test]
fn filters_and_wrap_modes() {
    let pattern = |parameters: &str| load(&bitmap("a.png", parameters)).textures[0].pattern.clone();
    let expected = |filter, wrap| Pattern::Bitmap { image: 0, filter, wrap };
    assert_eq!(pattern(""), expected(TexelFilter::Bilinear, WrapMode::Repeat));
    let given = r#"<string name="filter_type" value="nearest"/><string name="wrap_mode" value="mirror"/>"#;
    assert_eq!(pattern(given), expected(TexelFilter::Nearest, WrapMode::Mirror));
}

/// Encoded bytes are decoded after they are mixed, if the scene asks for it. It changes neither raw images nor nearest texels nor heights.
#[test]
fn bytes_are_decoded_after_the_filter() {
    let after = |value: &str| format!(r#"<boolean name="decode_after_filter" value="{value}"/>"#);
    let color = |parameters: &str| {
        let scene = load(&bitmap("a.png", parameters));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        sample(&scene.textures[0], &scene.images, DVec2::new(0.25, 0.5 / 3.0)).truncate()
    };
    let decoded = |share: fn(f64, f64) -> f64| {
        DVec3::from_array(std::array::from_fn(|i| share(f64::from(pixel(0, 0)[i]), f64::from(pixel(1, 0)[i]))))
    };
    let first = decoded(|a, b| 0.5 * (linear_from_srgb(a / 255.0) + linear_from_srgb(b / 255.0)));
    let mixed = decoded(|a, b| linear_from_srgb(0.5 * (a + b) / 255.0));
    let raw = decoded(|a, b| 0.5 * (a + b) / 255.0);
    assert!((first - mixed).abs().max_element() > 0.05);
    assert!(color(&after("true")).abs_diff_eq(mixed, 1e-9));
    assert!(color(&after("false")).abs_diff_eq(first, 1e-9));
    assert!(color(&(after("true") + r#"<boolean name="raw" value="true"/>"#)).abs_diff_eq(raw, 1e-9));
    let nearest = r#"<string name="filter_type" value="nearest"/>"#;
    assert_eq!(color(&(after("true") + nearest)), color(nearest));

    let bump = bitmap("a.png", &after("true")).replace(r#"name="reflectance" "#, "");
    let body = format!(r#"<shape type="disk"><bsdf type="bumpmap">{bump}<bsdf type="diffuse"/></bsdf></shape>"#);
    let folder = Folder::new(&[("scene.xml", &with_sensor(&body))]);
    rgb().save(folder.path("a.png")).unwrap();
    let heights = folder.load(&[]).unwrap().textures.remove(0).pattern;
    assert_eq!(heights, Pattern::Bitmap { image: 0, filter: TexelFilter::Bilinear, wrap: WrapMode::Repeat });
    let message = error(&self::folder(&bitmap("a.png", r#"<float name="decode_after_filter" value="1"/>"#)));
    assert!(message.contains("`decode_after_filter`"), "{message}");
}

#[test]
fn radiance_takes_textures() {
    let texture = bitmap("a.png", "").replace("reflectance", "radiance");
    let scale = format!(r#"<texture name="radiance" type="scale"><float name="scale" value="30"/>{texture}</texture>"#);
    let body = format!(r#"<shape type="disk"><emitter type="area">{scale}</emitter></shape>"#);
    let folder = Folder::new(&[("scene.xml", &with_sensor(&body))]);
    rgb().save(folder.path("a.png")).unwrap();
    let scene = folder.load(&[]).unwrap();
    assert_eq!(scene.emitters[0].radiance, Textured { value: Vec3::splat(30.0), texture: Some(0) });
}
