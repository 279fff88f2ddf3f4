#!/usr/bin/env python3
"""Renders models in glTF that nobody of this project made, and compares with another renderer.

    tests/real_files/gltf.py LODESTAR mitsuba    (pip install mitsuba numpy)
    tests/real_files/gltf.py LODESTAR cycles     (Python 3.11; pip install bpy numpy)

LODESTAR_REAL_MODELS names the folder of the models, a copy of the repository that gltf.tsv names; without it, nothing is done. The
models of gltf.tsv are tried. A model without a light gets light of radiance 1 from all sides.

mitsuba: `lodestar convert` writes each model as a Mitsuba file. Mitsuba renders it, and Lodestar renders the model. The means of
4 x 4 blocks must agree: |z| < 5, as in run.py. Every file must load in Mitsuba.

cycles: Blender reads the model with its own reader, and Cycles renders it from Lodestar's camera. The largest deviation of a block,
relative to the block or a fifth of the picture's mean, and the ratio of the means must lie within the bounds of gltf.tsv. A model's
colors, its geometry and its light are compared, but the two Principled BSDFs are different models."""
import doctest
import os
import pathlib
import re
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import run  # noqa: E402

LIGHT = '<emitter type="constant"><rgb name="radiance" value="1"/></emitter>'
SAMPLES_OF_CYCLES, BOUNCES = 256, 8
# A principled surface of a white base color reflects more light than it gets, so that unbounded paths have no sum.
PLAIN = '<integrator type="path"/>'
BOUNDED = f'<integrator type="path"><integer name="max_depth" value="{BOUNCES + 1}"/></integrator>'


def models():
    """Paths of the models with their bounds."""
    lines = pathlib.Path(__file__).with_name("gltf.tsv").read_text(encoding="utf8").splitlines()
    rows = [line.split("\t") for line in lines if line and not line.startswith("#")]
    return [(path, float(block), float(whole)) for path, block, whole, *_ in rows]


def lit(text):
    """Scene with a light, where it has none.

    >>> lit('<scene version="3.0.0">\\n</scene>').count("constant")
    1
    >>> lit('<scene version="3.0.0"><emitter type="point"/></scene>').count("constant")
    0
    """
    return text if "<emitter" in text else text.replace("</scene>", LIGHT + "</scene>")


def converted(lodestar, model, folder):
    """Mitsuba file that `lodestar convert` makes of a model, with light."""
    import subprocess

    out = pathlib.Path(folder) / "converted.xml"
    subprocess.run([lodestar, "convert", model, out], capture_output=True, check=True)
    text = lit(out.read_text(encoding="utf8"))
    assert PLAIN in text, "the converted file names its integrator"
    # Mitsuba keeps the horizontal field of view when a film's size changes later.
    text = re.sub(r'(name="(?:width|height)" value=")\d+', rf"\g<1>{run.SIZE}", text)
    out.write_text(text.replace(PLAIN, BOUNDED), encoding="utf8")
    return out


def with_mitsuba(lodestar, model, _block, _whole):
    with tempfile.TemporaryDirectory() as folder:
        agrees, message = run.compare(lodestar, converted(lodestar, model, folder))
    return bool(agrees), message


def camera_of(text):
    """Camera's matrix, row by row, and its field of view in radians, from a converted file."""
    import numpy as np

    numbers = re.search(r'<matrix value="([^"]*)"', text[text.index("<sensor") :])[1]
    fov = re.search(r'name="fov" value="([^"]*)"', text)[1]
    return np.array(numbers.split(), float).reshape(4, 4), np.radians(float(fov))


def by_cycles(model, text):
    import bpy
    import mathutils
    import numpy as np

    sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "addons" / "blender" / "lodestar"))
    import exr

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(model))
    scene = bpy.context.scene
    matrix, fov = camera_of(text)
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit, camera.angle, camera.clip_start, camera.clip_end = "HORIZONTAL", fov, 1e-4, 1e6
    seen = bpy.data.objects.new("camera", camera)
    # Mitsuba's camera has +x to the left and looks along +z; Blender's world has +z up.
    upright = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], float)
    seen.matrix_world = mathutils.Matrix((upright @ matrix @ np.diag([-1, 1, -1, 1])).tolist())
    scene.collection.objects.link(seen)
    scene.camera = seen
    if LIGHT in text:
        scene.world = bpy.data.worlds.new("world")
        scene.world.use_nodes = True
        scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples, cycles.device = SAMPLES_OF_CYCLES, "CPU"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    for kind in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
        setattr(cycles, f"{kind}_bounces", BOUNCES)
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.pixel_filter_type, cycles.filter_width, cycles.light_sampling_threshold = "BOX", 1.0, 0.0
    scene.render.resolution_x = scene.render.resolution_y = run.SIZE
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = f"{folder}/cycles.exr"
        bpy.ops.render.render(write_still=True)
        picture = exr.read(pathlib.Path(scene.render.filepath))
    prefix = next(name for name in picture.channels if name.split(".")[-1] == "R")[:-1]
    return picture.layer([prefix + channel for channel in "RGB"])


def with_cycles(lodestar, model, block, whole):
    import numpy as np

    with tempfile.TemporaryDirectory() as folder:
        scene = converted(lodestar, model, folder)
        theirs = run.block_means(by_cycles(model, scene.read_text(encoding="utf8")))
        out = f"{folder}/ours.exr"
        more = ["--spp", "512", "--rfilter", "box"]
        run.render(lodestar, scene, out, *more).check_returncode()
        import exr

        ours = run.block_means(exr.read(pathlib.Path(out)).layer(["R", "G", "B"]))
    deviation = float(np.max(np.abs(ours - theirs) / np.maximum(theirs, 0.2 * theirs.mean())))
    ratio = float(ours.mean() / theirs.mean())
    message = f"largest deviation of a block {deviation:.3f}, mean {ratio:.4f} of Cycles's"
    return deviation < block and abs(ratio - 1.0) < whole, message


def main():
    if len(sys.argv) != 3 or sys.argv[2] not in ("mitsuba", "cycles"):
        print(__doc__)
        return 2
    if doctest.testmod().failed:
        return 1
    folder = os.environ.get("LODESTAR_REAL_MODELS")
    if not folder:
        print("skipped: LODESTAR_REAL_MODELS names no folder of models")
        return 0
    compare = {"mitsuba": with_mitsuba, "cycles": with_cycles}[sys.argv[2]]
    faults = 0
    for path, block, whole in models():
        agrees, message = compare(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(folder, path).resolve(), block, whole)
        faults += not agrees
        print(f"{'agrees' if agrees else 'differs'}  {path}  {message}", flush=True)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
