//! Whatever stands in the files: a scene or an error, never a panic.

use proptest::prelude::*;

use super::Folder;

const SCENE: &str = r#"<scene version="3.0.0">
<default name="w" value="16"/>
<integrator type="path"><integer name="max_depth" value="5"/></integrator>
<sensor type="perspective"><float name="fov" value="40"/>
<transform name="to_world"><lookat origin="0, 0, -4" target="0, 0, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="$w"/><rfilter type="box"/></film></sensor>
<bsdf type="twosided" id="a"><bsdf type="diffuse"><rgb name="reflectance" value="0.1, 0.2, 0.3"/></bsdf></bsdf>
<shape type="obj"><string name="filename" value="mesh.obj"/><ref id="a"/></shape>
<shape type="sphere"><point name="center" x="1" y="2" z="3"/><float name="radius" value="2"/></shape>
<shape type="cube"><transform name="to_world"><scale x="2"/><rotate y="1" angle="30"/></transform>
<emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>
</scene>"#;

const MESH: &str = "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1.5\nvt 0 0\nvt 1 0.5\nvn 0 0 1\n\
                    f 1/1/1 2/2/1 3/1/1\nf -3/1/1 -2//1 4/1/1 1/1/1\n";

/// A cut, then bytes overwritten: with anything, or with what has a meaning in the format.
fn mangled(text: &'static str) -> impl Strategy<Value = Vec<u8>> {
    let byte = prop_oneof![any::<u8>(), prop::sample::select(&b"-0123456789.e/$<>\"' \nfvn"[..])];
    let edits = prop::collection::vec((0..text.len(), byte), 0..6);
    (prop_oneof![Just(text.len()), 0..=text.len()], edits).prop_map(|(length, edits)| {
        let mut bytes = text.as_bytes().to_vec();
        edits.into_iter().for_each(|(at, byte)| bytes[at] = byte);
        bytes.truncate(length);
        bytes
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..Default::default() })]

    #[test]
    fn no_panic(scene in prop_oneof![Just(SCENE.as_bytes().to_vec()), mangled(SCENE)], mesh in mangled(MESH)) {
        let folder = Folder::new(&[]);
        folder.write("scene.xml", &scene);
        folder.write("mesh.obj", &mesh);
        if let Ok(scene) = folder.load(&[]) {
            for primitive in &scene.primitives {
                prop_assert!(primitive.bounds().0.is_finite() && primitive.bounds().1.is_finite());
                prop_assert!(primitive.normals.iter().flatten().all(|n| (n.length() - 1.0).abs() < 1e-3));
                prop_assert!((primitive.material as usize) < scene.materials.len());
            }
        }
    }
}

#[test]
fn the_unmangled_files_are_fine() {
    let scene = Folder::new(&[("scene.xml", SCENE), ("mesh.obj", MESH)]).load(&[]).unwrap();
    assert_eq!(scene.primitives.len(), 3 + 1 + 6);
}
