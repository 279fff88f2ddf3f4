"""The Rendered mode of a 3D view on Blender's own data, with a package in the renderer's place."""

from __future__ import annotations

import gc
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy
import fake_package
import pytest
import view_scenes
from fake_package import Renderer
from lodestar import export, inside, interactive
from lodestar.interactive import Interactive

WIDTH, HEIGHT = 96, 64


class Engine:
    """What a viewport needs of the engine."""

    def __init__(self) -> None:
        self.redraws, self.status = 0, ""

    def tag_redraw(self) -> None:
        self.redraws += 1

    def update_stats(self, title: str, status: str) -> None:
        self.status = status


class View3D:
    """A 3D view in the mode Rendered."""

    def __init__(self) -> None:
        self.engine, self.interactive = Engine(), Interactive()
        self.context = view_scenes.context(WIDTH, HEIGHT)
        self._following = view_scenes.Following(lambda depsgraph: self.interactive.update(self.engine, depsgraph))
        bpy.context.view_layer.update()

    def draw(self) -> None:
        self.interactive.draw(self.engine, self.context, bpy.context.evaluated_depsgraph_get())

    def rest(self, seconds: float = 20.0) -> None:
        """Draws until no picture comes any more."""
        end = time.monotonic() + seconds
        while True:
            self.draw()
            viewport = self.interactive.viewport
            if viewport is None or viewport.is_done:
                self.draw()
                return
            assert time.monotonic() < end, self.engine.status
            time.sleep(0.002)

    def renders_after(self, edit: Callable[[], Any]) -> int:
        """How many scenes are read after an edit."""
        before = len(Renderer.texts)
        edit()
        bpy.context.view_layer.update()
        self.rest()
        return len(Renderer.texts) - before

    def close(self) -> None:
        self._following.close()
        self.interactive.close()


@pytest.fixture
def view(monkeypatch: pytest.MonkeyPatch) -> Iterator[View3D]:
    fake_package.reset()
    Renderer.seconds = 0.0002
    monkeypatch.setattr(inside, "package", lambda: sys.modules["fake_package"])
    monkeypatch.setattr(interactive.Canvas, "draw", lambda *_: None)
    view_scenes.room().lodestar.viewport_samples = 2
    found = View3D()
    yield found
    found.close()


def objects() -> Any:
    return bpy.context.scene.objects


def color_of(name: str) -> Any:
    return bpy.data.materials[name].node_tree.nodes["Diffuse BSDF"].inputs["Color"]


def test_a_view_is_rendered_without_a_camera(view: View3D) -> None:
    view.rest()
    assert len(Renderer.all) == 1 and view.engine.status == "Sample 2/2"
    assert Renderer.all[0].options.items() >= {"sampler": "product", "seed": 0, "slice_ms": 40}.items()
    picture = view.interactive.viewport.picture
    assert picture is not None and picture.colors.shape == (HEIGHT, WIDTH, 4)


def test_a_view_that_moves_exports_nothing(view: View3D) -> None:
    view.rest()
    for turn in (0.1, 0.2):
        view.context.region_data = view_scenes.orbit(WIDTH, HEIGHT, turn)
        assert view.renders_after(lambda: None) == 0
    assert view.interactive.viewport.picture.view.place[0][0] != 1.0
    # Nor does a camera, or what is selected.
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    assert view.renders_after(lambda: bpy.context.scene.collection.objects.link(camera)) == 0
    assert view.renders_after(lambda: setattr(camera.data, "lens", 30.0)) == 0
    assert view.renders_after(lambda: objects()["ball"].select_set(True)) == 0
    assert view.renders_after(lambda: setattr(bpy.context.scene.view_settings, "exposure", 1.0)) == 0


def hide_by_type(view: View3D) -> None:
    view.context.space_data.show_object_viewport_light = False
    # The 3D view tags nothing by itself where there is no window.
    objects()["lamp"].update_tag()


EDITS: dict[str, Callable[[View3D], Any]] = {
    "place": lambda _: setattr(objects()["ball"].location, "x", 0.1),
    "material": lambda _: setattr(color_of("left"), "default_value", (0, 0, 1, 1)),
    "lamp": lambda _: setattr(bpy.data.lights["lamp"], "energy", 3.0),
    "world": lambda _: setattr(bpy.context.scene, "world", bpy.data.worlds.new("world")),
    "mesh": lambda _: (setattr(objects()["ball"].data.vertices[0].co, "z", 2.0), objects()["ball"].data.update()),
    "modifier": lambda _: objects()["ball"].modifiers.new("solid", "SOLIDIFY"),
    "hidden": lambda _: objects()["ball"].hide_set(True),
    "unseen by the camera": lambda _: setattr(objects()["ball"], "visible_camera", False),
    "hidden by type": hide_by_type,
    "added": lambda _: bpy.context.scene.collection.objects.link(bpy.data.objects.new("new", objects()["ball"].data)),
    "removed": lambda _: bpy.data.objects.remove(objects()["ball"]),
    "sampler": lambda _: setattr(bpy.context.scene.lodestar, "sampler", "bsdf"),
}


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_is_read_once_and_keeps_the_session(view: View3D, name: str) -> None:
    view.rest()
    assert view.renders_after(lambda: EDITS[name](view)) == 1
    first, second = Renderer.texts
    assert (first != second) == (name != "sampler")
    # Another sampler is another session, whose guide begins anew.
    assert len(Renderer.all) == (2 if name == "sampler" else 1) and "guide" not in Renderer.all[-1].options
    assert view.engine.status.startswith("Sample 2/2")


def test_undo_is_an_edit(view: View3D) -> None:
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    view.rest()
    assert view.renders_after(lambda: setattr(objects()["ball"].location, "x", 0.1)) == 1
    bpy.ops.ed.undo_push(message="after")
    assert view.renders_after(bpy.ops.ed.undo) == 1
    assert Renderer.texts[0] == Renderer.texts[2]


def test_meshes_that_have_not_changed_are_not_read_again(view: View3D, monkeypatch: pytest.MonkeyPatch) -> None:
    from lodestar.meshes import Meshes

    read: list[str] = []
    export = Meshes._export
    monkeypatch.setattr(Meshes, "_export", lambda self, owner, *rest: (read.append(owner.name), export(self, owner, *rest))[1])
    view.rest()
    assert len(read) == 7
    for name, wanted in (("lamp", []), ("place", []), ("material", []), ("mesh", ["ball"]), ("modifier", ["ball"])):
        read.clear()
        assert view.renders_after(lambda: EDITS[name](view)) == 1 and read == wanted, name
    # Files of a hidden object are gone when it comes back.
    view.renders_after(lambda: objects()["ball"].hide_set(True))
    assert view.renders_after(lambda: objects()["ball"].hide_set(False)) == 1


def test_edits_while_a_scene_is_read_are_one_edit(view: View3D) -> None:
    view.rest()
    Renderer.seconds_to_read = 0.3
    before = len(Renderer.texts)
    for at in range(10):
        objects()["ball"].location.x = 0.01 * at + 0.1
        bpy.context.view_layer.update()
        begin = time.monotonic()
        view.draw()
        assert time.monotonic() - begin < 0.25
    view.rest()
    assert len(Renderer.texts) - before == 2


def test_what_is_wrong_is_told_in_the_view(view: View3D) -> None:
    view.rest()
    bpy.context.scene.lodestar.arguments = "--view"
    view.draw()
    assert "--view cannot be among More Options" in view.engine.status
    bpy.context.scene.lodestar.arguments = ""
    view.rest()
    assert view.engine.status == "Sample 2/2"
    Renderer.refused = "no Vulkan driver found"
    view.renders_after(lambda: setattr(objects()["ball"].location, "x", 0.2))
    assert view.engine.status == "no Vulkan driver found"


class Failing:
    """An export for which there is no place."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, *_: Any) -> None:
        self.calls += 1
        raise OSError("the disk is full")


def test_a_fault_of_an_export_is_told_until_the_scene_changes(view: View3D, monkeypatch: pytest.MonkeyPatch) -> None:
    failing = Failing()
    view.rest()
    with monkeypatch.context() as patch:
        patch.setattr(export, "export_view", failing)
        assert view.renders_after(lambda: setattr(objects()["ball"].location, "x", 0.2)) == 0
        view.rest()
        assert view.engine.status == "the disk is full" and failing.calls == 1
    assert view.renders_after(lambda: setattr(objects()["ball"].location, "x", 0.3)) == 1
    assert view.engine.status == "Sample 2/2"


def test_a_fault_of_the_first_export_and_of_changed_options_is_told_until_the_scene_changes(view: View3D, monkeypatch: pytest.MonkeyPatch) -> None:
    failing = Failing()
    with monkeypatch.context() as patch:
        patch.setattr(export, "export_view", failing)
        for _ in range(5):
            view.draw()
        assert view.engine.status == "the disk is full" and failing.calls == 1
    assert view.renders_after(lambda: setattr(objects()["ball"].location, "x", 0.1)) == 1
    with monkeypatch.context() as patch:
        patch.setattr(export, "export_view", failing)
        bpy.context.scene.lodestar.seed += 1
        view.rest()
        assert view.engine.status == "the disk is full" and failing.calls == 2
    # The scene is the same as before the fault, but the seed is another one.
    assert view.renders_after(lambda: setattr(objects()["ball"].location, "x", 0.1)) == 1
    assert view.engine.status == "Sample 2/2"


def test_meshes_of_objects_that_are_gone_are_not_kept(view: View3D) -> None:
    view.rest()
    parts = view.interactive._scenery._kept._parts
    assert view.renders_after(lambda: bpy.data.objects.remove(objects()["ball"])) == 1
    assert len(view.interactive._scenery._kept._parts) == len(parts) - 1


def test_a_look_ends_with_its_engine(view: View3D) -> None:
    engine = Engine()
    look = interactive._Look(engine, view.interactive)
    view.rest()
    assert look() == interactive.LOOK and engine.redraws == 1
    del engine
    assert look() is None


def test_without_the_package_the_view_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inside, "package", lambda: None)
    view_scenes.room()
    view = View3D()
    view.rest()
    view.close()
    assert view.engine.status == interactive.NO_PACKAGE and view.interactive.viewport is None


def test_a_picture_asks_for_a_redraw(view: View3D) -> None:
    view.rest()
    view.engine.redraws = 0
    view.interactive.look(view.engine)
    assert view.engine.redraws == 1
    view.interactive.look(view.engine)
    assert view.engine.redraws == 1


def test_a_thousand_edits_leave_nothing_behind(view: View3D) -> None:
    """Edits by chance, undo included, while views are drawn: no fault, and the scene that is shown is the one that is there."""
    edits, viewport = view_scenes.Edits(seed=5), None
    for at in range(1000):
        edits.make()
        if at % 3 == 0:
            view.context.region_data = view_scenes.orbit(WIDTH, HEIGHT, 0.01 * at)
        view.draw()
        viewport = viewport or view.interactive.viewport
        assert view.interactive.status.startswith(("Preparing", "Moving", "Sample")), view.interactive.status
    view.rest()
    shown, folder = Renderer.texts[-1], Path(view.interactive._folder)
    assert len(Renderer.texts) > 50 and view.interactive.viewport is viewport
    view.interactive._scenery.forget()
    view.interactive._scenery._kept.forget({each.session_uid for each in (*bpy.data.objects, *bpy.data.meshes)})
    view.rest()
    assert without_camera(Renderer.texts[-1]) == without_camera(shown)
    files = {path.name for path in folder.iterdir()}
    assert files == {"scene.xml"} | {name for name in files if name in shown}
    view.interactive.close()
    assert not folder.exists()
    Renderer.all = []
    end = time.monotonic() + 10.0
    while Renderer.alive and time.monotonic() < end:
        gc.collect()
        time.sleep(0.01)
    assert not Renderer.alive


def without_camera(text: str) -> str:
    return text[: text.index("<sensor")] + text[text.index("</sensor>") :]
