"""Rendering of a scene by Cycles and by Lodestar, and the comparison of block means."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any, Optional

import bpy
import numpy as np

import lodestar
from lodestar import exr

BLOCK = 16
BOUNCES = 12
FOLDER = Path(tempfile.mkdtemp(prefix="lodestar-blender-"))
PROGRAM = os.environ.get("LODESTAR", "lodestar")


def render(scene: Any, engine: str, samples: int, name: str = "picture", bounces: Optional[int] = BOUNCES) -> exr.Picture:
    """Picture of a scene, with all passes. Paths of Lodestar have two edges more than Cycles' have bounces, or no limit."""
    scene.render.engine = engine
    scene.render.filepath = str(FOLDER / f"{name}-{engine.lower()}.exr")
    if engine == "CYCLES":
        assert bounces is not None
        _prepare_cycles(scene, samples, bounces)
    else:
        settings = scene.lodestar
        settings.samples, settings.filter = samples, "box"
        settings.use_max_depth, settings.max_depth = bounces is not None, (bounces or 0) + 2
        for each in ("albedo", "normal", "depth", "variance"):
            setattr(settings, f"pass_{each}", True)
    bpy.ops.render.render(write_still=True)
    return exr.read(Path(scene.render.filepath))


def _prepare_cycles(scene: Any, samples: int, bounces: int) -> None:
    cycles = scene.cycles
    cycles.samples, cycles.device = samples, "CPU"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    for kind in ("max", "diffuse", "glossy", "transmission", "volume", "transparent_max"):
        setattr(cycles, f"{kind}_bounces", bounces)
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.light_sampling_threshold, cycles.use_light_tree = 0.0, False


def colors(picture: exr.Picture) -> np.ndarray:
    """Combined pass."""
    prefix = next(name for name in picture.channels if name.endswith("Combined.R"))[:-1]
    layer = picture.layer([prefix + channel for channel in "RGB"])
    assert layer is not None
    return layer


def block_means(image: np.ndarray, side: int = BLOCK) -> np.ndarray:
    """Means of blocks of side x side pixels; what does not fill a block at the right and at the bottom is left out."""
    rows, columns = image.shape[0] // side, image.shape[1] // side
    cut = image[: rows * side, : columns * side]
    return cut.reshape(rows, side, columns, side, 3).mean(axis=(1, 3))


def deviation(ours: np.ndarray, theirs: np.ndarray, side: int = BLOCK) -> float:
    """Largest difference of block means, relative to the block and, where it is dark, to a fifth of the picture."""
    a, b = block_means(ours, side), block_means(theirs, side)
    return float(np.max(np.abs(a - b) / np.maximum(b, 0.2 * b.mean())))


def mean_ratio(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Mean of one picture over that of the other."""
    return float(ours.mean() / theirs.mean())
