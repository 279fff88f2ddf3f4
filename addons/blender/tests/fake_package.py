"""A package in the place of the renderer's, which notes what it is asked for."""

from __future__ import annotations

import threading
import time
from typing import Any

import numpy as np


class Error(Exception):
    """As the package has it."""


class Picture:
    def __init__(self, width: int, height: int, value: float) -> None:
        self.radiance = np.full((height, width, 3), value, np.float32)
        self.alpha = np.ones((height, width), np.float32)

    def denoise(self) -> np.ndarray:
        if Renderer.denoises:
            return 2.0 * self.radiance
        raise Error("Open Image Denoise was not found")


class Renderer:
    """Takes `seconds` for a sample of 64 x 64 pixels, and looks for a stop each millisecond."""

    seconds, seconds_to_read, denoises, refused = 0.001, 0.0, False, ""
    all: list[Any] = []
    # Scenes that were read.
    texts: list[str] = []
    alive = 0

    def __init__(self, scene: str, **options: Any) -> None:
        self.text = _read(scene)
        # As the real one, it keeps the device, not the other renderer.
        device = options.get("device")
        self.options = {**options, "device": id(device) if isinstance(device, Renderer) else device}
        self.samples, self.calls = 0, []
        self.settings = {"sampler": options["sampler"], "seed": options["seed"], "width": options["width"], "height": options["height"]}
        self.learned = set(options["guide"]) if "guide" in options else set()
        if options["seed"] in self.learned:
            raise Error("the guide has learned from these samples")
        self._is_stopped = threading.Event()
        Renderer.all.append(self)
        Renderer.alive += 1

    def __del__(self) -> None:
        if hasattr(self, "calls"):
            Renderer.alive -= 1

    @property
    def guide(self) -> frozenset[int]:
        """Seeds of the samples from which it has learned."""
        return frozenset(self.learned)

    def step(self, samples: int) -> int:
        width, height = self.settings["width"], self.settings["height"]
        end = time.monotonic() + samples * Renderer.seconds * width * height / 64**2
        while time.monotonic() < end:
            if self._is_stopped.is_set():
                return self.samples
            time.sleep(0.001)
        if self._is_stopped.is_set():
            return self.samples
        self.samples += samples
        self.learned.add(self.settings["seed"])
        self.calls.append(("step", samples))
        return self.samples

    def stop(self) -> None:
        self._is_stopped.set()

    def set_scene(self, scene: str) -> None:
        self.text = _read(scene)
        self._begin_anew(("scene", scene))

    def set_camera(self, camera: dict[str, Any]) -> None:
        if camera["near_clip"] > camera["far_clip"]:
            raise Error("the far plane must lie behind the near one")
        self._begin_anew(("camera", camera))

    def set_size(self, width: int, height: int) -> None:
        self.settings.update(width=width, height=height)
        self._begin_anew(("size", (width, height)))

    def _begin_anew(self, call: tuple[str, Any]) -> None:
        self.samples = 0
        self.calls.append(call)
        while self.settings["seed"] in self.learned:
            self.settings["seed"] += 1
        self._is_stopped.clear()

    def picture(self) -> Picture:
        return Picture(self.settings["width"], self.settings["height"], float(self.samples))


def _read(scene: str) -> str:
    if Renderer.refused:
        raise Error(Renderer.refused)
    with open(scene, encoding="utf-8") as file:
        text = file.read()
    time.sleep(Renderer.seconds_to_read)
    Renderer.texts.append(text)
    return text


def options() -> list[dict[str, Any]]:
    return [{"name": "grid", "type": "str"}]


def reset() -> None:
    Renderer.seconds, Renderer.seconds_to_read, Renderer.denoises, Renderer.refused = 0.001, 0.0, False, ""
    Renderer.all, Renderer.texts = [], []
