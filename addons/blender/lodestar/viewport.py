"""Viewport: a render that follows what its viewer does, in a thread of its own.

A view that changes stops the step under way. The next picture is small enough to come at once, and gets finer while the view rests. The
guide stays from view to view, and goes over to the next scene. Nothing here knows Blender, and no call waits for the renderer.
"""

from __future__ import annotations

import atexit
import threading
import time
import warnings
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, Optional

import numpy as np

from .view_camera import Rectangle, View

# Time in which the first picture of a view should come, without what a change of the view takes.
FIRST_PICTURE = 0.12
# Time between two pictures of a view that rests.
NEXT_PICTURE = 0.7
# Time of a picture that is so short that none of fewer pixels comes before it.
SHORT = 0.35
# Time of a dispatch in milliseconds. A change waits for the dispatch under way.
SLICE = 40
# Largest pixels, in multiples of those of a view that rests.
COARSEST = 16
# Pixels along a film's shorter side that a small picture has at least.
LEAST_SIDE = 24


class Quality(NamedTuple):
    """What a view that rests gets."""

    samples: int = 128
    # Side of a pixel of the film in pixels of the region.
    pixel: int = 1
    is_denoised: bool = False


class Shown(NamedTuple):
    """Picture of a view."""

    # (height, width, 4), rows from the bottom, colors times alpha.
    colors: np.ndarray
    view: View
    # Part of the region that the picture covers. It may reach over the view's window.
    place: Rectangle
    samples: int


class Detail:
    """Sizes of pictures by the time that those before have taken."""

    def __init__(self) -> None:
        self.seconds_per_pixel: Optional[float] = None
        self._pixels = 0

    def first(self, view: View, finest: int) -> int:
        """Pixel of the first picture after a change."""
        pixel, most = finest, finest * COARSEST
        while pixel < most and not self._comes_at_once(view, pixel) and min(view.film(2 * pixel)) >= LEAST_SIDE:
            pixel *= 2
        return pixel

    def next(self, view: View, pixel: int, finest: int) -> int:
        """Pixel of the picture that follows one of a coarser pixel."""
        return finest if self.seconds(view, finest) < SHORT else max(pixel // 2, finest)

    def samples(self, view: View, pixel: int, most: int) -> int:
        """Samples of the next picture of a view that rests."""
        return max(min(int(NEXT_PICTURE / max(self.seconds(view, pixel), 1e-6)), most), 1)

    def took(self, view: View, pixel: int, samples: int, seconds: float) -> None:
        """Notes how long a picture has taken. In small ones, other work than that of pixels takes the longest, so they count where they say less."""
        width, height = view.film(pixel)
        pixels = width * height * samples
        found, known = seconds / pixels, self.seconds_per_pixel
        if known is None or found < known:
            self.seconds_per_pixel = found
        elif pixels >= self._pixels or seconds > 2.0 * FIRST_PICTURE:
            self.seconds_per_pixel = 0.5 * (known + found)
        self._pixels = pixels

    def seconds(self, view: View, pixel: int) -> float:
        """Time of one sample for each pixel; infinite where none is known."""
        width, height = view.film(pixel)
        return float("inf") if self.seconds_per_pixel is None else width * height * self.seconds_per_pixel

    def _comes_at_once(self, view: View, pixel: int) -> bool:
        return self.seconds(view, pixel) <= FIRST_PICTURE


class Viewport:
    """A render of a scene that changes. Its thread ends with `close`."""

    def __init__(self, package: Any) -> None:
        self.fault = ""
        self.note = ""
        self._package = package
        self._news = threading.Condition()
        self._is_open, self._is_changed, self._is_reading, self._is_busy = True, False, False, False
        # Whether the step under way may be stopped, and whether it was.
        self._is_refining, self._is_interrupted = False, False
        self._scene: Optional[tuple[Path, dict[str, Any]]] = None
        self._wish: Optional[View] = None
        self._quality = Quality()
        self._picture: Optional[Shown] = None
        # The rest belongs to the thread.
        self._renderer: Optional[Any] = None
        self._before: Optional[Any] = None
        self._options: dict[str, Any] = {}
        self._view: Optional[View] = None
        self._pixel = 1
        self._samples, self._is_denoised = 0, False
        self._detail = Detail()
        # When a picture was denoised last, and how long that took.
        self._denoised = (0.0, 0.0)
        self._thread = threading.Thread(target=_work, args=(weakref.ref(self), self._news), daemon=True)
        _open.add(self)
        self._thread.start()

    # ------------------------------------------------------------------------------------------------- what callers do

    def show(self, view: View, quality: Quality) -> None:
        """Shows the scene by another view from now on."""
        with self._news:
            is_moved = view != self._wish
            self._wish, self._quality = view, quality
            if is_moved:
                if self._renderer is not None:
                    self.fault = ""
                self._interrupt()
            elif self._has_work():
                self._news.notify()

    def change(self, scene_file: Path, options: dict[str, Any]) -> None:
        """Shows another scene from now on, whose files must stay until `is_reading` is false."""
        with self._news:
            self._scene, self._is_reading, self.fault = (scene_file, options), True, ""
            self._interrupt()

    def _interrupt(self) -> None:
        renderer = self._renderer
        if self._is_refining and renderer is not None:
            self._is_interrupted = True
            renderer.stop()
        self._news.notify()

    @property
    def is_reading(self) -> bool:
        """Whether a scene has been given that is not rendered yet."""
        return self._is_reading

    @property
    def picture(self) -> Optional[Shown]:
        """The newest picture."""
        return self._picture

    @property
    def is_done(self) -> bool:
        """Whether no picture comes unless something changes."""
        with self._news:
            return not self._is_open or not (self._is_busy or self._has_work())

    def take_change(self) -> bool:
        """Whether there is something new to draw since the last call."""
        # The thread sets the mark after what is new, so only a mark that was seen is taken away.
        if not self._is_changed:
            return False
        self._is_changed = False
        return True

    @property
    def status(self) -> str:
        """What the render does, in words."""
        if self.fault:
            return self.fault
        picture, view = self._picture, self._wish
        if picture is None or self._is_reading:
            return "Preparing the scene"
        is_newest = picture.view == view and picture.place[2] <= view.covered(self._quality.pixel)[2]
        words = f"Sample {picture.samples}/{self._quality.samples}" if is_newest else "Moving"
        return f"{words} | {self.note}" if self.note else words

    def close(self, patience: float = 0.0) -> None:
        """Ends the render; the thread may live until the dispatch or the scene under way ends."""
        with self._news:
            self._is_open = False
            if self._renderer is not None:
                self._renderer.stop()
            self._news.notify()
        if patience:
            self._thread.join(patience)

    # ------------------------------------------------------------------------------------------------- what the thread does

    def _has_work(self) -> bool:
        if self._scene is not None and self._wish is not None:
            return True
        if self._renderer is None or self.fault:
            return False
        wanted = self._quality
        is_finest = self._wish == self._view and self._pixel == wanted.pixel
        return not is_finest or self._samples < wanted.samples or self._is_denoised != wanted.is_denoised

    def _take(self) -> Optional[tuple[Any, View, Quality]]:
        """Takes what is wished for; None where there is nothing to do."""
        if not self._has_work():
            return None
        scene, self._scene, self._is_busy = self._scene, None, True
        assert self._wish is not None
        return scene, self._wish, self._quality

    def _do(self, scene: Any, view: View, quality: Quality) -> None:
        """Takes one step toward what is wished for."""
        try:
            if scene is not None:
                self._begin(*scene, view, quality)
            elif view != self._view:
                self._follow(view, self._detail.first(view, quality.pixel))
            elif self._pixel != quality.pixel:
                self._follow(view, self._detail.next(view, self._pixel, quality.pixel))
            else:
                self._refine(quality)
        except Exception as fault:  # noqa: BLE001: what ends a picture must be shown
            self.fault = str(fault)
            self._is_changed = True
        finally:
            with self._news:
                self._is_refining = self._is_interrupted = self._is_busy = False
                # Changes that waited for the end of the reading are asked for once more.
                self._is_changed |= scene is not None
                self._is_reading = self._scene is not None

    def _begin(self, scene_file: Path, options: dict[str, Any], view: View, quality: Quality) -> None:
        """Reads a scene. The guide of the one before stays, if it suits."""
        self._is_changed = True
        # A scene that cannot be read leaves what is known to the next one.
        self._before, self._renderer, self._view = self._renderer or self._before, None, None
        pixel = self._detail.first(view, quality.pixel)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            renderer = self._renderer_of(self._before, scene_file, options, view.film(pixel))
        self._before, self._options = None, options
        with self._news:
            self._renderer = renderer
        self._follow(view, pixel)

    def _renderer_of(self, before: Optional[Any], scene_file: Path, options: dict[str, Any], size: tuple[int, int]) -> Any:
        """Render of a scene: the one before, where it can change to it, or another one with as much of it as suits, its device with the
        kernels, and what its guide has learned."""
        width, height = size
        if before is not None and options == self._options:
            try:
                _resize(before, size)
                before.set_scene(str(scene_file))
                return before
            except self._package.Error:
                pass
        options = {**options, "width": width, "height": height}
        for inherited in self._inherited(before, options):
            try:
                return self._package.Renderer(str(scene_file), **{**options, **inherited})
            except self._package.Error:
                continue
        return self._package.Renderer(str(scene_file), **options)

    def _inherited(self, before: Optional[Any], options: dict[str, Any]) -> Iterator[dict[str, Any]]:
        if before is None:
            return
        chosen = options.get("device")
        # A renderer has several devices where they are listed.
        is_one = chosen is None or (chosen != "all" and "," not in chosen)
        device = {"device": before} if is_one and chosen == self._options.get("device") else {}
        settings = before.settings
        # A sampler's guide serves that sampler, and an unguided one has none.
        if options["sampler"] == settings["sampler"] != "bsdf":
            yield {**device, "guide": before.guide, "seed": settings["seed"] + 1}
        if device:
            yield device

    def _follow(self, view: View, pixel: int) -> None:
        """Moves the camera and shows the first picture."""
        renderer = self._renderer
        assert renderer is not None
        _resize(renderer, view.film(pixel))
        renderer.set_camera(view.sensor(pixel))
        is_first = view != self._view
        self._view, self._pixel, self._samples = view, pixel, 0
        with self._news:
            # A view that is wished for gets its first picture, so that one that moves without an end is seen.
            self._is_refining = not is_first
            if not is_first and (self._wish != view or self._scene is not None or not self._is_open):
                return
        self._step(1, False)

    def _refine(self, quality: Quality) -> None:
        """Takes some more samples of a view that rests."""
        assert self._view is not None
        with self._news:
            self._is_refining = True
            if self._wish != self._view or self._scene is not None or not self._is_open:
                return
        left = quality.samples - self._samples
        self._step(self._detail.samples(self._view, self._pixel, left) if left > 0 else 0, quality.is_denoised)

    def _step(self, samples: int, is_denoised: bool) -> None:
        renderer, view = self._renderer, self._view
        assert renderer is not None and view is not None
        if samples > 0:
            begin = time.monotonic()
            self._samples = renderer.step(samples)
            with self._news:
                is_interrupted, self._is_refining, self._is_interrupted = self._is_interrupted, False, False
            if is_interrupted:
                # The picture begins anew by the wish that has stopped it.
                self._view = None
                return
            self._detail.took(view, self._pixel, samples, time.monotonic() - begin)
        if is_denoised and not self._is_denoising_due():
            return
        begin = time.monotonic()
        colors = self._colors(renderer.picture(), is_denoised)
        if is_denoised:
            now = time.monotonic()
            self._denoised = (now, now - begin)
        self._is_denoised = is_denoised
        self._picture = Shown(colors, view, view.covered(self._pixel), self._samples)
        self._is_changed = True

    def _is_denoising_due(self) -> bool:
        """Whether a picture is the last one, or a fourth of the time is not yet spent on denoising."""
        end, seconds = self._denoised
        return self._samples >= self._quality.samples or time.monotonic() - end >= 3.0 * seconds

    def _colors(self, picture: Any, is_denoised: bool) -> np.ndarray:
        radiance, note = picture.radiance, ""
        if is_denoised:
            try:
                radiance = picture.denoise()
            except self._package.Error as fault:
                note = f"not denoised: {fault}"
        self.note = note
        colors = np.empty((*radiance.shape[:2], 4), np.float32)
        colors[..., :3], colors[..., 3] = radiance[::-1], picture.alpha[::-1]
        return colors


def _resize(renderer: Any, size: tuple[int, int]) -> None:
    settings = renderer.settings
    if (settings["width"], settings["height"]) != size:
        renderer.set_size(*size)


def _work(viewport: weakref.ref[Viewport], news: threading.Condition) -> None:
    """Does what a viewport is asked for until it is closed or forgotten."""
    while True:
        with news:
            found = viewport()
            if found is None:
                return
            if not found._is_open:
                found._renderer = found._before = None
                return
            wanted = found._take()
            if wanted is None:
                del found
                news.wait(1.0)
                continue
        found._do(*wanted)
        del found, wanted


_open: weakref.WeakSet[Viewport] = weakref.WeakSet()


@atexit.register
def close_all() -> None:
    """Closes all viewports and waits for their threads, whose device must not outlive the process's end."""
    viewports = list(_open)
    for each in viewports:
        each.close()
    for each in viewports:
        each.close(30.0)
