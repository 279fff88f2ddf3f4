//! Reader of USD: a room in all four forms, and small stages written here.

use std::path::{Path, PathBuf};

use lodestar::scene::{DeltaKind, EnvironmentKind, LoadOptions, Primitive, PrimitiveShape, Scene, fingerprint, load};

use crate::Folder;
use crate::fuzz::{check, fuzz, mangled};

/// The room in Mitsuba's words, written without the reader of USD.
const ROOM: &str = r#"<scene version="3.0.0"><sensor type="perspective">
<transform name="to_world"><lookat origin="0, 1, 6" target="0, 1, 5" up="0, 1, 0"/></transform>
<float name="fov" value="39.597752709049864"/><string name="fov_axis" value="x"/>
<float name="near_clip" value="0.5"/><float name="far_clip" value="1000"/>
<film type="hdrfilm"><integer name="width" value="1080"/><integer name="height" value="720"/></film></sensor>
<shape type="rectangle"><transform name="to_world"><matrix value="-1 0 0 0 0 0 -1 3 0 -0.5 0 0 0 0 0 1"/></transform>
<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>
<emitter type="area"><rgb name="radiance" value="8, 4, 2"/></emitter></shape>
<shape type="obj"><string name="filename" value="floor.obj"/><boolean name="face_normals" value="true"/>
<bsdf type="twosided"><bsdf type="principled"><texture type="bitmap" name="base_color"><string name="filename"
value="image.png"/></texture><float name="metallic" value="0"/><float name="eta" value="1.5"/>
<float name="roughness" value="0.5"/></bsdf></bsdf></shape>
<shape type="sphere"><float name="radius" value="0.75"/><transform name="to_world"><translate x="-1" y="0.75"/></transform>
<bsdf type="twosided"><bsdf type="principled"><rgb name="base_color" value="1, 0.75, 0.25"/><float name="metallic"
value="1"/><float name="eta" value="1.5"/><float name="roughness" value="0.25"/></bsdf></bsdf></shape>
<shape type="obj"><string name="filename" value="wall.obj"/><boolean name="face_normals" value="true"/>
<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.25, 0.5, 0.75"/></bsdf></bsdf></shape>
</scene>"#;

const FLOOR: &str = "v -3 0 3\nv 3 0 3\nv 3 0 -3\nv -3 0 -3\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
const WALL: &str = "v -3 0 -3\nv 3 0 -3\nv 3 2 -3\nv 0 1 -3\nv -3 2 -3\nf 1 2 3 4 5\n";

pub(crate) fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/usd").join(name)
}

fn read(path: &Path) -> Scene {
    load(path, &LoadOptions::default()).unwrap()
}

/// A stage of this text.
pub(crate) fn stage(body: &str) -> Result<Scene, String> {
    stage_with("", body, &[])
}

/// A stage with metadata, and with choices of the user.
pub(crate) fn stage_with(metadata: &str, body: &str, defines: &[(&str, &str)]) -> Result<Scene, String> {
    let folder = Folder::new(&[("stage.usda", &format!("#usda 1.0\n({metadata})\n{body}"))]);
    let defines = defines.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
    load(&folder.path("stage.usda"), &LoadOptions { defines, ..LoadOptions::default() })
        .map_err(|error| error.to_string())
}

/// A square mesh with more properties.
pub(crate) fn square(name: &str, more: &str) -> String {
    format!(
        "def Mesh \"{name}\" {{ uniform token subdivisionScheme = \"none\"\npoint3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), \
         (0, 1, 0)]\nint[] faceVertexCounts = [4]\nint[] faceVertexIndices = [0, 1, 2, 3]\n{more}\n}}\n"
    )
}

fn is_near(ours: &Primitive, theirs: &Primitive) -> bool {
    let vectors = |primitive: &Primitive| [primitive.origin, primitive.edge_u, primitive.edge_v];
    let is_near = |(a, b): (&glam::Vec3, &glam::Vec3)| a.distance(*b) < 1.0e-5;
    let uvs = |primitive: &Primitive| primitive.uvs;
    ours.shape == theirs.shape
        && vectors(ours).iter().zip(&vectors(theirs)).all(is_near)
        && uvs(ours).iter().zip(&uvs(theirs)).all(|(a, b)| a.distance(*b) < 1.0e-5)
        && ours.emitter == theirs.emitter
        && ours.flip_normal == theirs.flip_normal
}

/// Camera, film, primitives, materials, lamp and texture are those of the XML, so the pictures are.
#[test]
fn the_room_is_that_of_its_xml() {
    let folder = Folder::new(&[("scene.xml", ROOM), ("floor.obj", FLOOR), ("wall.obj", WALL)]);
    folder.write("image.png", &std::fs::read(data("image.png")).unwrap());
    let (ours, theirs) = (read(&data("room.usda")), read(&folder.path("scene.xml")));
    assert_eq!(ours.warnings, Vec::<String>::new());
    assert_eq!((ours.film, ours.camera.fov_axis), (theirs.film, theirs.camera.fov_axis));
    assert!((ours.camera.fov - theirs.camera.fov).abs() < 1.0e-4);
    assert!(ours.camera.world_from_camera.abs_diff_eq(theirs.camera.world_from_camera, 1.0e-6));
    assert_eq!(ours.primitives.len(), theirs.primitives.len());
    for (ours, theirs) in ours.primitives.iter().zip(&theirs.primitives) {
        assert!(is_near(ours, theirs), "{ours:?} is not {theirs:?}");
    }
    let bsdfs = |scene: &Scene| {
        let materials = scene.primitives.iter().map(|primitive| &scene.materials[primitive.material as usize]);
        materials.map(|material| format!("{:?}", material.kind)).collect::<Vec<_>>()
    };
    assert_eq!(bsdfs(&ours), bsdfs(&theirs));
    assert_eq!(ours.emitters, theirs.emitters);
    assert_eq!(ours.textures.len(), theirs.textures.len());
    assert_eq!(ours.cameras, [Some("Main".to_owned())]);
}

#[test]
fn all_forms_are_one_scene() {
    let text = fingerprint(&read(&data("room.usda"))).unwrap();
    for name in ["room.usdc", "room.usdz"] {
        assert_eq!(fingerprint(&read(&data(name))).unwrap(), text, "{name}");
    }
    // A file that ends in `.usd` may have either form.
    let folder = Folder::new(&[]);
    folder.write("image.png", &std::fs::read(data("image.png")).unwrap());
    for name in ["room.usda", "room.usdc"] {
        folder.write("room.usd", &std::fs::read(data(name)).unwrap());
        assert_eq!(fingerprint(&read(&folder.path("room.usd"))).unwrap(), text, "{name}");
    }
}

#[test]
fn what_is_hidden_is_not_shown() {
    let hidden =
        ["token visibility = \"invisible\"", "uniform token purpose = \"guide\"", "uniform token purpose = \"proxy\""];
    let shown = ["uniform token purpose = \"render\"", ""];
    let all: String = hidden.iter().chain(&shown).enumerate().map(|(i, more)| square(&format!("M{i}"), more)).collect();
    let others = "class Xform \"C\" { def Sphere \"S\" {} }\nover \"O\" { def Sphere \"S\" {} }\n\
                  def Xform \"P\" { uniform token purpose = \"guide\"\ndef Sphere \"S\" { uniform token purpose = \"render\" } }\n\
                  def Sphere \"Off\" (active = false) {}";
    // A prim's own purpose goes before its parent's.
    assert_eq!(stage(&format!("{all}{others}")).unwrap().primitives.len(), 5);
}

/// Operations apply from the last to the first, and a reset leaves out the parents.
#[test]
fn operations_of_transforms_are_in_order() {
    let origin = |body: &str| {
        let scene = stage(body).unwrap();
        scene.primitives[0].origin.to_array().map(|c| (c * 1000.0).round() / 1000.0)
    };
    let with = |operations: &str| {
        format!(
            "def Xform \"P\" {{ double3 xformOp:translate = (10, 0, 0)\nuniform token[] xformOpOrder = [\"xformOp:translate\"]\n\
                 def Sphere \"S\" {{ {operations} }} }}"
        )
    };
    let (translate, rotate) = ("double3 xformOp:translate = (1, 0, 0)", "float xformOp:rotateZ = 90");
    let order = |list: &str| format!("{translate}\n{rotate}\nuniform token[] xformOpOrder = [{list}]");
    assert_eq!(origin(&with(&order("\"xformOp:translate\", \"xformOp:rotateZ\""))), [11.0, 0.0, 0.0]);
    assert_eq!(origin(&with(&order("\"xformOp:rotateZ\", \"xformOp:translate\""))), [10.0, 1.0, 0.0]);
    assert_eq!(origin(&with(&order("\"!invert!xformOp:translate\""))), [9.0, 0.0, 0.0]);
    assert_eq!(origin(&with(&order("\"!resetXformStack!\", \"xformOp:translate\""))), [1.0, 0.0, 0.0]);
    let euler = "float3 xformOp:rotateXYZ = (90, 90, 0)\ndouble3 xformOp:translate = (0, 1, 0)\n\
                 uniform token[] xformOpOrder = [\"xformOp:rotateXYZ\", \"xformOp:translate\"]";
    // +y turns to +z about x, then to +x about y.
    assert_eq!(origin(&with(euler)), [11.0, 0.0, 0.0]);
    let up = "def Sphere \"S\" { double3 xformOp:translate = (0, 0, 5)\nuniform token[] xformOpOrder = [\"xformOp:translate\"] }";
    let scene = stage_with("upAxis = \"Z\"", up, &[]).unwrap();
    assert!((scene.primitives[0].origin - glam::Vec3::new(0.0, 5.0, 0.0)).length() < 1.0e-5);
}

/// Without a default, the first sample of an attribute counts. A user may choose a moment.
#[test]
fn moments_are_chosen() {
    let body = "def Sphere \"S\" { double radius.timeSamples = { 10: 2.5, 20: 4.5 } }";
    let radius = |defines: &[(&str, &str)]| {
        stage_with("timeCodesPerSecond = 10", body, defines).unwrap().primitives[0].edge_u.length()
    };
    assert!((radius(&[]) - 2.5).abs() < 1.0e-5);
    assert!((radius(&[("time", "1.5")]) - 3.5).abs() < 1.0e-5);
    let error = stage_with("", body, &[("spp", "4")]).unwrap_err();
    assert!(error.contains("-D spp: a USD file has only the value `time`"), "{error}");
}

#[test]
fn faces_have_holes_sides_and_parts() {
    let two = "def Mesh \"M\" { uniform token subdivisionScheme = \"none\"\npoint3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), \
               (2, 0, 0), (2, 1, 0)]\nint[] faceVertexCounts = [4, 4]\nint[] faceVertexIndices = [0, 1, 2, 3, 1, 4, 5, 2]\nMORE }";
    let normal = |scene: &Scene| {
        let primitive = &scene.primitives[0];
        let sign = if primitive.flip_normal { -1.0 } else { 1.0 };
        (sign * primitive.edge_u.cross(primitive.edge_v)).z.signum()
    };
    let with = |more: &str| stage(&two.replace("MORE", more)).unwrap();
    assert_eq!((with("").primitives.len(), normal(&with(""))), (4, 1.0));
    assert_eq!(with("int[] holeIndices = [0]").primitives.len(), 2);
    assert_eq!(normal(&with("uniform token orientation = \"leftHanded\"")), -1.0);
    let part = "def GeomSubset \"Part\" { uniform token elementType = \"face\"\nuniform token familyName = \"materialBind\"\n\
                int[] indices = [1]\nrel material:binding = </Glow> }";
    let glow = "def Material \"Glow\" { token outputs:surface.connect = </Glow/S.outputs:surface>\ndef Shader \"S\" {\n\
                uniform token info:id = \"UsdPreviewSurface\"\ncolor3f inputs:emissiveColor = (1, 2, 3)\ntoken outputs:surface } }";
    let scene = stage(&format!("{}{glow}", two.replace("MORE", part))).unwrap();
    assert_eq!(scene.primitives.len(), 4);
    assert_eq!(scene.primitives.iter().filter(|primitive| primitive.emitter.is_some()).count(), 2);
    assert_eq!(scene.emitters[0].radiance.value.to_array(), [1.0, 2.0, 3.0]);
}

/// Lights have what the formulas of UsdLux say.
#[test]
fn lights_are_normalized() {
    let delta = |body: &str| stage(&format!("{}{body}", square("M", ""))).unwrap().delta_emitters[0].kind;
    let sun = delta("def DistantLight \"L\" { float inputs:intensity = 3\nfloat inputs:angle = 0 }");
    assert!(
        matches!(sun, DeltaKind::Directional { irradiance, direction }
        if irradiance.x == 3.0 && direction == glam::Vec3::NEG_Z),
        "{sun:?}"
    );
    let DeltaKind::Directional { irradiance, .. } = delta("def DistantLight \"L\" {}") else { panic!("no sun") };
    // The schema's defaults: pi sin^2(0.265 degrees) times 50,000.
    assert!((irradiance.x - 3.36).abs() < 0.01, "{irradiance}");
    let DeltaKind::Point { intensity, .. } =
        delta("def SphereLight \"L\" { float inputs:radius = 2\nbool treatAsPoint = true }")
    else {
        panic!("no point")
    };
    assert!((intensity.x - 4.0 * std::f32::consts::PI).abs() < 1.0e-4);
    let lit = |body: &str| stage(&format!("{}{body}", square("M", ""))).unwrap().emitters[0].radiance.value.x;
    assert_eq!(
        lit("def RectLight \"L\" { float inputs:width = 2\nfloat inputs:height = 4\nbool inputs:normalize = true\n\
                    float inputs:intensity = 16 }"),
        2.0
    );
    let ball = lit("def SphereLight \"L\" { float inputs:radius = 0.5\nbool inputs:normalize = true }");
    assert!((ball - std::f32::consts::FRAC_1_PI).abs() < 1.0e-6);
    let sky = stage(&format!("{}def DomeLight \"L\" {{ float inputs:exposure = 2 }}", square("M", ""))).unwrap();
    assert!(matches!(sky.environment.unwrap().kind, EnvironmentKind::Constant { radiance, .. } if radiance.x == 4.0));
}

/// The copies of an instancer are instances of its prototypes.
#[test]
fn instancers_show_their_prototypes() {
    let body = "def PointInstancer \"I\" { rel prototypes = [</I/A>, </I/B>]\nint[] protoIndices = [0, 1, 0]\n\
                point3f[] positions = [(0, 0, 0), (5, 0, 0), (0, 7, 0)]\nfloat3[] scales = [(1, 1, 1), (2, 2, 2), (1, 1, 1)]\n\
                int64[] invisibleIds = [2]\ndef Sphere \"A\" {}\ndef Xform \"B\" { def Sphere \"S\" { double3 xformOp:translate = (1, 0, 0)\n\
                uniform token[] xformOpOrder = [\"xformOp:translate\"] } } }";
    let scene = stage(body).unwrap();
    let origins: Vec<_> = scene.primitives.iter().map(|primitive| primitive.origin.to_array()).collect();
    assert_eq!(origins, [[0.0; 3], [7.0, 0.0, 0.0]]);
    let shared = "class Xform \"C\" { def Sphere \"S\" {} }\n\
                  def \"X\" (instanceable = true\ninherits = </C>) {}\ndef \"Y\" (instanceable = true\ninherits = </C>) {}";
    assert_eq!(stage(shared).unwrap().primitives.len(), 2);
}

#[test]
fn faults_are_told() {
    let told = |result: Result<Scene, String>, part: &str| {
        let message = result.map(drop).expect_err(part);
        assert!(message.contains(part) && message.contains("stage.usda"), "`{part}` is missing in: {message}");
    };
    told(stage(""), "its stage shows neither shapes nor a camera");
    told(stage("def Mesh \"M\" { "), "it is no USD file");
    told(
        stage("def Mesh \"M\" { rel material:binding = </Looks/Paint\ndef Mesh \"N\" {} }"),
        "a path between < and > in it is not closed",
    );
    told(stage(&"def Xform \"X\" {".repeat(600)), "its brackets are nested more than 512 deep");
    let far = square("N", "").replace("[0, 1, 2, 3]", "[0, 1, 2, 9]");
    let warned = stage(&format!("{}{far}", square("M", ""))).unwrap();
    let sentence = "/N: an index of `faceVertexIndices` is larger than the number of points; it is not rendered";
    assert!(warned.primitives.len() == 2 && warned.warnings.iter().any(|text| text.contains(sentence)));
    let warned = stage(&format!("{}def Points \"P\" {{}}", square("M", ""))).unwrap();
    assert!(warned.warnings.iter().any(|text| text.contains("prims of the type `Points` are not rendered")));
    let missing = "def Xform \"X\" (references = @nothing.usda@) {}";
    let warned = stage(&format!("{}{missing}", square("M", ""))).unwrap();
    assert!(warned.warnings.iter().any(|text| text.contains("nothing.usda")), "{:?}", warned.warnings);
}

/// Damaged binary layers and archives are refused without a great allocation.
#[test]
fn damaged_files_are_refused() {
    let folder = Folder::new(&[]);
    for name in ["room.usdc", "room.usdz"] {
        let bytes = std::fs::read(data(name)).unwrap();
        for cut in [0, 8, 20, 90, bytes.len() / 2, bytes.len() - 1] {
            folder.write(name, &bytes[..cut]);
            assert!(load(&folder.path(name), &LoadOptions::default()).is_err(), "{name} of {cut} bytes");
        }
    }
    let bytes = std::fs::read(data("room.usdc")).unwrap();
    // Numbers that ask for more than any memory holds.
    for at in (0..bytes.len() - 8).step_by(7) {
        let mut bytes = bytes.clone();
        bytes[at..at + 8].copy_from_slice(&(u64::MAX >> 20).to_le_bytes());
        folder.write("room.usdc", &bytes);
        let _ = load(&folder.path("room.usdc"), &LoadOptions::default());
    }
}

/// The library that reads USD does not end on names that close a brace before they open one.
#[test]
fn names_with_odd_braces_are_refused() {
    let text = std::fs::read_to_string(data("room.usda")).unwrap();
    let folder = Folder::new(&[]);
    for (name, other) in [
        ("Looks/Checked/Surface", "Looks/C}ecked/Surface"),
        ("def Scope \"Looks\"", "def Scope \"L}oks\""),
        ("def Scope \"Looks\"", "def \"L}oks\""),
        ("defaultPrim = \"World\"", "defaultPrim = \"Wor}d\""),
    ] {
        assert!(text.contains(name), "{name}");
        folder.write("room.usda", text.replace(name, other).as_bytes());
        let error = load(&folder.path("room.usda"), &LoadOptions::default()).unwrap_err().to_string();
        assert!(error.contains("closes a brace that is not open"), "{other}: {error}");
    }
    // Other texts may have them.
    let text = text.replace("def Scope \"Looks\"", "def Scope \"Looks\" (doc = \"}\")");
    folder.write("room.usda", text.as_bytes());
    load(&folder.path("room.usda"), &LoadOptions::default()).unwrap();
}

#[test]
fn fuzz_text() {
    let text = std::fs::read(data("room.usda")).unwrap();
    fuzz_files("room.usda", text);
}

#[test]
fn fuzz_binary() {
    fuzz_files("room.usdc", std::fs::read(data("room.usdc")).unwrap());
    fuzz_files("room.usdz", std::fs::read(data("room.usdz")).unwrap());
}

fn fuzz_files(name: &str, bytes: Vec<u8>) {
    fuzz(mangled(bytes), |bytes| {
        let folder = Folder::new(&[]);
        folder.write(name, &bytes);
        load(&folder.path(name), &LoadOptions::default()).map_or(Ok(()), |scene| check(&scene))
    });
}

#[test]
fn round_shapes_have_their_measures() {
    for (prim, size) in [
        ("Cube \"S\" { double size = 4 }", [2.0, 2.0, 2.0]),
        ("Cylinder \"S\" { double radius = 2\ndouble height = 6\nuniform token axis = \"X\" }", [3.0, 2.0, 2.0]),
        ("Cone \"S\" { double radius = 2\ndouble height = 6 }", [2.0, 2.0, 3.0]),
        ("Capsule \"S\" { double radius = 2\ndouble height = 6\nuniform token axis = \"Y\" }", [2.0, 5.0, 2.0]),
        ("Plane \"S\" { double width = 4\ndouble length = 6\nuniform token axis = \"X\" }", [0.0, 3.0, 2.0]),
    ] {
        let scene = stage(&format!("def {prim}")).unwrap();
        let (low, high) = scene.bounds().unwrap();
        assert!((high - glam::Vec3::from(size)).length() < 1.0e-4, "{prim}: {high}");
        assert!((low + high).length() < 1.0e-4, "{prim}: {low} to {high}");
        let outward = scene.primitives.iter().all(|primitive| {
            let sign = if primitive.flip_normal { -1.0 } else { 1.0 };
            let center = primitive.origin + (primitive.edge_u + primitive.edge_v) / 3.0;
            sign * primitive.edge_u.cross(primitive.edge_v).dot(center) >= -1.0e-6
        });
        assert!(outward, "{prim}");
        assert!(scene.primitives.iter().all(|primitive| primitive.shape != PrimitiveShape::Sphere));
    }
}
