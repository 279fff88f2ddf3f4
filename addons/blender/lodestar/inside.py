"""Inside: a render within Blender's process, by the Python package that the extension bundles."""

from __future__ import annotations

import importlib
import os
import queue
import shlex
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, Optional

import numpy as np

from . import exr
from .process import Event


def package() -> Optional[Any]:
    """The package `lodestar`; None where it is not installed or cannot be loaded, as in an extension for another system."""
    try:
        found = importlib.import_module("lodestar")
    except ImportError:
        return None
    return found if hasattr(found, "Renderer") else None


def command(found: Any) -> list[str]:
    """Command line of the package as a program, which runs in a process of its own."""
    return [sys.executable, "-m", found.__name__]


def environment(found: Any) -> dict[str, str]:
    """Environment in which Python finds the package."""
    folder = str(Path(found.__file__).parent.parent)
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [folder, os.environ.get("PYTHONPATH")]))}


def keywords(line: str, known: list[dict[str, Any]]) -> dict[str, str | bool]:
    """Options of a command line as keywords of `known` options. A ValueError names an option that only the program has."""
    types = {each["name"]: each["type"] for each in known}
    words, found = shlex.split(line), {}
    while words:
        name, has_value, value = words.pop(0).partition("=")
        keyword = name[2:].replace("-", "_")
        if not name.startswith("--") or keyword not in types:
            raise ValueError(f"{name} cannot be among More Options, unless the preferences name a program; see `lodestar render --help`")
        if types[keyword] == "bool":
            found[keyword] = True
        elif has_value or words:
            found[keyword] = value if has_value else words.pop(0)
        else:
            raise ValueError(f"{name} has no value among More Options")
    return found


class Wanted(NamedTuple):
    """What a render shows besides its last picture."""

    seconds_between_pictures: float
    is_denoised: bool


class Inside:
    """A render that runs in a thread of this process."""

    def __init__(self, renderers: Any, scene_file: Path, settings: dict[str, Any], wanted: Wanted) -> None:
        self.failure: Optional[str] = None
        self._package, self._scene_file, self._settings, self._wanted = renderers, scene_file, settings, wanted
        self._events: queue.Queue[Event | None] = queue.Queue()
        self._stop = threading.Event()
        self._renderer: Optional[Any] = None
        self._picture: Optional[exr.Picture] = None
        self._shown = time.monotonic()
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def _work(self) -> None:
        try:
            self._render()
        except Exception as fault:  # noqa: BLE001: what ends the thread must be shown
            self.failure = str(fault)
        finally:
            self._renderer = None
            self._events.put(None)

    def _render(self) -> None:
        self._events.put({"event": "preparing", "message": "Reading the scene"})
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            renderer = self._package.Renderer(str(self._scene_file), **self._settings)
        for each in found:
            self._events.put({"event": "warning", "message": str(each.message)})
        self._renderer = renderer
        if self._stop.is_set():
            return
        last = renderer.run(self._after_step)
        if renderer.samples > 0:
            self._picture = self._channels(last, self._wanted.is_denoised)

    def _after_step(self, renderer: Any) -> bool:
        """Tells of a step. Whether the render goes on."""
        self._events.put({"event": "step", "fraction": renderer.fraction, "samples": renderer.samples, "seconds": renderer.seconds})
        if time.monotonic() - self._shown >= self._wanted.seconds_between_pictures:
            self._events.put({"event": "written", "picture": self._channels(renderer.picture(), False)})
            self._shown = time.monotonic()
        return not self._stop.is_set()

    @staticmethod
    def _channels(picture: Any, is_denoised: bool) -> exr.Picture:
        """Layers of a picture by the names that they have in its file."""
        colors = {"": picture.radiance, "albedo.": picture.albedo, "variance.": picture.variance}
        if is_denoised:
            colors["denoised."] = picture.denoise()
        channels = {f"{layer}{name}": values[..., at] for layer, values in colors.items() for at, name in enumerate("RGB")}
        channels.update({f"normal.{name}": picture.normal[..., at] for at, name in enumerate("XYZ")})
        channels.update({"A": picture.alpha, "depth.Z": picture.depth})
        height, width = np.shape(picture.alpha)
        return exr.Picture(channels, (0, 0), (width, height))

    def events(self, patience: float = 0.1) -> Iterator[Event | None]:
        """Events until the render ends; None whenever `patience` seconds have passed without one."""
        while True:
            try:
                event = self._events.get(timeout=patience)
            except queue.Empty:
                yield None
                continue
            if event is None:
                return
            yield event

    def stop(self) -> None:
        """Ends the render with the picture so far."""
        self._stop.set()
        renderer = self._renderer
        if renderer is not None:
            renderer.stop()

    def close(self) -> None:
        """Ends the render and waits for it."""
        self.stop()
        self._thread.join()

    def picture(self) -> Optional[exr.Picture]:
        """The last picture; None where there is none."""
        return self._picture
