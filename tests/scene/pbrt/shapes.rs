//! Shapes, objects and instances.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::{Vec2, Vec3};
use lodestar::scene::{PrimitiveShape, Scene, convert};

use super::{assert_close, load_in, world};
use crate::Folder;
use crate::meshes::ascii_ply;

fn counts(scene: &Scene) -> [usize; 3] {
    let count = |shape: PrimitiveShape| scene.primitives.iter().filter(|primitive| primitive.shape == shape).count();
    [count(PrimitiveShape::Triangle), count(PrimitiveShape::Disk), count(PrimitiveShape::Sphere)]
}

#[test]
fn forms() {
    for (shape, expected) in [
        ("Shape \"sphere\"", [0, 0, 1]),
        ("Shape \"sphere\" \"float radius\" 2 \"float zmin\" -2 \"float zmax\" 2 \"float phimax\" 360", [0, 0, 1]),
        ("Shape \"disk\" \"float height\" 2", [0, 1, 0]),
        ("Shape \"disk\" \"float innerradius\" 0.5", [256, 0, 0]),
        ("Shape \"cylinder\"", [256, 0, 0]),
        ("Shape \"cylinder\" \"float phimax\" 90", [64, 0, 0]),
        ("Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]", [1, 0, 0]),
        ("Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 0 ]", [2, 0, 0]),
        ("Shape \"loopsubdiv\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer levels\" 2", [16, 0, 0]),
        // Half of a sphere: 32 rings of 128 squares, of which those at the pole are triangles.
        ("Shape \"sphere\" \"float zmin\" 0", [2 * 32 * 128 - 128, 0, 0]),
        // A sphere that is scaled unevenly.
        ("Scale 1 2 1 Shape \"sphere\"", [2 * 64 * 128 - 2 * 128, 0, 0]),
    ] {
        assert_eq!(counts(&world(shape).unwrap()), expected, "{shape}");
    }
}

/// Surfaces of revolution face outward, and disks along +z.
#[test]
fn fronts_of_cut_forms() {
    for shape in ["Shape \"sphere\" \"float zmax\" 0.5", "Shape \"cylinder\"", "Scale 1 1 2 Shape \"sphere\""] {
        for primitive in world(shape).unwrap().primitives {
            let facing = primitive.edge_u.cross(primitive.edge_v) * if primitive.flip_normal { -1.0 } else { 1.0 };
            assert!(facing.dot(primitive.origin) > 0.0, "{shape}: {primitive:?}");
        }
    }
    for primitive in world("Shape \"disk\" \"float innerradius\" 0.5").unwrap().primitives {
        let facing = primitive.edge_u.cross(primitive.edge_v) * if primitive.flip_normal { -1.0 } else { 1.0 };
        assert!(facing.z > 0.0);
    }
}

/// Vertices carry what the file gives. Triangles without coordinates have pbrt's where a texture asks for them.
#[test]
fn vertices() {
    let mesh = "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"normal N\" [ 0 0 1 0 0.6 0.8 0 0 1 ]";
    let scene = world(&format!("{mesh} \"point2 uv\" [ 0.1 0.2 0.3 0.4 0.5 0.6 ]")).unwrap();
    let [primitive] = &scene.primitives[..] else { panic!("one triangle") };
    assert_eq!(primitive.uvs, [Vec2::new(0.1, 0.2), Vec2::new(0.3, 0.4), Vec2::new(0.5, 0.6)]);
    assert!((primitive.normals.unwrap()[1] - Vec3::new(0.0, 0.6, 0.8)).length() < 1e-6);
    let textured = world(&format!(
        "Texture \"t\" \"spectrum\" \"checkerboard\" Material \"diffuse\" \"texture reflectance\" \"t\" {mesh}"
    ))
    .unwrap();
    assert_eq!(textured.primitives[0].uvs, [Vec2::ZERO, Vec2::X, Vec2::ONE]);
    assert!((textured.primitives[0].normals.unwrap()[1] - Vec3::new(0.0, 0.6, 0.8)).length() < 1e-6);
    let flat = world("Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]").unwrap();
    assert_eq!(flat.primitives[0].normals, None);
}

/// A PLY file gives the same triangles, compressed or not.
#[test]
fn ply_files() {
    let ply = ascii_ply();
    let mut compressed = GzEncoder::new(Vec::new(), Compression::default());
    compressed.write_all(&ply).unwrap();
    let folder = Folder::new(&[]);
    folder.write("a.ply", &ply);
    folder.write("a.ply.gz", &compressed.finish().unwrap());
    let read = |name: &str| {
        folder.write(
            "scene.pbrt",
            format!(
                "Camera \"perspective\" WorldBegin Translate 0 0 3 Shape \"plymesh\" \"string filename\" \"{name}\""
            )
            .as_bytes(),
        );
        load_in(&folder)
    };
    let plain = read("a.ply").unwrap();
    assert!(!plain.primitives.is_empty());
    assert_eq!(plain.primitives, read("a.ply.gz").unwrap().primitives);
    let error = read("none.ply").unwrap_err();
    assert!(error.contains("scene.pbrt:1: the mesh file `none.ply` does not exist"), "{error}");
}

#[test]
fn instances_are_placed_in_the_world() {
    let object = "ObjectBegin \"o\" Translate 1 0 0 Shape \"sphere\" \"float radius\" 0.5 AreaLightSource \"diffuse\" Shape \"disk\" ObjectEnd";
    let scene = world(&format!(
        "{object}\nAttributeBegin Translate 0 5 0 Scale 2 2 2 ObjectInstance \"o\" AttributeEnd ObjectInstance \"o\""
    ))
    .unwrap();
    let spheres: Vec<_> =
        scene.primitives.iter().filter(|p| p.shape == PrimitiveShape::Sphere).map(|p| p.origin).collect();
    assert_eq!(spheres, [Vec3::new(2.0, 5.0, 0.0), Vec3::X]);
    assert_eq!((scene.primitives.len(), scene.emitters.len()), (4, 0));
    assert!(scene.warnings.join("\n").contains("scene.pbrt:3: shapes of objects do not emit, as in pbrt"));
    let unused = world(object).unwrap();
    assert!(unused.primitives.is_empty());
}

#[test]
fn what_is_refused() {
    for (shape, expected) in [
        (
            "Shape \"loopsubdiv\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer levels\" 12 \"integer indices\" [ 0 1 2 0 1 2 ]",
            "triangles that face both ways",
        ),
        ("Shape \"cone\"", "the shape `cone` belongs to pbrt-v3"),
        ("Shape \"wrong\"", "the shape `wrong` is not known"),
        ("Shape \"trianglemesh\"", "needs its parameter \"point3 P\""),
        ("Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 ]", "some are missing"),
        (
            "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 3 ]",
            "has the index 3, but there are 3 vertices",
        ),
        ("Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 ]", "a multiple of 3"),
        (
            "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"normal N\" [ 0 0 1 ]",
            "has 1 values for 3 vertices",
        ),
        ("Shape \"sphere\" \"float radius\" -1", "must be greater than 0"),
        ("ObjectInstance \"none\"", "there is no object `none`"),
        ("ObjectBegin \"o\" ObjectInstance \"o\" ObjectEnd", "ObjectInstance inside an object"),
        ("ObjectBegin \"o\" Shape \"sphere\"", "an object without an ObjectEnd"),
    ] {
        let error = world(shape).expect_err(expected);
        assert!(error.contains(expected) && error.contains("scene.pbrt:3: "), "{error} lacks {expected}");
    }
}

/// Vertices of a scene's triangles.
fn corners(scene: &Scene) -> Vec<Vec3> {
    scene.primitives.iter().flat_map(|p| [p.origin, p.origin + p.edge_u, p.origin + p.edge_v]).collect()
}

/// Tubes have half of a curve's width as their radius, whatever the curve's basis and degree are.
#[test]
fn curves_are_tubes() {
    let straight = |parameters: &str| {
        world(&format!("Shape \"curve\" \"float width0\" 1 \"float width1\" 0.5 {parameters}")).unwrap()
    };
    for (parameters, length) in [
        ("\"point3 P\" [ 0 0 0  0 0 1  0 0 2  0 0 3 ]", 3.0),
        ("\"point3 P\" [ 0 0 0  0 0 1  0 0 2  0 0 3  0 0 4  0 0 5  0 0 6 ] \"string type\" \"cylinder\"", 6.0),
        ("\"point3 P\" [ 0 0 0  0 0 1  0 0 2 ] \"integer degree\" 2", 2.0),
        ("\"point3 P\" [ 0 0 -1  0 0 0  0 0 1  0 0 2  0 0 3 ] \"string basis\" \"bspline\"", 2.0),
        ("\"point3 P\" [ 0 0 -.5  0 0 .5  0 0 1.5  0 0 2.5 ] \"string basis\" \"bspline\" \"integer degree\" 2", 2.0),
    ] {
        let scene = straight(parameters);
        let places = corners(&scene);
        let (low, high) = places.iter().fold((f32::MAX, f32::MIN), |(low, high), at| (low.min(at.z), high.max(at.z)));
        assert_close(&[low, high], &[0.0, length]);
        for at in places {
            let expected = 0.5 - 0.25 * at.z / length;
            let found = at.truncate().length();
            assert!((found - expected).abs() < 0.01 * expected, "{parameters}: {found} is not {expected} at {}", at.z);
        }
        let sentence = "scene.pbrt:3: curves are read as tubes of triangles; a flat one is shaded as a tube, too";
        assert_eq!(
            scene.warnings.iter().filter(|warning| warning.contains(sentence)).count(),
            1,
            "{:?}",
            scene.warnings
        );
    }
    // The same curve in both bases.
    let spline = straight("\"point3 P\" [ 0 0 0  3 0 0  3 3 3  0 6 3 ] \"string basis\" \"bspline\"");
    let segment = straight("\"point3 P\" [ 2.5 .5 .5  3 1 1  3 2 2  2.5 3 2.5 ]");
    assert_eq!(spline.primitives.len(), segment.primitives.len());
    for (one, other) in corners(&spline).into_iter().zip(corners(&segment)) {
        assert!((one - other).length() < 1e-4, "{one} is not {other}");
    }
}

/// Curves of one material become one shape, so that hair is as coarse as all of it must be.
#[test]
fn curves_of_a_material_are_one_shape() {
    let curve = "Shape \"curve\" \"point3 P\" [ 0 0 0  0 0 1  0 0 2  0 0 3 ] \"float width\" 0.1 ";
    let shapes = |text: &str| {
        let file = Folder::new(&[("scene.pbrt", &format!("Camera \"perspective\" WorldBegin {text}"))]);
        let path = file.path("scene.xml");
        convert(&file.path("scene.pbrt"), &[], &path, false).unwrap();
        std::fs::read_to_string(path).unwrap().matches("<shape ").count()
    };
    let one = shapes(curve);
    assert_eq!(shapes(&curve.repeat(3)), one);
    assert_eq!(shapes(&format!("{curve} Material \"diffuse\" {curve}")), one + 1);
    assert_eq!(shapes(&format!("{curve} Translate 1 0 0 {curve}")), one + 1);
}

/// Along each curve `u` runs from 0 to 1, also where several become one shape.
#[test]
fn curves_have_coordinates_of_their_own() {
    let curve = "Shape \"curve\" \"point3 P\" [ 0 0 0  0 0 1  0 0 2  0 0 3  0 0 4  0 0 5  0 0 6 ] \"float width\" 0.1 ";
    let scene = world(&curve.repeat(3)).unwrap();
    for primitive in &scene.primitives {
        let places = [primitive.origin, primitive.origin + primitive.edge_u, primitive.origin + primitive.edge_v];
        for (place, uv) in places.iter().zip(primitive.uvs) {
            assert!((uv.x - place.z / 6.0).abs() < 1e-4, "{uv} at {}", place.z);
        }
    }
}

/// A ribbon is a strip across its normals, which are also those of the surface.
#[test]
fn ribbons_are_strips() {
    let scene = world(
        "Shape \"curve\" \"string type\" \"ribbon\" \"float width\" 0.5 \"point3 P\" [ 0 0 0  0 0 1  0 0 2  0 0 3 ] \"normal N\" [ 0 1 0  0 1 0 ]",
    )
    .unwrap();
    assert_eq!(scene.primitives.len(), 16);
    for at in corners(&scene) {
        assert_close(&[at.x.abs(), at.y], &[0.25, 0.0]);
    }
    for normal in scene.primitives.iter().flat_map(|primitive| primitive.normals.into_iter().flatten()) {
        assert_close(&normal.abs().to_array(), &[0.0, 1.0, 0.0]);
    }
    for (parameters, says) in [
        (
            "\"point3 P\" [ 0 0 0  0 0 1  0 0 2 ]",
            "a curve of degree 3 needs 4 points in `P`, and 3 more for each further segment, not 3",
        ),
        ("\"string basis\" \"bspline\"", "a curve of degree 3 needs 4 points in `P`, not 0"),
        ("\"string basis\" \"hermite\"", "the basis `hermite` is not known"),
        ("\"float width1\" -1", "the width of a curve must not be negative, as -1 is"),
        (
            "\"point3 P\" [ 0 0 0  0 0 1  0 0 2  0 0 3 ] \"string type\" \"ribbon\"",
            "a ribbon of 1 segments needs 2 normals `N`, not 0",
        ),
        (
            "\"point3 P\" [ 0 0 0  0 0 1  0 0 2  0 0 3 ] \"string type\" \"round\"",
            "the type `round` of curves is not known",
        ),
        ("\"point3 P\" [ 0 0 0  0 0 0  0 0 0  0 0 0 ]", "the curves have no surface"),
    ] {
        let error = world(&format!("Shape \"curve\" {parameters}")).expect_err(says);
        assert!(error.contains(says) && error.contains("scene.pbrt:3: "), "{error} lacks {says}");
    }
}
