"""The viewport's render without Blender and without a device."""

from __future__ import annotations

import gc
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import fake_package
import numpy as np
import pytest
from fake_package import Renderer
from lodestar.view_camera import View
from lodestar.viewport import Quality, Viewport, close_all

WIDTH, HEIGHT = 640, 320
PROJECTION = ((1.0, 0.0, 0.0, 0.0), (0.0, 2.0, 0.0, 0.0), (0.0, 0.0, -1.0, -0.2), (0.0, 0.0, -1.0, 0.0))
OPTIONS = {"sampler": "product", "seed": 7, "slice_ms": 40}


def view(x: float = 0.0, **changes: Any) -> View:
    place = ((1.0, 0.0, 0.0, x), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    return View(place, PROJECTION, (WIDTH, HEIGHT), (0, 0, WIDTH, HEIGHT), (0.1, 100.0))._replace(**changes)


def wait(until: Callable[[], Any], seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not until():
        assert time.monotonic() < end, "it took too long"
        time.sleep(0.002)


@pytest.fixture
def viewport(tmp_path: Path) -> Iterator[Viewport]:
    fake_package.reset()
    (tmp_path / "scene.xml").write_text("first")
    found = Viewport(sys.modules["fake_package"])
    found.change(tmp_path / "scene.xml", OPTIONS)
    yield found
    found.close(10.0)


def is_at_rest(viewport: Viewport) -> bool:
    return viewport.is_done and viewport.picture is not None and viewport.picture.colors.shape == (HEIGHT, WIDTH, 4)


def test_a_view_at_rest_gets_all_samples_at_full_size(viewport: Viewport) -> None:
    viewport.show(view(), Quality(samples=5))
    wait(lambda: is_at_rest(viewport))
    picture = viewport.picture
    assert picture is not None and (picture.samples, picture.place) == (5, (0, 0, WIDTH, HEIGHT))
    assert viewport.status == "Sample 5/5" and viewport.take_change() and not viewport.take_change()
    (renderer,) = Renderer.all
    assert {name: renderer.options[name] for name in OPTIONS} == OPTIONS
    # The first pictures are small.
    sizes = [size for name, size in renderer.calls if name == "size"]
    assert renderer.options["width"] <= WIDTH / 8 and sizes == sorted(sizes)


def test_a_view_that_moves_stops_the_step_and_keeps_the_session(viewport: Viewport) -> None:
    Renderer.seconds = 0.02  # 1 s for a picture of full size
    viewport.show(view(), Quality())
    wait(lambda: viewport.picture is not None)
    time.sleep(0.5)
    for at in range(1, 6):
        begin = time.monotonic()
        viewport.show(view(at), Quality())
        assert time.monotonic() - begin < 0.05
        wait(lambda: viewport.picture.view == view(at))
        assert time.monotonic() - begin < 0.3
        assert viewport.picture.colors.shape[1] < WIDTH
        time.sleep(0.2)
    assert len(Renderer.all) == 1


def test_a_view_that_moves_without_an_end_is_seen(viewport: Viewport) -> None:
    Renderer.seconds = 0.02
    shown = set()
    for at in range(200):
        viewport.show(view(at), Quality())
        if viewport.picture is not None:
            shown.add(viewport.picture.view)
        time.sleep(0.005)
    assert len(shown) > 5


def test_another_scene_is_taken_by_the_same_session(viewport: Viewport, tmp_path: Path) -> None:
    Renderer.seconds = 0.01
    viewport.show(view(), Quality(samples=2))
    wait(lambda: is_at_rest(viewport))
    (renderer,) = Renderer.all
    (tmp_path / "scene.xml").write_text("second")
    viewport.change(tmp_path / "scene.xml", OPTIONS)
    assert viewport.is_reading and viewport.status == "Preparing the scene"
    wait(lambda: is_at_rest(viewport))
    assert Renderer.all == [renderer] and renderer.text == "second" and not viewport.is_reading
    # It is small when the scene comes: a film of full size would have other cells of the guide, and other kernels.
    names = [name for name, _ in renderer.calls]
    at = names.index("scene")
    assert names[at - 1] == "size" and renderer.calls[at - 1][1][0] <= WIDTH / 4


def test_other_options_begin_with_the_guide_and_the_device_of_the_one_before(viewport: Viewport, tmp_path: Path) -> None:
    viewport.show(view(), Quality(samples=2))
    wait(lambda: is_at_rest(viewport))
    (first,) = Renderer.all
    viewport.change(tmp_path / "scene.xml", {**OPTIONS, "grid": "8"})
    wait(lambda: len(Renderer.all) == 2 and is_at_rest(viewport))
    second = Renderer.all[1]
    assert set(second.options["guide"]) and second.options["device"] == id(first)
    # A guide must not have learned from the samples that it guides.
    assert second.options["seed"] not in second.options["guide"]
    # Another device that is chosen, and several of them, are taken as they are.
    for at, device in enumerate(("1", "0,1", "0,1"), 2):
        viewport.change(tmp_path / "scene.xml", {**OPTIONS, "max_depth": at, "device": device})
        wait(lambda: len(Renderer.all) == at + 1 and is_at_rest(viewport))
        assert Renderer.all[at].options["device"] == device and Renderer.all[at].options["guide"]


def test_a_scene_that_is_refused_is_told_and_the_next_one_is_shown(viewport: Viewport, tmp_path: Path) -> None:
    viewport.show(view(), Quality(samples=1))
    wait(lambda: is_at_rest(viewport))
    Renderer.refused = "the scene has no light"
    viewport.change(tmp_path / "scene.xml", OPTIONS)
    wait(lambda: not viewport.is_reading)
    assert viewport.status == "the scene has no light" and viewport.take_change() and viewport.is_done
    Renderer.refused = ""
    viewport.change(tmp_path / "scene.xml", OPTIONS)
    wait(lambda: is_at_rest(viewport))
    # The session before the fault goes on, and what was learned is not lost.
    assert viewport.status == "Sample 1/1" and len(Renderer.all) == 1


def test_a_view_that_is_refused_is_told_until_the_next_one(viewport: Viewport) -> None:
    viewport.show(view(clip=(2.0, 1.0)), Quality(samples=1))
    wait(lambda: viewport.fault)
    assert viewport.status == "the far plane must lie behind the near one" and viewport.is_done
    viewport.show(view(), Quality(samples=1))
    wait(lambda: is_at_rest(viewport))
    assert viewport.status == "Sample 1/1"


def test_quality_changes_without_a_new_scene(viewport: Viewport) -> None:
    viewport.show(view(), Quality(samples=2))
    wait(lambda: is_at_rest(viewport))
    viewport.show(view(), Quality(samples=4))
    wait(lambda: viewport.status == "Sample 4/4")
    # A picture that is denoised is the same one.
    viewport.show(view(), Quality(samples=4, is_denoised=True))
    wait(lambda: viewport.is_done)
    assert viewport.status == "Sample 4/4 | not denoised: Open Image Denoise was not found"
    Renderer.denoises = True
    viewport.show(view(), Quality(samples=4))
    wait(lambda: viewport.is_done)
    viewport.show(view(), Quality(samples=4, is_denoised=True))
    wait(lambda: viewport.is_done)
    assert viewport.picture.colors[0, 0, 0] == 8.0 and viewport.status == "Sample 4/4"
    viewport.show(view(), Quality(samples=4, pixel=4))
    wait(lambda: viewport.is_done)
    assert viewport.picture.colors.shape == (HEIGHT // 4, WIDTH // 4, 4) and viewport.picture.place == (0, 0, WIDTH, HEIGHT)
    assert len(Renderer.all) == 1


def test_rows_run_from_the_bottom(viewport: Viewport, monkeypatch: pytest.MonkeyPatch) -> None:
    def picture(self: Renderer) -> fake_package.Picture:
        found = fake_package.Picture(self.settings["width"], self.settings["height"], 0.0)
        found.radiance[0], found.alpha[-1] = 3.0, 0.0
        return found

    monkeypatch.setattr(Renderer, "picture", picture)
    viewport.show(view(), Quality(samples=1))
    wait(lambda: is_at_rest(viewport))
    colors = viewport.picture.colors
    assert (colors[-1] == (3.0, 3.0, 3.0, 1.0)).all() and (colors[0] == 0.0).all()


def test_many_changes_leave_one_render(viewport: Viewport, tmp_path: Path) -> None:
    """Views, scenes and settings in any order, 1,000 times: no fault, no renderer and no thread more than at the beginning."""
    chance = np.random.default_rng(1)
    for _ in range(1000):
        kind = chance.integers(4)
        if kind == 0:
            (tmp_path / "scene.xml").write_text("scene")
            viewport.change(tmp_path / "scene.xml", OPTIONS)
        else:
            viewport.show(view(float(chance.integers(3))), Quality(int(chance.integers(1, 4)), int(2 ** chance.integers(3)), kind == 1))
        time.sleep(0.001)
    viewport.show(view(), Quality(samples=3))
    wait(lambda: is_at_rest(viewport))
    assert viewport.status == "Sample 3/3"
    assert sum(name == "scene" for renderer in Renderer.all for name, _ in renderer.calls) > 10
    Renderer.all = []
    gc.collect()
    assert Renderer.alive == 1


def test_a_render_ends_with_its_viewport(tmp_path: Path) -> None:
    fake_package.reset()
    Renderer.seconds = 0.1
    (tmp_path / "scene.xml").write_text("first")
    before = threading.active_count()
    for at in range(20):
        found = Viewport(sys.modules["fake_package"])
        found.change(tmp_path / "scene.xml", OPTIONS)
        found.show(view(), Quality())
        if at % 2:
            wait(lambda: found.picture is not None)
            time.sleep(0.05)
        # One that is forgotten ends, too.
        found.close() if at % 3 else None
        del found
    gc.collect()
    close_all()
    wait(lambda: threading.active_count() == before)
    Renderer.all = []
    gc.collect()
    assert Renderer.alive == 0
