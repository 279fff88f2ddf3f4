//! Reader of USD: rules of inheritance, materials, lights and cameras, with the values that Pixar's library gives.

use lodestar::scene::{LoadOptions, MaterialKind, Projection, Scene, load};

use crate::Folder;
use crate::usd::{square, stage, stage_with};

/// A material that shines with that strength, so that a scene shows which material a shape has.
fn glow(name: &str, strength: u32) -> String {
    format!(
        "def Material \"{name}\" {{ token outputs:surface.connect = </{name}/S.outputs:surface>\ndef Shader \"S\" {{\n\
         uniform token info:id = \"UsdPreviewSurface\"\ncolor3f inputs:emissiveColor = ({strength}, 0, 0)\n\
         token outputs:surface }} }}\n"
    )
}

/// Four materials, of the strengths 1 to 4.
fn glows() -> String {
    ["A", "B", "C", "D"].iter().zip(1..).map(|(name, strength)| glow(name, strength)).collect()
}

/// Strength of each primitive; 0 for one that does not shine.
fn strengths(scene: &Scene) -> Vec<f32> {
    let emitters = scene.primitives.iter().map(|primitive| primitive.emitter);
    emitters.map(|emitter| emitter.map_or(0.0, |index| scene.emitters[index as usize].radiance.value.x)).collect()
}

/// A material of `UsdPreviewSurface` with these inputs, and nodes beside it.
fn preview(inputs: &str, nodes: &str) -> String {
    format!(
        "def Material \"P\" {{ token outputs:surface.connect = </P/S.outputs:surface>\ndef Shader \"S\" {{\n\
         uniform token info:id = \"UsdPreviewSurface\"\n{inputs}\ntoken outputs:surface }}\n{nodes} }}\n"
    )
}

const BOUND: &str = "rel material:binding = </P>";
const UVS: &str = "texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = \"vertex\")";

/// A square with the material of those inputs and nodes.
fn painted(inputs: &str, nodes: &str) -> Scene {
    let scene = stage(&format!("{}{}", square("M", &format!("{BOUND}\n{UVS}")), preview(inputs, nodes)));
    scene.unwrap()
}

/// Material of a primitive, in words.
fn surface(scene: &Scene, primitive: usize) -> String {
    let material = &scene.materials[scene.primitives[primitive].material as usize];
    match &material.kind {
        MaterialKind::Surface(surface) => format!("{surface:?}"),
        other => format!("{other:?}"),
    }
}

fn is_warned(scene: &Scene, part: &str) -> bool {
    scene.warnings.iter().any(|warning| warning.contains(part))
}

/// The right material is that of `UsdShadeMaterialBindingAPI::ComputeBoundMaterial("full")`.
#[test]
fn bindings_have_their_precedence() {
    let strong = "(bindMaterialAs = \"strongerThanDescendants\")";
    let direct =
        |purpose: &str, material: &str, how: &str| format!("rel material:binding{purpose} = </{material}> {how}\n");
    let of_all = |name: &str, purpose: &str, material: &str, how: &str| {
        format!(
            "rel collection:{name}:includes = [</R>]\n\
             rel material:binding:collection:{purpose}{name} = [</R.collection:{name}>, </{material}>] {how}\n"
        )
    };
    for (name, root, middle, leaf, right) in [
        ("a parent's collection is weaker", of_all("a", "", "A", ""), String::new(), direct("", "B", ""), 2.0),
        (
            "a prim's own collection is stronger",
            of_all("a", "", "A", "") + &direct("", "B", ""),
            String::new(),
            String::new(),
            1.0,
        ),
        ("a strong collection", of_all("a", "", "A", strong), String::new(), direct("", "B", ""), 1.0),
        ("the highest strong one", direct("", "A", strong), direct("", "B", strong), direct("", "C", ""), 1.0),
        ("a strong one below a weak one", direct("", "A", ""), direct("", "B", strong), String::new(), 2.0),
        ("the purpose `full` goes first", direct(":full", "A", ""), String::new(), direct("", "B", ""), 1.0),
        ("so does its collection", of_all("a", "full:", "A", ""), String::new(), direct("", "B", ""), 1.0),
        ("a strong one of no purpose is weaker", direct("", "A", strong), String::new(), direct(":full", "C", ""), 3.0),
        ("the purpose `preview` is none", direct("", "A", ""), String::new(), direct(":preview", "B", ""), 1.0),
        ("nor is its collection", of_all("a", "preview:", "A", ""), direct("", "B", ""), String::new(), 2.0),
        (
            "the first collection",
            of_all("b", "", "B", "") + &of_all("a", "", "A", ""),
            String::new(),
            String::new(),
            1.0,
        ),
        (
            "the first, not the strong one",
            of_all("b", "", "B", strong) + &of_all("a", "", "A", ""),
            String::new(),
            String::new(),
            1.0,
        ),
        (
            "the strong collection",
            of_all("b", "", "B", strong) + &of_all("a", "", "A", ""),
            direct("", "C", ""),
            String::new(),
            2.0,
        ),
        (
            "a collection goes before a strong one of its prim",
            of_all("a", "", "A", "") + &direct("", "B", strong),
            String::new(),
            direct("", "C", ""),
            1.0,
        ),
    ] {
        let body =
            format!("def Xform \"R\" {{\n{root}def Xform \"X\" {{\n{middle}{} }} }}\n{}", square("M", &leaf), glows());
        assert_eq!(strengths(&stage(&body).unwrap()), [right; 2], "{name}");
    }
}

/// Instances of one prototype show the materials of their own collections and parents.
#[test]
fn instances_have_their_own_materials() {
    let class = format!("class Xform \"K\" {{ {} }}\n", square("M", ""));
    let copy =
        |name: &str, more: &str| format!("def Xform \"{name}\" (instanceable = true\ninherits = </K>) {{ {more} }}\n");
    let of_path = |name: &str, path: &str, material: &str| {
        format!(
            "rel collection:{name}:includes = [<{path}>]\n\
             rel material:binding:collection:{name} = [</R.collection:{name}>, </{material}>]\n"
        )
    };
    let collections = of_path("a", "/R/X", "A") + &of_path("b", "/R/Y", "B");
    let body = format!("{class}def Xform \"R\" {{ {collections}{}{} }}\n{}", copy("X", ""), copy("Y", ""), glows());
    assert_eq!(strengths(&stage(&body).unwrap()), [1.0, 1.0, 2.0, 2.0]);
    let [x, y] = ["A", "C"].map(|material| format!("rel material:binding = </{material}>"));
    let body = format!("{class}{}{}{}", copy("X", &x), copy("Y", &y), glows());
    assert_eq!(strengths(&stage(&body).unwrap()), [1.0, 1.0, 3.0, 3.0]);
}

/// The camera of each copy stands where the copy does, and so does what leaves out its parents' transforms.
#[test]
fn instances_have_their_own_cameras() {
    let place = |x: u32| {
        format!("double3 xformOp:translate = ({x}, 0, 0)\nuniform token[] xformOpOrder = [\"xformOp:translate\"]")
    };
    let copies = |inner: &str| {
        let copy = |name: &str, x: u32| {
            format!("def Xform \"{name}\" (instanceable = true\ninherits = </K>) {{ {} }}\n", place(x))
        };
        format!("class Xform \"K\" {{ {inner} {} }}\n{}{}", square("M", ""), copy("X", 5), copy("Y", 9))
    };
    let scene = stage(&copies("def Camera \"Eye\" {}")).unwrap();
    let eyes: Vec<f32> = scene.views.iter().flatten().map(|view| view.world_from_camera.w_axis.x).collect();
    assert_eq!(eyes, [5.0, 9.0]);
    let reset = "def Sphere \"S\" { uniform token[] xformOpOrder = [\"!resetXformStack!\"] }";
    let scene = stage_with("upAxis = \"Z\"", &copies(reset), &[]).unwrap();
    let balls = scene.primitives.iter().filter(|primitive| primitive.origin.length() < 1.0e-6);
    assert!(balls.count() >= 2, "both spheres are in the middle of the stage");
}

/// A prototype has the materials of its own parents, and ids that are inactive are left out.
#[test]
fn prototypes_belong_to_their_parents() {
    let body = format!(
        "def Xform \"Q\" {{ rel material:binding = </A>\n{} }}\n\
         def PointInstancer \"I\" (inactiveIds = [1]) {{ rel material:binding = </B>\nrel prototypes = [</Q/M>]\n\
         int[] protoIndices = [0, 0]\npoint3f[] positions = [(0, 0, 0), (5, 0, 0)] }}\n{}",
        square("M", ""),
        glows()
    );
    // The prototype is also a prim of the stage.
    assert_eq!(strengths(&stage(&body).unwrap()), [1.0; 4]);
}

#[test]
fn primvars_are_inherited() {
    let parent = |more: &str, child: &str| format!("def Xform \"P\" {{ {more}\n{} }}", square("M", child));
    let red = "color3f[] primvars:displayColor = [(1, 0, 0)]";
    for (more, child, right) in [
        (red, "", "Vec3(1.0, 0.0, 0.0)"),
        (red, "color3f[] primvars:displayColor = [(0, 1, 0)]", "Vec3(0.0, 1.0, 0.0)"),
        // Only constant ones are inherited.
        ("color3f[] primvars:displayColor = [(1, 0, 0)] (interpolation = \"vertex\")", "", "Vec3(0.18, 0.18, 0.18)"),
    ] {
        let found = surface(&stage(&parent(more, child)).unwrap(), 0);
        assert!(found.contains(right), "{more} {child}: {found}");
    }
    let copies: String = [("X", "1, 0, 0"), ("Y", "0, 1, 0")]
        .map(|(name, color)| {
            format!(
                "def Xform \"{name}\" {{ color3f[] primvars:displayColor = [({color})]\n\
                 def Xform \"I\" (instanceable = true\ninherits = </K>) {{}} }}\n"
            )
        })
        .concat();
    let scene = stage(&format!("class Xform \"K\" {{ {} }}\n{copies}", square("M", ""))).unwrap();
    assert!(surface(&scene, 0) != surface(&scene, 2));
    let nodes = image_node("", "");
    let body = format!(
        "{}{}",
        square("M", BOUND),
        preview("color3f inputs:diffuseColor.connect = </P/T.outputs:rgb>", &nodes)
    );
    let scene = stage_of_image(&body);
    assert!(is_warned(&scene, "it lacks the primvar `st`"), "{:?}", scene.warnings);
    assert!(scene.primitives.iter().all(|primitive| primitive.uvs == [glam::Vec2::Y; 3]));
}

/// A node that reads the image, with more of its inputs, and nodes beside it.
fn image_node(inputs: &str, beside: &str) -> String {
    format!(
        "def Shader \"T\" {{ uniform token info:id = \"UsdUVTexture\"\nasset inputs:file = @image.png@\n{inputs}\n\
         float3 outputs:rgb\nfloat outputs:r\nfloat outputs:a }}\n{beside}"
    )
}

/// A stage beside an image of two colors.
fn stage_of_image(body: &str) -> Scene {
    let gray = || ::image::GrayImage::from_pixel(2, 2, ::image::Luma([128]));
    let folder = Folder::new(&[("stage.usda", &format!("#usda 1.0\n{body}"))]);
    ::image::RgbImage::from_pixel(2, 2, ::image::Rgb([128, 128, 255])).save(folder.path("image.png")).unwrap();
    gray().save(folder.path("gray.png")).unwrap();
    load(&folder.path("stage.usda"), &LoadOptions::default()).unwrap()
}

/// Mean of the texture of a material with that input and those nodes.
fn mean(inputs: &str, nodes: &str) -> glam::Vec3 {
    let scene = stage_of_image(&format!("{}{}", square("M", &format!("{BOUND}\n{UVS}")), preview(inputs, nodes)));
    scene.textures[0].mean(&scene.images)
}

#[test]
fn textures_have_their_numbers() {
    let color = "color3f inputs:diffuseColor.connect = </P/T.outputs:rgb>";
    let near = |found: glam::Vec3, right: f32| assert!((found.x - right).abs() < 0.008, "{found} is not {right}");
    let (linear, encoded) = (128.0 / 255.0, 0.215_86);
    near(mean(color, &image_node("", "")), encoded);
    near(mean(color, &image_node("token inputs:sourceColorSpace = \"raw\"", "")), linear);
    // Two channels and one are numbers.
    near(mean(color, &image_node("", "").replace("image.png", "gray.png")), linear);
    // Inputs along connections of the material.
    let connected =
        "token inputs:sourceColorSpace.connect = </P/N.inputs:space>\nfloat4 inputs:bias.connect = </P/N.inputs:bias>";
    let holder = "def NodeGraph \"N\" { token inputs:space = \"raw\"\nfloat4 inputs:bias = (0.25, 0, 0, 0) }";
    near(mean(color, &image_node(connected, holder)), linear + 0.25);
    // A transform by a connection: twice as many tiles, moved.
    let transform = "def Shader \"F\" { uniform token info:id = \"UsdTransform2d\"\nfloat2 inputs:in = (0, 0)\n\
                     float2 inputs:scale.connect = </P/N.inputs:size>\nfloat2 inputs:translation = (0.5, 0.25)\nfloat2 outputs:result }\n\
                     def NodeGraph \"N\" { float2 inputs:size = (2, 3) }";
    let nodes = image_node("float2 inputs:st.connect = </P/F.outputs:result>", transform);
    let scene = stage_of_image(&format!("{}{}", square("M", &format!("{BOUND}\n{UVS}")), preview(color, &nodes)));
    // v points down: v' = 1 - (3 (1 - v) + 0.25).
    let at = |u: f32, v: f32| (scene.textures[0].to_uv * glam::Vec3::new(u, v, 1.0)).truncate();
    assert!(at(0.0, 1.0).abs_diff_eq(glam::Vec2::new(0.5, 0.75), 1.0e-5), "{}", at(0.0, 1.0));
    assert!(at(1.0, 0.0).abs_diff_eq(glam::Vec2::new(2.5, -2.25), 1.0e-5), "{}", at(1.0, 0.0));
}

#[test]
fn surfaces_have_their_parts() {
    let normal = "normal3f inputs:normal.connect = </P/T.outputs:rgb>";
    let usual = "float4 inputs:scale = (2, 2, 2, 1)\nfloat4 inputs:bias = (-1, -1, -1, 0)\ntoken inputs:sourceColorSpace = \"raw\"";
    let nodes = image_node(usual, "");
    let scene = stage_of_image(&format!("{}{}", square("M", &format!("{BOUND}\n{UVS}")), preview(normal, &nodes)));
    assert!(surface(&scene, 0).to_lowercase().contains("normal"), "{}", surface(&scene, 0));
    let workflow = "int inputs:useSpecularWorkflow = 1\ncolor3f inputs:diffuseColor = (0, 0, 0)\ncolor3f inputs:specularColor = (0.5, 0.25, 0.75)";
    let found = surface(&painted(workflow, ""), 0);
    assert!(found.contains("0.5, 0.25, 0.75"), "{found}");
    for (opacity, threshold, holds) in [(0.4, 0.5, true), (0.6, 0.5, false), (0.6, 0.0, true)] {
        let inputs = format!("float inputs:opacity = {opacity}\nfloat inputs:opacityThreshold = {threshold}");
        let scene = painted(&inputs, "");
        let plain = painted("", "");
        assert_eq!(surface(&scene, 0) != surface(&plain, 0), holds, "{inputs}");
    }
}

#[test]
fn cones_and_mesh_lights_follow_their_schemas() {
    let emitted = |kind: &str, schema: &str, more: &str| {
        let light = format!("def {kind} \"L\" (prepend apiSchemas = [{schema}]) {{ {more} }}");
        let scene = stage(&format!("{}{light}", square("M", ""))).unwrap();
        (format!("{:?}", scene.emitters[0]), scene)
    };
    let (open, _) = emitted("RectLight", "", "");
    let (hemisphere, _) = emitted("RectLight", "\"ShapingAPI\"", "");
    let (given, _) = emitted("RectLight", "\"ShapingAPI\"", "float inputs:shaping:cone:angle = 90");
    let (narrow, _) = emitted("RectLight", "\"ShapingAPI\"", "float inputs:shaping:cone:angle = 0");
    let (all, _) = emitted("RectLight", "\"ShapingAPI\"", "float inputs:shaping:cone:angle = 180");
    assert!(hemisphere == given && narrow != open && all == open, "{open} {hemisphere} {given} {narrow} {all}");
    let (tube, scene) = emitted("CylinderLight", "\"ShapingAPI\"", "");
    assert!(tube == emitted("CylinderLight", "", "").0 && is_warned(&scene, "a cylinder shines to all sides"));
    let lit = square("M", "").replacen("\"M\"", "\"M\" (prepend apiSchemas = [\"MeshLightAPI\"])", 1);
    assert_eq!(strengths(&stage(&lit).unwrap()), [1.0; 2]);
}

#[test]
fn domes_turn_with_the_stage() {
    let dome = |metadata: &str, kind: &str, more: &str| {
        let folder = Folder::new(&[]);
        let sky = format!("def {kind} \"L\" {{ asset inputs:texture:file = @image.png@\n{more} }}");
        folder.write("stage.usda", format!("#usda 1.0\n({metadata})\n{}{sky}", square("M", "")).as_bytes());
        ::image::RgbImage::from_pixel(4, 4, ::image::Rgb([128, 128, 255])).save(folder.path("image.png")).unwrap();
        let scene = load(&folder.path("stage.usda"), &LoadOptions::default()).unwrap();
        format!("{:?}", scene.environment.unwrap())
    };
    let upright = dome("", "DomeLight", "");
    // The pole of a `DomeLight` is +y of the stage, which lies where the axis is z; that of a `DomeLight_1` is the stage's axis.
    assert_ne!(dome("upAxis = \"Z\"", "DomeLight", ""), upright);
    assert_eq!(dome("upAxis = \"Y\"", "DomeLight_1", ""), dome("upAxis = \"Y\"", "DomeLight", ""));
    assert_ne!(dome("upAxis = \"Z\"", "DomeLight_1", ""), dome("upAxis = \"Z\"", "DomeLight", ""));
}

#[test]
fn cameras_have_their_projections() {
    let camera = |more: &str| stage(&format!("{}def Camera \"C\" {{ {more} }}", square("M", ""))).unwrap();
    let lens = camera(
        "float fStop = 2\nfloat focusDistance = 7\nfloat focalLength = 40\nfloat horizontalAperture = 20\n\
         float verticalAperture = 10\nfloat horizontalApertureOffset = 2\nfloat verticalApertureOffset = 1",
    );
    assert!(matches!(lens.camera.projection, Projection::ThinLens { aperture_radius, focus_distance }
        if (aperture_radius - 1.0).abs() < 1.0e-6 && focus_distance == 7.0));
    assert!(lens.camera.principal_point.abs_diff_eq(glam::Vec2::new(0.1, -0.1), 1.0e-6), "{:?}", lens.camera);
    assert!(!is_warned(&lens, "aperture offsets"));
    let flat =
        camera("token projection = \"orthographic\"\nfloat horizontalAperture = 20\nfloat verticalAperture = 10");
    assert!(flat.camera.projection == Projection::Orthographic);
    assert!((flat.camera.world_from_camera.x_axis.length() - 1.0).abs() < 1.0e-6);
    assert!(is_warned(&camera("float exposure = 1"), "its exposure is ignored"));
}

#[test]
fn curves_are_tubes() {
    let body = "def BasisCurves \"C\" { uniform token type = \"linear\"\npoint3f[] points = [(0, 0, 0), (4, 0, 0)]\n\
                int[] curveVertexCounts = [2]\nfloat[] widths = [1] (interpolation = \"constant\") }";
    let (low, high) = stage(body).unwrap().bounds().unwrap();
    assert!(
        low.abs_diff_eq(glam::Vec3::new(0.0, -0.5, -0.5), 0.05)
            && high.abs_diff_eq(glam::Vec3::new(4.0, 0.5, 0.5), 0.05)
    );
}

#[test]
fn sublayers_and_variants_are_composed() {
    let base = "#usda 1.0\ndef Sphere \"S\" { double radius = 2 }\ndef Xform \"V\" (variants = { string size = \"big\" }\n\
                prepend variantSets = \"size\") { variantSet \"size\" = { \"big\" { def Sphere \"B\" { double radius = 8 } }\n\
                \"small\" { def Sphere \"B\" { double radius = 1 } } } }";
    let sizes = |root: &str| {
        let folder = Folder::new(&[("base.usda", base), ("stage.usda", root)]);
        let scene = load(&folder.path("stage.usda"), &LoadOptions::default()).unwrap();
        scene.primitives.iter().map(|primitive| primitive.edge_u.length()).collect::<Vec<_>>()
    };
    let layered = "#usda 1.0\n(subLayers = [@./base.usda@])\n";
    assert_eq!(sizes(layered), [2.0, 8.0]);
    let over = format!(
        "{layered}over \"S\" {{ double radius = 3 }}\nover \"V\" (variants = {{ string size = \"small\" }}) {{}}"
    );
    assert_eq!(sizes(&over), [3.0, 1.0]);
}

/// An archive whose files lie on one another could be read as thousands of times its size.
#[test]
fn archives_share_no_bytes() {
    let bytes = std::fs::read(crate::usd::data("room.usdz")).unwrap();
    let entries: Vec<usize> = (0..bytes.len() - 4).filter(|&at| bytes[at..].starts_with(b"PK\x01\x02")).collect();
    assert!(entries.len() >= 2);
    let mut twice = bytes.clone();
    // The second entry names the place of the first.
    let place: [u8; 8] = [&bytes[entries[0] + 20..entries[0] + 24], &bytes[entries[0] + 42..entries[0] + 46]]
        .concat()
        .try_into()
        .unwrap();
    twice[entries[1] + 24..entries[1] + 28].copy_from_slice(&place[..4]);
    twice[entries[1] + 42..entries[1] + 46].copy_from_slice(&place[4..]);
    let folder = Folder::new(&[]);
    folder.write("room.usdz", &twice);
    let error = load(&folder.path("room.usdz"), &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("two files in it share bytes"), "{error}");
}

#[test]
fn variants_of_gltf_are_refused_by_their_option() {
    let error = stage_with("", &square("M", ""), &[("variant", "red")]).unwrap_err();
    assert!(error.contains("--variant, or -D variant: a USD file has only the value `time`"), "{error}");
}

#[test]
fn weights_and_vertex_colors_stay_in_range() {
    let colors =
        "color3f[] primvars:displayColor = [(4, 0, 0), (1, 0, 0), (1, 0, 0), (1, 0, 0)] (interpolation = \"vertex\")";
    let standard = |weight: &str| {
        format!(
            "def Material \"P\" {{ token outputs:surface.connect = </P/S.outputs:surface>\ndef Shader \"S\" {{\n\
             uniform token info:id = \"ND_standard_surface_surfaceshader\"\ncolor3f inputs:base_color.connect = </P/R.outputs:result>\n\
             {weight}\nfloat inputs:specular = 0.5\ntoken outputs:surface }}\ndef Shader \"R\" {{\n\
             uniform token info:id = \"UsdPrimvarReader_float3\"\nstring inputs:varname = \"displayColor\"\ncolor3f outputs:result }} }}\n"
        )
    };
    let scene =
        |weight: &str| stage(&format!("{}{}", square("M", &format!("{BOUND}\n{colors}")), standard(weight))).unwrap();
    let (half, whole) = (scene("float inputs:base = 0.5"), scene("float inputs:base = 1"));
    assert!(surface(&half, 0) != surface(&whole, 0) || half.textures != whole.textures);
    assert!(is_warned(&half, "its `specular` is ignored"));
}
