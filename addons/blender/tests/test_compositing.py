"""Passes for compositing beside Cycles: Cryptomattes, indices, positions, texture coordinates and mist."""

from __future__ import annotations

import json
import os
import re
import stat
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Optional

import bpy
import numpy as np
import pytest
import scenes
import support
import test_instances
from lodestar import compositing, engine, export, exr, inside, mattes, names, process

SWITCHES = [*compositing.PASSES, *compositing.MATTES]
KINDS = list(compositing.MATTES.values())
SAMPLES = 256
# Names that need care in ids, in XML and in JSON.
HARD = ['a#1', "#", 'say "cheese"', "Äpfel & <Birnen>", "日本語", "cash $x", "back\\slash", "tab\tand\nline"]


def switch_on(scene: Any, *switches: str) -> None:
    for name in switches or SWITCHES:
        setattr(scene.view_layers[0], name, True)


class Passes:
    """Passes of a picture in a file of Blender's."""

    def __init__(self, path: Path, layer: str = "ViewLayer") -> None:
        self.picture, self._layer = exr.read(path), layer
        header, _ = exr._header(path.read_bytes())
        self.facts = {name: value.decode() for name, value in header.items() if name.startswith("cryptomatte/")}

    def of(self, name: str, channels: str) -> np.ndarray:
        found = self.picture.layer([f"{self._layer}.{name}.{each}" for each in channels])
        assert found is not None, f"{name}: {sorted(self.picture.channels)}"
        return found

    def has(self, name: str) -> bool:
        return any(channel.startswith(f"{self._layer}.{name}") for channel in self.picture.channels)

    def manifest(self, kind: str) -> dict[str, int]:
        (key,) = (name for name, value in self.facts.items() if value == f"{self._layer}.{kind}")
        assert self.facts[key.replace("/name", "/hash")] == "MurmurHash3_32"
        assert self.facts[key.replace("/name", "/conversion")] == "uint32_to_float32"
        return {name: int(bits, 16) for name, bits in json.loads(self.facts[key.replace("/name", "/manifest")]).items()}

    def shares(self, kind: str, layers: int = 3) -> dict[int, np.ndarray]:
        """Share of each pixel by the identifiers of things."""
        found: dict[int, np.ndarray] = {}
        for at in range(layers):
            numbers = self.of(f"{kind}{at:02}", "rgba")
            for column in (0, 2):
                ids, shares = np.ascontiguousarray(numbers[..., column]).view(np.uint32), numbers[..., column + 1]
                for each in np.unique(ids[shares > 0.0]):
                    found.setdefault(int(each), np.zeros(ids.shape))[ids == each] += shares[ids == each]
        return found

    def whole(self, kind: str = "CryptoObject") -> np.ndarray:
        """Identifier of the thing that fills a pixel; 0 where several things share it, or nothing is there."""
        numbers = self.of(f"{kind}00", "rgba")
        return np.where(numbers[..., 1] > 0.999, np.ascontiguousarray(numbers[..., 0]).view(np.uint32), 0)


def rendered(scene: Any, renderer: str, samples: int = SAMPLES) -> Passes:
    support.render(scene, renderer, samples, "compositing")
    return Passes(Path(scene.render.filepath))


def both(scene: Any, samples: int = 4) -> tuple[Passes, Passes]:
    """Passes of Lodestar and of Cycles."""
    return rendered(scene, "LODESTAR", samples), rendered(scene, "CYCLES")


def show() -> Any:
    """Objects that stand for themselves, parented ones, instances, two slots, and a surface without a material and without coordinates."""
    scene = test_instances.several_places()
    scene.objects["sheared"].parent.parent = scenes.add(scene, "rig", None)
    mesh = bpy.data.meshes.new("naked")
    mesh.from_pydata([(-1, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    scenes.add(scene, "naked", mesh, (0, 2.2, 0.7), (0.9, 0, 0))
    for at, each in enumerate(sorted(scene.objects, key=lambda each: each.name)):
        each.pass_index = at + 1
    for at, each in enumerate(sorted(bpy.data.materials, key=lambda each: each.name)):
        each.pass_index = 10 * (at + 1)
    switch_on(scene)
    return scene


@pytest.fixture(scope="module")
def shown() -> tuple[Passes, Passes]:
    return both(show())


@pytest.mark.parametrize("kind", KINDS)
def test_mattes_are_those_of_cycles(shown: tuple[Passes, Passes], kind: str) -> None:
    """Both show the same things, whose shares differ by noise at their edges."""
    ours, theirs = (each.shares(kind) for each in shown)
    assert ours.keys() == theirs.keys() and len(ours) > 5
    for each, share in theirs.items():
        difference = np.abs(ours[each] - share)
        print(f"{kind} {each:08x}: {share.sum():.1f} pixels, {ours[each].sum() - share.sum():+.2f}, largest difference {difference.max():.3f}")
        assert abs(ours[each].sum() - share.sum()) < 0.01 * share.sum() + 0.5
        assert difference.max() < 0.15


@pytest.mark.parametrize("kind", KINDS)
def test_names_have_cycles_numbers(shown: tuple[Passes, Passes], kind: str) -> None:
    ours, theirs = (each.manifest(kind) for each in shown)
    common = ours.keys() & theirs.keys()
    assert len(common) > 5 and {name: ours[name] for name in common} == {name: theirs[name] for name in common}
    # All that is in view has a name.
    assert set(shown[0].shares(kind)) <= set(ours.values())


@pytest.mark.parametrize("name", [compositing.OBJECT_INDEX, compositing.MATERIAL_INDEX])
def test_indices_are_those_of_cycles(shown: tuple[Passes, Passes], name: str) -> None:
    ours, theirs = shown
    inner = (ours.whole() == theirs.whole()) & (ours.whole() != 0)
    mine, other = (each.of(name, "X")[..., 0] for each in shown)
    assert (mine == other)[inner].all() and len(np.unique(mine[inner])) > 4
    # At edges, Cycles has that of one sample.
    assert (mine == other).mean() > 0.97
    assert (mine[ours.of("CryptoObject00", "rgba")[..., 1] == 0.0] == 0.0).all()


def inner_of(shown: tuple[Passes, Passes]) -> np.ndarray:
    """Pixels that one object fills in both pictures."""
    inner = (shown[0].whole() == shown[1].whole()) & (shown[0].whole() != 0)
    assert inner.mean() > 0.3
    return inner


def test_positions_are_those_of_cycles(shown: tuple[Passes, Passes]) -> None:
    """Cycles has the position of one sample in the middle of a pixel, and Lodestar the mean of all."""
    inner = inner_of(shown)
    difference = np.abs(shown[0].of("Position", "XYZ") - shown[1].of("Position", "XYZ"))[inner].max(axis=1)
    print(f"positions: median {np.median(difference):.2e}, mean {difference.mean():.2e}, largest {difference.max():.2e}")
    assert np.median(difference) < 3e-4 and difference.mean() < 1e-3
    ground = shown[0].whole() == mattes.identifier("ground")
    on_ground = np.abs(shown[0].of("Position", "XYZ") - shown[1].of("Position", "XYZ"))[ground & inner]
    # The ground is flat, so both are the same point but for perspective.
    assert np.quantile(on_ground, 0.99) < 1e-3 and on_ground.max() < 2e-3
    assert (shown[0].of("Position", "XYZ")[shown[0].of("CryptoObject00", "rgba")[..., 1] == 0.0] == 0.0).all()


def test_texture_coordinates_are_those_of_cycles(shown: tuple[Passes, Passes]) -> None:
    inner = inner_of(shown)
    ours, theirs = (each.of("UV", "UVA") for each in shown)
    assert np.array_equal(ours[..., 2][inner], theirs[..., 2][inner].round(3))
    difference = np.abs(ours - theirs)[inner].max(axis=1)
    print(f"coordinates: median {np.median(difference):.2e}, 90 % {np.quantile(difference, 0.9):.2e}")
    assert np.median(difference) < 1e-3 and np.quantile(difference, 0.9) < 0.02
    naked = shown[0].whole() == mattes.identifier("naked")
    assert naked.any() and (ours[naked] == 0.0).all()


@pytest.mark.parametrize("falloff", list(compositing.FALLOFFS))
@pytest.mark.parametrize("lens", ["PERSP", "ORTHO"])
def test_mist_is_that_of_cycles(falloff: str, lens: str) -> None:
    """The mean of a pixel's distances makes it, which differs at edges behind which the mist is thickest, or not linear."""
    scene = show()
    scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.data.shift_x, scene.camera.data.shift_y = lens, 7.0, 0.1, -0.05
    settings = scene.world.mist_settings
    settings.start, settings.depth, settings.falloff = 5.5, 6.0, falloff
    found = both(scene, 64)
    ours, theirs = (each.of("Mist", "Z")[..., 0] for each in found)
    inner = inner_of(found)
    difference = np.abs(ours - theirs)
    at_edges = difference[~inner]
    print(f"mist {falloff} {lens}: {difference[inner].mean():.2e}, at most {difference[inner].max():.2e}; at edges {at_edges.mean():.2e}, {at_edges.max():.3f}")
    assert difference[inner].mean() < 2e-4 and difference[inner].max() < 0.02
    assert at_edges.mean() < 0.02 and at_edges.max() < 0.25
    assert np.ptp(theirs[inner]) > 0.5


def test_mist_without_a_world_is_blender_s_default() -> None:
    scene = show()
    scene.world = None
    scenes.plane(scene, "lamp", 1, scenes.simple("lamp", "ShaderNodeEmission", Strength=3.0), location=(0, 0, 30))
    ours, theirs = (each.of("Mist", "Z")[..., 0] for each in both(scene))
    assert np.abs(ours - theirs).mean() < 1e-3 and 0.01 < ours.min() < 0.2


class Commands:
    """Command lines of the processes that a render starts."""

    def __init__(self) -> None:
        self.lines: list[list[str]] = []

    @property
    def layers(self) -> list[str]:
        """Layers that the command for compositing was asked for."""
        lines = [line for line in self.lines if line[0] == "layers"]
        assert len(lines) <= 1
        return sorted(lines[0][lines[0].index("--layers") + 1].split(",")) if lines else []


@pytest.fixture
def commands(monkeypatch: pytest.MonkeyPatch) -> Iterator[Commands]:
    found, begin = Commands(), process.Process.__init__

    def noted(self: Any, program: str, arguments: list[str], *rest: Any) -> None:
        found.lines.append(arguments)
        begin(self, program, arguments, *rest)

    monkeypatch.setattr(process.Process, "__init__", noted)
    yield found


def simple_scene() -> Any:
    scene = test_instances.base()
    scenes.ball(scene, "ball", 1.0, scenes.diffuse("red", (0.7, 0.2, 0.2)), location=(0, 0, 1))
    return scene


@pytest.mark.parametrize(
    "switch,layers",
    [
        ("", []),
        ("use_pass_position", ["objects", "position"]),
        ("use_pass_uv", ["objects", "uv"]),
        ("use_pass_object_index", ["objects"]),
        ("use_pass_material_index", ["materials", "objects"]),
        ("use_pass_mist", ["objects", "position"]),
        ("use_pass_cryptomatte_object", ["objects"]),
        ("use_pass_cryptomatte_asset", ["objects"]),
        ("use_pass_cryptomatte_material", ["materials", "objects"]),
    ],
)
def test_nothing_runs_that_no_pass_asks_for(commands: Commands, switch: str, layers: list[str]) -> None:
    scene = simple_scene()
    if switch:
        switch_on(scene, switch)
    found = rendered(scene, "LODESTAR", 1)
    assert commands.layers == layers and len(commands.lines) == (2 if layers else 1)
    names_ = {**{name: each.name for name, each in compositing.PASSES.items()}, **compositing.MATTES}
    assert [name for name in SWITCHES if found.has(names_[name])] == ([switch] if switch else [])
    assert len(found.facts) == (4 if switch in compositing.MATTES else 0)


def test_a_picture_keeps_its_bits() -> None:
    scene = show()
    ours = rendered(scene, "LODESTAR", 4).of("Combined", "RGBA")
    for name in SWITCHES:
        setattr(scene.view_layers[0], name, False)
    assert np.array_equal(ours, rendered(scene, "LODESTAR", 4).of("Combined", "RGBA"))


def named(kept: Optional[list[str]] = None) -> Any:
    """A row of squares with names that need care, each with a material of the same name, and with the parent `group`."""
    scene = test_instances.base()
    scenes.camera(scene, (0, 0, 8), (0, 0, 0))
    parent = scenes.add(scene, "all #2", None)
    for at, name in enumerate(HARD if kept is None else kept):
        square = scenes.plane(scene, name, 0.5, scenes.diffuse(name, (0.5, 0.5, 0.5)), location=(0.6 * at - 2.1, 0, 0.1))
        square.parent = parent
        assert square.name == name and square.data.materials[0].name == name
    switch_on(scene)
    return scene


def test_names_that_need_care() -> None:
    scene = named()
    ours, theirs = both(scene)
    for kind in KINDS:
        mine, other = (each.shares(kind) for each in (ours, theirs))
        assert mine.keys() == other.keys() and len(mine) == (2 if kind == "CryptoAsset" else len(HARD) + 1)
        assert all(abs(mine[each].sum() - other[each].sum()) < 0.02 * other[each].sum() for each in mine)
    for kind in ("CryptoObject", "CryptoMaterial"):
        # Cycles' own text is no JSON where a name has a backslash or a line break.
        manifest = ours.manifest(kind)
        assert set(HARD) <= manifest.keys() and all(manifest[name] == mattes.identifier(name) for name in HARD)


def test_ids_of_a_scene_are_unique(tmp_path: Path) -> None:
    """Objects and materials may have the same names, and an object may be called like an id of another."""
    scene = named()
    ball = scenes.ball(scene, "a#1#1", 0.3, bpy.data.materials["a#1"])
    for at in range(3):
        scenes.add(scene, f"group {at}", ball.data, (at, 2, 0))
    found = export.export(bpy.context.evaluated_depsgraph_get(), tmp_path, export.Options())
    text = found.scene_file.read_text(encoding="utf-8")
    root = export.xml.ElementTree.fromstring(text)
    ids = [each.get("id") for each in root.iter() if each.get("id") and each.tag != "ref"]
    assert len(ids) == len(set(ids)) and {each.get("id") for each in root.iter("ref")} <= set(ids)
    # No letter begins a parameter of the scene.
    assert "$" not in text
    owners = {each.get("id").rpartition("#")[0] for each in root.iter("shape") if each.get("id") and each.get("type") != "shapegroup"}
    assert owners == {*found.names.objects}
    assert {each.name for each in found.names.objects.values()} == {*HARD, "ground", "a#1#1", "group 0", "group 1", "group 2"}


def test_instances_of_one_object_have_no_ids(tmp_path: Path) -> None:
    """The shapes of their group have its name. What shares a mesh with others has its own."""
    scene = test_instances.base()
    ball = scenes.ball(scene, "ball", 0.5, scenes.diffuse("red", (0.7, 0.2, 0.2)))
    test_instances.on_points(scene, ball, np.eye(3))
    scenes.add(scene, "copy", ball.data, (2, 0, 0))
    root = test_instances.exported(tmp_path)[1]
    ids = [each.get("id") for each in root.findall("shape") if each.get("type") == "instance"]
    assert len(ids) == 5 and sum(each is not None for each in ids) == 1
    assert next(each for each in ids if each).startswith("copy#")


def test_passes_of_a_border_are_those_of_the_whole_picture() -> None:
    scene = show()
    whole = rendered(scene, "LODESTAR", 1)
    render = scene.render
    render.use_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.5, 1.0
    part = rendered(scene, "LODESTAR", 1)
    for name, channels in (("Position", "XYZ"), ("UV", "UVA"), ("CryptoObject00", "rgba"), (compositing.OBJECT_INDEX, "X")):
        assert np.array_equal(part.of(name, channels)[:32, 16:48], whole.of(name, channels)[:32, 16:48]), name
        assert (part.of(name, channels)[32:] == 0.0).all()


def test_frames_of_an_animation_have_their_passes() -> None:
    """Mattes follow an object that moves, on each of two view layers."""
    scene = simple_scene()
    ball = scene.objects["ball"]
    for frame, x in ((1, -2.0), (2, 2.0)):
        ball.location.x = x
        ball.keyframe_insert("location", frame=frame)
    switch_on(scene, "use_pass_cryptomatte_object", "use_pass_position")
    other = scene.view_layers.new("other")
    other.use_pass_cryptomatte_asset = True
    support.render(scene, "LODESTAR", 1, "still")
    scene.frame_start, scene.frame_end = 1, 2
    scene.render.filepath = str(support.FOLDER / "moves-####.exr")
    bpy.ops.render.render(animation=True)
    middles = []
    for frame in (1, 2):
        path = support.FOLDER / f"moves-{frame:04}.exr"
        found, of_other = Passes(path), Passes(path, "other")
        share = found.shares("CryptoObject")[mattes.identifier("ball")]
        assert np.abs(of_other.shares("CryptoAsset")[mattes.identifier("ball")] - share).max() == 0.0
        assert not of_other.has("Position") and not of_other.has("CryptoObject")
        assert found.manifest("CryptoObject")["ball"] == of_other.manifest("CryptoAsset")["ball"] == mattes.identifier("ball")
        middles.append((share * found.of("Position", "XYZ")[..., 0]).sum() / share.sum())
    assert middles == pytest.approx([-2.0, 2.0], abs=0.3)


def test_mattes_of_what_moves_are_those_of_cycles() -> None:
    scene = simple_scene()
    ball = scene.objects["ball"]
    for frame, x in ((0, -2.0), (2, 2.0)):
        ball.location.x = x
        ball.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    switch_on(scene)
    ours, theirs = (each.shares("CryptoObject")[mattes.identifier("ball")] for each in both(scene))
    assert abs(ours.sum() - theirs.sum()) < 0.02 * theirs.sum() and np.abs(ours - theirs).max() < 0.25
    assert ((theirs > 0.3) & (theirs < 0.7)).sum() > 100


def test_shares_of_what_is_half_transparent_are_those_of_cycles() -> None:
    scene = simple_scene()
    shader = lambda tree: scenes.mixed(tree, scenes.shader(tree, "ShaderNodeBsdfTransparent"), scenes.shader(tree, "ShaderNodeBsdfDiffuse"))  # noqa: E731
    scenes.plane(scene, "veil", 3, scenes.material("veil", shader), location=(0, -1.5, 1.5), rotation=(1.2, 0, 0))
    switch_on(scene)
    ours, theirs = (each.shares("CryptoObject") for each in both(scene))
    assert ours.keys() == theirs.keys() and len(ours) == 3
    assert all(abs(ours[each].sum() - theirs[each].sum()) < 0.02 * theirs[each].sum() for each in ours)
    veil = ours[mattes.identifier("veil")]
    assert veil.max() < 0.85 and 0.45 < np.median(veil[veil > 0.3]) < 0.55


@pytest.mark.parametrize("levels,layers", [(2, 1), (6, 3), (9, 5), (16, 8)])
def test_levels_are_blender_s(levels: int, layers: int) -> None:
    """Of more than six things in a pixel, those with the largest shares are kept."""
    scene = simple_scene()
    switch_on(scene, "use_pass_cryptomatte_object")
    scene.view_layers[0].pass_cryptomatte_depth = levels
    found = rendered(scene, "LODESTAR", 1)
    assert [found.has(f"CryptoObject{at:02}") for at in range(9)] == [at < layers for at in range(9)]
    assert all((found.of(f"CryptoObject{at:02}", "rgba") == 0.0).all() for at in range(3, layers))
    assert found.shares("CryptoObject", layers).keys() == {mattes.identifier("ball"), mattes.identifier("ground")}


@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="Blender 5.0 has compositor node groups")
@pytest.mark.parametrize("kind,name", [("CryptoObject", "ball"), ("CryptoMaterial", "red"), ("CryptoAsset", "rig")])
def test_blender_s_compositor_cuts_out_objects(kind: str, name: str) -> None:
    scene = simple_scene()
    scene.objects["ball"].parent = scenes.add(scene, "rig", None)
    switch_on(scene)
    tree = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
    scene.compositing_node_group = tree
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    node, end = tree.nodes.new("CompositorNodeCryptomatteV2"), tree.nodes.new("NodeGroupOutput")
    node.source, node.scene, node.layer_name, node.matte_id = "RENDER", scene, f"ViewLayer.{kind}", name
    tree.links.new(node.outputs["Matte"], end.inputs[0])
    found = rendered(scene, "LODESTAR", 1)
    cut = Passes(Path(scene.render.filepath), "Composite").of("Combined", "R")[..., 0]
    share = found.shares(kind)[mattes.identifier(name)]
    assert np.abs(cut - share).max() < 1e-6 and share.sum() > 100


def test_a_package_runs_in_a_process_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a package renders, its own command writes the layers, with the device of the preferences."""
    folder = tmp_path / "site packages" / "renders"
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text("")
    noted = f"open({str(tmp_path / 'noted')!r}, 'w').write(repr(sys.argv[1:]))"
    (folder / "__main__.py").write_text(f"import os, sys\n{noted}\nos.execv({support.PROGRAM!r}, ['lodestar', *sys.argv[1:]])\n")
    package = types.SimpleNamespace(__name__="renders", __file__=str(folder / "__init__.py"))
    monkeypatch.setattr(inside, "package", lambda: package)
    scene = simple_scene()
    switch_on(scene)
    scene.lodestar.seed, scene.lodestar.arguments = 7, "--grid auto --rfilter=box --traversal compute"
    exported = export.export(bpy.context.evaluated_depsgraph_get(), tmp_path, export.Options())
    running = engine.start_layers(scene.lodestar, types.SimpleNamespace(program="", device="#0 a"), exported.scene_file, scene.view_layers[0])
    assert list(filter(None, running.events())) == [] and running.failure is None
    found = running.picture()
    assert found is not None and found.size == (64, 64) and {"position.X", "uv.U", "CryptoMaterial02.A"} <= found.channels.keys()
    words = (tmp_path / "noted").read_text()
    for each in ("'--seed', '7'", "'--device', '0'", "'--rfilter=box'", "'--traversal', 'compute'", "'--spp', '64'"):
        assert each in words
    assert "--grid" not in words


@pytest.mark.skipif(os.name != "posix", reason="the program is a script of the shell")
def test_a_program_without_the_command_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The picture is there, and the error says which passes are missing, and why."""
    script = tmp_path / "old"
    script.write_text(f'#!/bin/sh\n[ "$1" = layers ] && set -- lairs\nexec {support.PROGRAM} "$@"\n')
    script.chmod(script.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setattr(process, "find", lambda preferred: str(script))
    scene = simple_scene()
    switch_on(scene)
    shown: list[Any] = []
    monkeypatch.setattr(engine.LodestarEngine, "_show", lambda self, *rest: shown.append(rest))
    with pytest.raises(RuntimeError, match="the passes for compositing are missing: unrecognized subcommand 'lairs'"):
        rendered(scene, "LODESTAR", 1)
    assert shown


@pytest.mark.parametrize("is_stopped", [False, True])
def test_a_stop_leaves_the_picture(is_stopped: bool) -> None:
    """A render that is stopped shows its picture and asks for no layers."""
    switch_on(simple_scene())
    calls: list[str] = []
    note = lambda name: lambda *_: calls.append(name)  # noqa: E731
    running = types.SimpleNamespace(failure=None, events=lambda: iter([None]), stop=note("stop"), close=note("close"), picture=lambda: "picture")
    stand_in = types.SimpleNamespace(test_break=lambda: is_stopped, _show=note("show"), _show_layers=note("layers"))
    engine.LodestarEngine._run(stand_in, running, None, bpy.context.evaluated_depsgraph_get())  # type: ignore[arg-type]
    assert calls == (["stop", "close", "show"] if is_stopped else ["close", "show", "layers"])


def test_panels_show_blender_s_switches() -> None:
    """The panels of a view layer's passes, Cryptomatte and mist are offered, and the switches are those of the view layer."""
    for name in ("VIEWLAYER_PT_layer_passes", "VIEWLAYER_PT_layer_passes_cryptomatte", "EEVEE_WORLD_PT_mist"):
        assert "LODESTAR" in getattr(bpy.types, name).COMPAT_ENGINES, name
    drawn: list[str] = []
    layout = types.SimpleNamespace(prop=lambda owner, name: drawn.append(name) if hasattr(owner, name) else pytest.fail(name))
    for panel in ("LODESTAR_PT_layer_passes", "LODESTAR_PT_material_index"):
        context = types.SimpleNamespace(view_layer=bpy.context.view_layer, material=bpy.data.materials.new("any"))
        getattr(bpy.types, panel).draw(types.SimpleNamespace(layout=layout), context)
    assert drawn == [*compositing.PASSES, "pass_index"]


# ------------------------------------------------------------------------------------------------------------ mattes


def test_hashes_are_those_of_murmur3() -> None:
    """Values of the reference implementation."""
    for text, value in (("", 0), ("test", 0xBA6BD213), ("Hello, world!", 0xC0363E43), ("a", 0x3C2569B2)):
        assert mattes.murmur3(text.encode()) == value


def test_identifiers_are_numbers() -> None:
    bits = np.array([mattes.identifier(f"object {at}") for at in range(20_000)], np.uint32)
    numbers = bits.view(np.float32)
    assert np.isfinite(numbers).all() and (np.abs(numbers) >= np.finfo(np.float32).tiny).all()
    changed = [at for at in range(20_000) if mattes.murmur3(f"object {at}".encode()) != bits[at]]
    assert 50 < len(changed) < 300


def matte(*things: tuple[str, float]) -> mattes.Matte:
    """Matte of one pixel."""
    padded = [*things, *(("", 0.0),) * (6 - len(things))]
    ids = np.array([[mattes.identifier(name) if share else 0 for name, share in padded]], np.uint32)
    return mattes.Matte(ids, np.array([[share for _, share in padded]], np.float32))


def things(found: mattes.Matte, known: str) -> list[tuple[str, float]]:
    by_id = {mattes.identifier(name): name for name in known}
    return [(by_id[int(each)], round(float(share), 6)) for each, share in zip(found.ids[0], found.shares[0]) if share > 0.0]


def test_shares_of_one_name_add_up() -> None:
    found = matte(("a", 0.3), ("b", 0.25), ("c", 0.2), ("d", 0.15), ("lamp", 0.1)).renamed({"a": "x", "b": "y", "c": "y", "d": "x"})
    assert things(found, "xy") == [("x", 0.45), ("y", 0.45)]
    found = matte(("a", 0.3), ("b", 0.25), ("c", 0.2), ("lamp", 0.25)).renamed({"a": "x", "b": "y", "c": "y"})
    assert things(found, "xy") == [("y", 0.45), ("x", 0.3)] and float(found.total[0]) == pytest.approx(0.75)
    assert things(found.renamed({}), "") == []


def test_an_index_is_that_of_the_largest_share() -> None:
    table = {"a": 3.0, "b": 5.0}
    assert matte(("b", 0.4), ("a", 0.3)).indices(table)[0] == 5.0
    assert matte(("b", 0.4)).indices(table)[0] == 0.0
    assert matte(("c", 1.0)).indices(table)[0] == 0.0


def test_names_that_xml_cannot_hold() -> None:
    assert names._writable("a$b\x01c\td") == "a\ufffdb\ufffdc\td"
    assert re.fullmatch("[^$]*", names._writable("$$"))
    assert sys.maxunicode and names.id_of_part("a#1", 2) == "a#1#2"
