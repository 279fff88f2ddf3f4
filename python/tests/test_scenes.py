"""Scenes from dictionaries are those of XML."""

import numpy as np
import pytest
from xml_scenes import as_dictionary

import lodestar
from conftest import room

SCENES = [
    "cornell-box/scene.xml",
    "cornell-box-hard/scene.xml",
    "door-ajar/scene.xml",
    "furnace/scene.xml",
    "furnace/mesh.xml",
    *(f"lights/scene.xml {light}" for light in ("spot", "textured", "envmap", "point", "disk", "directional", "mesh")),
]


@pytest.mark.parametrize("name", SCENES)
def test_a_dictionary_is_the_scene_of_its_xml(name, scenes):
    name, *light = name.split()
    file, defines = scenes / name, {"light": light[0]} if light else {}
    ours, theirs = lodestar.load(as_dictionary(file, **defines)), lodestar.load(file, **defines)
    assert ours.fingerprint == theirs.fingerprint
    assert (ours.width, ours.height) == (theirs.width, theirs.height)


@pytest.mark.parametrize("name", ["cornell-box/scene.xml", "door-ajar/scene.xml"])
def test_its_picture_has_the_same_bits(name, scenes):
    settings = {"width": 24, "spp": 4}
    ours = lodestar.render(as_dictionary(scenes / name), **settings)
    theirs = lodestar.render(scenes / name, **settings)
    assert ours.radiance.tobytes() == theirs.radiance.tobytes() and ours.radiance.mean() > 0


def test_other_dictionaries_are_other_scenes(room_scene):
    room_scene["ball"]["radius"] = 0.51
    assert lodestar.load(room_scene).fingerprint != lodestar.load(room()).fingerprint


def mesh_scene(tmp_path, as_file, **more):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.1], [0, 1, 0.3]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    scene = room()
    if as_file:
        lines = ["ply", "format ascii 1.0", "element vertex 4"]
        lines += [f"property float {name}" for name in ("x", "y", "z", "u", "v")]
        lines += ["element face 2", "property list uchar int vertex_indices", "end_header"]
        lines += [" ".join(map(repr, map(float, [*row, *uv]))) for row, uv in zip(vertices, uvs)]
        lines += [" ".join(map(str, [3, *face])) for face in faces]
        (tmp_path / "mesh.ply").write_text("\n".join(lines) + "\n")
        mesh = {"type": "ply", "filename": tmp_path / "mesh.ply"}
    else:
        mesh = {"type": "mesh", "vertices": vertices, "faces": faces, "uvs": uvs}
    scene["mesh"] = {**mesh, "bsdf": {"type": "ref", "id": "gray"}, **more}
    return scene


@pytest.mark.parametrize("kind, word", [
    ("?", "booleans"), ("c8", "complex numbers"), ("M8[s]", "dates or times"), ("U4", "texts"), ("S4", "texts"), ("O", "objects"),
])
def test_arrays_that_are_no_numbers_are_refused(tmp_path, kind, word):
    for name in ("vertices", "faces", "uvs"):
        scene = mesh_scene(tmp_path, False)
        array = np.asarray(scene["mesh"][name]).astype("i8").astype(kind)
        with pytest.raises(lodestar.Error, match=f"scene.mesh.{name}: .*its values are {word}, not numbers"):
            lodestar.load({**scene, "mesh": {**scene["mesh"], name: array}})
    pixels = np.ones((2, 2, 3)).astype("i8").astype(kind)
    with pytest.raises(TypeError, match=word):
        lodestar.compare(pixels, np.ones((2, 2, 3)))


def test_whole_numbers_are_taken_where_they_are_exact(tmp_path):
    scene = mesh_scene(tmp_path, False)
    whole = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    prints = {lodestar.load({**scene, "mesh": {**scene["mesh"], "vertices": whole.astype(kind)}}).fingerprint
              for kind in ("i1", "u8", "i8", "f2", "f4", "f8")}
    assert len(prints) == 1
    with pytest.raises(lodestar.Error, match="above 2\\^53"):
        lodestar.load({**scene, "mesh": {**scene["mesh"], "vertices": whole + 2**60}})


@pytest.mark.parametrize("more", [{}, {"face_normals": True}, {"flip_normals": True}])
def test_a_mesh_of_arrays_is_that_of_its_file(tmp_path, more):
    more = {"to_world": lodestar.ScalarTransform4f().translate([0.1, 0.2, 0.3]).scale(1.5), **more}
    ours, theirs = (lodestar.load(mesh_scene(tmp_path, as_file, **more)) for as_file in (False, True))
    assert ours.fingerprint == theirs.fingerprint
    assert ours.summary["triangles"] == 2


def test_transforms_come_in_four_forms(room_scene):
    class OfMitsuba:
        matrix = None

    expected = lodestar.load(room_scene).fingerprint
    transform = room_scene["ball"]["to_world"] = lodestar.ScalarTransform4f().translate([0.5, 0.25, -0.125])
    moved = lodestar.load(room_scene).fingerprint
    assert moved != expected
    other = OfMitsuba()
    other.matrix = transform.matrix
    for value in (transform.matrix, transform.matrix.tolist(), other, transform.matrix.astype(np.float32)):
        room_scene["ball"]["to_world"] = value
        assert lodestar.load(room_scene).fingerprint == moved


def test_transforms_follow_their_formulas():
    transform = lodestar.ScalarTransform4f
    both = transform().translate([1, 2, 3]) @ transform().scale([2, 3, 4])
    assert np.array_equal(both.matrix, [[2, 0, 0, 1], [0, 3, 0, 2], [0, 0, 4, 3], [0, 0, 0, 1]])
    assert np.array_equal(transform().translate([1, 2, 3]).scale([2, 3, 4]).matrix, both.matrix)
    turned = transform().rotate([0, 0, 1], 90).matrix @ [1, 0, 0, 1]
    assert np.allclose(turned, [0, 1, 0, 1])
    camera = transform().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]).matrix
    assert np.allclose(camera @ [0, 0, 1, 0], [0, 0, -1, 0]) and np.allclose(camera @ [0, 0, 0, 1], [0, 0, 5, 1])
    assert np.array_equal(transform().matrix, np.eye(4))


def test_defaults_are_replaced_by_name(scenes):
    assert lodestar.load(scenes / "cornell-box", resx=40, resy=30).width == 40
    with pytest.raises(lodestar.Error, match="-D nothing"):
        lodestar.load(scenes / "cornell-box", nothing=1)


WRONG = [
    ({"type": "path"}, "scene: its `type` must be `scene`, not `path`"),
    ({}, "scene: it needs the entry `type`"),
    ({"type": "scene", "a": {}}, "scene.a: it needs the entry `type`"),
    ({"type": "scene", "a": {"type": "blob"}}, "scene.a: there is no plugin `blob`"),
    ({"type": "scene", "a": {"type": "sdfgrid"}}, "scene.a: shape plugin `sdfgrid` is not supported"),
    ({"type": "scene", "a": {"type": "sphere", "radius": "x"}}, "scene.a.radius: the parameter `radius` should be"),
    ({"type": "scene", "a": {"type": "sphere", "radius": float("nan")}}, "scene.a.radius: `NaN` is not a finite"),
    ({"type": "scene", "a": {"type": "sphere", "center": [1, 2]}}, "scene.a.center: .*should be three numbers"),
    ({"type": "scene", "a": {"type": "sphere", "to_world": np.eye(3, 4)}}, r"scene.a.to_world: .*shape \[3, 4\]"),
    ({"type": "scene", "a": {"type": "sphere", "bsdf": {"type": "ref", "id": "b"}}}, "nothing in the scene has the id `b`"),
    ({"type": "scene", "a": {"type": "obj", "filename": "no.obj"}}, "scene.a.filename: the mesh file `no.obj`"),
    ({"type": "scene", "a.b": 1}, "the key `a.b` has a dot"),
    ({"type": "scene", 3: 1}, "scene: the key 3 is no string"),
    ({"type": "scene", "a": {"type": "sphere", "radius": None}}, "scene.a.radius: a value of the type `NoneType`"),
    ({"type": "scene", "a": {"type": "sphere", "radius": object()}}, "scene.a.radius: a value of the type `object`"),
    ({"type": "scene", "a": {"type": "mesh", "faces": [[0, 1, 2]]}}, "scene.a: a `mesh` needs its array `vertices`"),
    (
        {"type": "scene", "a": {"type": "mesh", "vertices": np.zeros((3, 3)), "faces": [[0, 1, 3]]}},
        "scene.a: row 0 of its `faces` has 3, but there are 3 vertices",
    ),
    (
        {"type": "scene", "a": {"type": "mesh", "vertices": np.full((3, 3), np.inf), "faces": [[0, 1, 2]]}},
        "scene.a: row 0 of its `vertices` has a number that is not finite",
    ),
]


@pytest.mark.parametrize("at", range(len(WRONG)))
def test_faults_are_named_by_their_keys(at):
    scene, words = WRONG[at]
    with pytest.raises(lodestar.Error, match=words):
        lodestar.load(scene)


def test_a_dictionary_that_contains_itself_is_refused():
    scene = {"type": "scene"}
    scene["again"] = scene
    with pytest.raises(lodestar.Error, match="nested more than"):
        lodestar.load(scene)


def test_unknown_parameters_are_warnings(room_scene):
    room_scene["ball"]["colour"] = 3
    with pytest.warns(UserWarning, match="scene.ball.colour: the parameter `colour` of shape `sphere` is unknown"):
        scene = lodestar.load(room_scene)
    assert len(scene.warnings) == 1


def two_cameras(folder):
    sensors = "".join(
        f"""<sensor type="perspective" id="{name}"><transform name="to_world"><lookat origin="{origin}" target="0,0,0"
        up="0,1,0"/></transform><film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="12"/></film>
        </sensor>"""
        for name, origin in (("near", "0,0,4"), ("far", "0,0,20"))
    )
    path = folder / "two.xml"
    path.write_text(f'<scene version="3.0.0">{sensors}<shape type="sphere"/></scene>')
    return path


def test_cameras_and_environments_are_chosen(tmp_path):
    path = two_cameras(tmp_path)
    light = {"environment": "constant", "spp": 4}
    hits = {camera: lodestar.render(path, camera=camera, **light).hits.sum() for camera in (None, "near", "far", 0, 1, "fit")}
    assert hits[None] == hits["near"] == hits[0] > hits["far"] == hits[1] > 0, hits
    assert hits["fit"] > hits["far"], hits
    # A scene that is read once has the same bits as one that a render reads.
    ours = lodestar.render(lodestar.load(path, camera="far", environment="constant"), spp=4)
    theirs = lodestar.render(path, camera="far", **light)
    assert ours.radiance.tobytes() == theirs.radiance.tobytes() and ours.radiance.mean() > 0
    # Without the environment there is no light.
    with pytest.warns(UserWarning):
        assert lodestar.render(path, spp=1).radiance.max() == 0


def test_a_converted_scene_is_the_same(tmp_path):
    path = two_cameras(tmp_path)
    lodestar.convert(path, tmp_path / "new.xml")
    assert lodestar.load(tmp_path / "new.xml").fingerprint == lodestar.load(path).fingerprint
    with pytest.raises(lodestar.Error, match="overwrite"):
        lodestar.convert(path, tmp_path / "new.xml")
    lodestar.convert(path, tmp_path / "new.xml", overwrite=True)
    assert lodestar.load(path).summary["cameras"] == ["near", "far"]


def test_cameras_and_environments_belong_to_files(tmp_path):
    path = two_cameras(tmp_path)
    scene = lodestar.load(path, environment="constant")
    for call in (
        lambda: lodestar.render(scene, camera="far"),
        lambda: lodestar.render(room(), environment="constant"),
        lambda: lodestar.load(room(), camera=1),
        lambda: lodestar.load(path, camera="third"),
        lambda: lodestar.load(path, environment=tmp_path / "gone.exr"),
    ):
        with pytest.raises(lodestar.Error, match="camera|environment|gone"):
            call()
    with pytest.raises(TypeError, match="camera"):
        lodestar.load(path, camera=1.5)
