"""Writes the picture of docs/blender.md: a scene by Cycles above, and by Lodestar below.

usage: LODESTAR=PROGRAM python addons/blender/tests/picture.py FILE.jpg    (needs bpy and pillow)
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

import lodestar  # noqa: E402
import scenes  # noqa: E402
import support  # noqa: E402
from lodestar import process  # noqa: E402
from PIL import Image  # noqa: E402


def main() -> None:
    find = process.find
    process.find = lambda preferred: find(preferred or support.PROGRAM)
    lodestar.register()
    scene = scenes.glass()
    scene.render.resolution_x, scene.render.resolution_y = 320, 140
    scenes.camera(scene, (0, -6.2, 1.8), (0, 0, 0.7), lens=40)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.35
    theirs, ours = (support.colors(support.render(scene, engine, 256)) for engine in ("CYCLES", "LODESTAR"))
    both = np.concatenate([theirs, np.ones((4, 320, 3)), ours])
    encoded = np.where(both <= 0.0031308, both * 12.92, 1.055 * np.maximum(both, 1e-9) ** (1 / 2.4) - 0.055)
    Image.fromarray((np.clip(encoded, 0, 1) * 255).round().astype(np.uint8)).save(sys.argv[1], quality=90)


if __name__ == "__main__":
    main()
