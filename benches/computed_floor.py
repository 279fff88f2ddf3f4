#!/usr/bin/env python3
"""Compares a floor with noise, ramp and bump with the same floor with one image, in Cycles and in Lodestar.

    LODESTAR=BINARY benches/computed_floor.py FOLDER [SAMPLES]

It needs a Python with `bpy`, such as that of addons/blender/test.sh. For each renderer it prints the seconds of SAMPLES (256) samples less
those of one sample, the least of three runs, of both floors, and their ratio. The folder gets both scenes as Lodestar reads them, for
benches/instructions.sh, whose counts do not depend on what else the machine does.
"""

import os
import pathlib
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "addons" / "blender"), str(ROOT / "addons" / "blender" / "tests")]

import bpy  # noqa: E402
import lodestar  # noqa: E402
import numpy as np  # noqa: E402
import scenes  # noqa: E402
import support  # noqa: E402
from lodestar import export, process  # noqa: E402


def image(tree):
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = scenes.image("floor", np.random.default_rng(1).random((64, 64, 3), np.float32))
    return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=texture.outputs["Color"]).outputs[0]


def computed(tree):
    noise, ramp, bump = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexNoise", "ValToRGB", "Bump"))
    noise.inputs["Scale"].default_value = 3.0
    tree.links.new(noise.outputs[0], ramp.inputs[0])
    tree.links.new(noise.outputs[0], bump.inputs["Height"])
    inputs = {"Color": ramp.outputs[0], "Normal": bump.outputs[0]}
    return scenes.shader(tree, "ShaderNodeBsdfDiffuse", **inputs).outputs[0]


def floor(build):
    """A floor under a lamp and a gray sky, and a ball on it."""
    scene = scenes.empty()
    scene.render.resolution_x, scene.render.resolution_y = 256, 192
    scenes.camera(scene)
    scenes.plane(scene, "floor", 12, scenes.material("floor", build))
    scenes.ball(scene, "ball", 0.7, scenes.diffuse("gray", (0.5, 0.5, 0.5)), location=(0, 0, 0.7))
    scenes.lamp(scene, "AREA", (1, -1, 4), energy=200.0)
    scenes.world(scene, (0.3, 0.3, 0.3))
    return scene


def seconds(scene, engine, samples):
    times = []
    for _ in range(3):
        begin = time.perf_counter()
        support.render(scene, engine, samples)
        times.append(time.perf_counter() - begin)
    return min(times)


def main():
    if len(sys.argv) not in (2, 3) or "LODESTAR" not in os.environ:
        sys.exit(__doc__.strip())
    folder, samples = pathlib.Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 256
    find = process.find
    process.find = lambda preferred: find(preferred or os.environ["LODESTAR"])
    lodestar.register()
    times = {}
    for build in (image, computed):
        scene = floor(build)
        place = folder / build.__name__
        place.mkdir(parents=True, exist_ok=True)
        export.export(bpy.context.evaluated_depsgraph_get(), place, export.Options())
        for engine in ("CYCLES", "LODESTAR"):
            times[engine, build] = seconds(scene, engine, samples) - seconds(scene, engine, 1)
    print("| renderer | one image | noise, ramp and bump | ratio |\n|---|---|---|---|")
    for engine in ("CYCLES", "LODESTAR"):
        first, second = times[engine, image], times[engine, computed]
        print(f"| {engine.capitalize()} | {first:.2f} s | {second:.2f} s | {second / first:.2f} |")


main()
