"""Lobe of Cycles' microfiber sheen: the tables of `src/encode/sheen/table.rs`, which `cargo fmt` then breaks into lines, and values in other directions, `values.json`.

Run in a Python with `bpy` 5.0. A picture has a small square for each roughness (a row) and each cosine of the viewer's direction (a
column), under a sun. The numbers of the lobe are those with which it reflects what Cycles does, by least squares.
"""

import json
import math
import os
import random

import bpy
import numpy as np
from mathutils import Vector

HERE = os.path.dirname(os.path.abspath(__file__))
TABLE = os.path.join(HERE, "../../../src/encode/sheen/table.rs")
ENTRIES = 32
# Cosines in place of 0, at which nothing is seen, and the least roughness of Cycles.
GRAZING, LEAST_ROUGHNESS = (0.002, 0.004, 0.008), 0.001
# Directions of suns: cosines, each with azimuths about the viewer's, in degrees.
SUNS = (
    (0.01, (0, 90, 180)),
    (0.03, (0, 90, 180)),
    (0.06, (0, 60, 120, 180)),
    (0.12, (0, 60, 120, 180)),
    (0.25, (0, 60, 120, 180)),
    (0.5, (0, 90, 180)),
    (0.8, (0, 90, 180)),
    (1.0, (0,)),
)
# Albedo below which the numbers of a lobe are not known.
LEAST_ALBEDO = 1e-4
PICTURE = os.path.join(bpy.app.tempdir, "sheen.exr")


def frame(cosine):
    """Axes of a square: toward the viewer, across, and the normal. The viewer looks along the world's z-axis."""
    sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
    toward, normal = np.array([-cosine, 0.0, sine]), np.array([sine, 0.0, cosine])
    return toward, np.cross(normal, toward), normal


def material(roughness):
    result = bpy.data.materials.new("sheen")
    result.use_nodes = True
    tree = result.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new("ShaderNodeBsdfSheen"), tree.nodes.new("ShaderNodeOutputMaterial")
    node.distribution = "MICROFIBER"
    node.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    node.inputs["Roughness"].default_value = roughness
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return result


def squares(roughnesses, cosines):
    """Scene of the squares, and its sun."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine, cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = "CYCLES", 1, False, False
    cycles.pixel_filter_type, cycles.filter_width, cycles.max_bounces = "BOX", 0.01, 0
    render.resolution_x, render.resolution_y, render.resolution_percentage = len(cosines), len(roughnesses), 100
    render.image_settings.file_format, render.image_settings.color_depth, render.filepath = "OPEN_EXR", "32", PICTURE
    scene.view_settings.view_transform = "Raw"
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", max(len(cosines), len(roughnesses))
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = ((len(cosines) - 1) / 2, (len(roughnesses) - 1) / 2, 10.0)
    light = bpy.data.lights.new("sun", "SUN")
    light.energy, light.angle = 1.0, 0.0
    sun = bpy.data.objects.new("sun", light)
    sun.rotation_mode = "QUATERNION"
    for row, roughness in enumerate(roughnesses):
        corners, faces = [], []
        for column, cosine in enumerate(cosines):
            toward, across, _ = frame(cosine)
            sides = ((-1, -1), (-1, 1), (1, 1), (1, -1))
            faces.append(range(len(corners), len(corners) + 4))
            half = 0.4 / max(cosine, 0.02)
            corners += [tuple(np.array([column, row, 0.0]) + a * half * toward + b * 0.4 * across) for a, b in sides]
        mesh = bpy.data.meshes.new("squares")
        mesh.from_pydata(corners, [], [tuple(face) for face in faces])
        mesh.materials.append(material(roughness))
        thing = bpy.data.objects.new("squares", mesh)
        thing.visible_shadow = False
        scene.collection.objects.link(thing)
    scene.collection.objects.link(scene.camera)
    scene.collection.objects.link(sun)
    return sun


def measure(roughnesses, cosines, directions):
    """For each square, local directions of suns, and f cos of the light from there. `directions` has a list for each column."""
    sun = squares(roughnesses, cosines)
    local, values = [], []
    for column, cosine in enumerate(cosines):
        axes = np.stack(frame(cosine))
        of_column = []
        for direction in directions[column]:
            sun.rotation_quaternion = Vector(np.array(direction) @ axes).to_track_quat("Z", "Y")
            bpy.ops.render.render(write_still=True)
            picture = bpy.data.images.load(PICTURE, check_existing=False)
            picture.colorspace_settings.name = "Non-Color"
            pixels = np.array(picture.pixels[:]).reshape(len(roughnesses), len(cosines), 4)
            bpy.data.images.remove(picture)
            of_column.append(pixels[:, column, 0])
        local.append(directions[column])
        values.append(np.stack(of_column, axis=-1))
    return np.array(local), np.stack(values, axis=1)


def lobe(numbers, w):
    """f cos of a lobe by its numbers: the logarithm of the stretch, the shift, and the logarithm of the albedo."""
    stretch, shift, albedo = np.exp(numbers[..., 0, None]), numbers[..., 1, None], np.exp(numbers[..., 2, None])
    x, y, z = w[None, ..., 0], w[None, ..., 1], w[None, ..., 2]
    squared = (stretch * x + shift * z) ** 2 + (stretch * y) ** 2 + z * z
    return albedo / np.pi * z * (stretch / squared) ** 2


def fitted(local, values, start):
    """Numbers of all lobes, by Levenberg's and Marquardt's method, and their errors."""
    scale = 0.02 * np.maximum(values.max(axis=-1, keepdims=True), 1e-12) + values
    errors = lambda numbers: (lobe(numbers, local) - values) / scale  # noqa: E731
    numbers, damping = start.copy(), np.full(values.shape[:2], 1e-2)
    error = errors(numbers)
    for _ in range(150):
        steps = 1e-5 * np.eye(3)
        slopes = np.stack([(errors(numbers + step) - errors(numbers - step)) / 2e-5 for step in steps], axis=-1)
        matrix = np.einsum("...ki,...kj->...ij", slopes, slopes)
        diagonal = np.eye(3) * (np.einsum("...ii->...i", matrix)[..., None, :] + 1e-9)
        gradient = np.einsum("...ki,...k->...i", slopes, error)
        step = np.linalg.solve(matrix + damping[..., None, None] * diagonal, gradient[..., None])[..., 0]
        tried = (numbers - step.clip(-1.0, 1.0)).clip([-9.0, -2.0, -25.0], [2.0, 2.0, 2.0])
        new = errors(tried)
        better = (new**2).sum(axis=-1) < (error**2).sum(axis=-1)
        numbers[better], error[better] = tried[better], new[better]
        damping = np.where(better, np.maximum(0.2 * damping, 1e-12), np.minimum(5.0 * damping, 1e8))
    return numbers, (error**2).sum(axis=-1)


def best(local, values, roughnesses):
    starts = []
    for stretch, shift in ((1.0, -0.03), (0.6, -0.1), (0.3, -0.05)):
        rough = np.broadcast_to(np.maximum(roughnesses, 0.03)[:, None], values.shape[:2])
        starts.append(np.stack([np.log(stretch * rough), np.full_like(rough, shift), np.log(0.3 * rough**2)], axis=-1))
    found = [fitted(local, values, start) for start in starts]
    first = np.argmin([error for _, error in found], axis=0)
    return np.take_along_axis(np.stack([numbers for numbers, _ in found]), first[None, ..., None], axis=0)[0]


def at_zero(values):
    """Values with a first column for the cosine 0, along which Cycles interpolates, in place of those near it."""
    nearby = np.array(GRAZING)[None, :] * (ENTRIES - 1)
    first = (values[:, : len(GRAZING)] - nearby * values[:, len(GRAZING), None]) / (1.0 - nearby)
    return np.concatenate([first.mean(axis=1, keepdims=True), values[:, len(GRAZING) :]], axis=1)


def tables():
    """Stretch, shift away from the viewer, and albedo."""
    equal = np.arange(1, ENTRIES) / (ENTRIES - 1.0)
    roughnesses, cosines = np.array([LEAST_ROUGHNESS, *equal]), [*GRAZING, *equal]
    suns = [(math.sqrt(1 - z * z) * math.cos(math.radians(p)), math.sqrt(1 - z * z) * math.sin(math.radians(p)), z) for z, all_ in SUNS for p in all_]
    numbers = best(*measure(roughnesses, cosines, [suns] * len(cosines)), roughnesses)
    albedo = np.exp(numbers[..., 2])
    known = (albedo > LEAST_ALBEDO)[:, len(GRAZING) - 1 :]
    known[0] = False
    stretch, shift, albedo = (at_zero(each) for each in (np.exp(numbers[..., 0]), -numbers[..., 1], albedo))
    albedo[0] = np.maximum(albedo[0] - LEAST_ROUGHNESS * (ENTRIES - 1) * albedo[1], 0.0)
    albedo[albedo < 0.3 * LEAST_ALBEDO] = 0.0
    # Smooth fibers reflect next to nothing: their lobes shrink in proportion to the roughness.
    for column in range(ENTRIES):
        first = int(np.flatnonzero(known[:, column])[0])
        for row in range(first):
            stretch[row, column] = stretch[first, column] * max(row, 0.3) / first
            shift[row, column] = shift[first, column] * row / first
    shift[:, -1] = 0.0
    return stretch.clip(0.005, 1.0), shift.clip(0.0, 1.0), albedo.clip(0.0, 1.0)


def write_tables():
    lines = [
        "//! Tables of the sheen's lobe: a row is a roughness, a column a cosine of the viewer's direction, both from 0 to 1 in equal steps.",
        "//!",
        "//! `tests/data/sheen/measure.py` writes this file: it fits the lobe to the light that Cycles 5.0 reflects.",
        "",
        "use crate::generated::constants::SHEEN_ENTRIES;",
        "",
        "const ENTRIES: usize = SHEEN_ENTRIES as usize;",
        "/// Numbers for each roughness and each cosine, in units of 1 / 65535.",
        "pub type Table = [[u16; ENTRIES]; ENTRIES];",
    ]
    docs = (
        ("STRETCHES", "Factor of directions along the surface"),
        ("SHIFTS", "What a direction along the normal adds to those along the surface, away from the viewer"),
        ("ALBEDOS", "Share of light that the sheen reflects"),
    )
    for (name, doc), table in zip(docs, tables()):
        rows = [f"    [{', '.join(str(round(65535 * x)) for x in row)}]," for row in table]
        lines += ["", f"/// {doc}, in units of 1 / 65535.", f"pub const {name}: Table = [", *rows, "];"]
    with open(TABLE, "w") as file:
        file.write("\n".join(lines) + "\n")


def write_values():
    """Values between the entries of the table."""
    numbers = random.Random(3)
    roughnesses, cosines = ([numbers.uniform(*limits) for _ in range(8)] for limits in ((0.15, 1.0), (0.1, 1.0)))
    suns = []
    for _ in cosines:
        column = [(numbers.uniform(0.05, 1.0), numbers.uniform(-math.pi, math.pi)) for _ in range(4)]
        suns.append([(math.sqrt(1 - z * z) * math.cos(p), math.sqrt(1 - z * z) * math.sin(p), z) for z, p in column])
    local, values = measure(np.array(roughnesses), cosines, suns)
    rows = []
    for (row, column, sun), value in np.ndenumerate(values):
        wo = [math.sqrt(1 - cosines[column] ** 2), 0.0, cosines[column]]
        case = {"roughness": roughnesses[row], "wo": wo, "wi": list(local[column, sun]), "value": float(value)}
        rows.append(json.dumps({k: [float(f"{x:.7g}") for x in v] if isinstance(v, list) else float(f"{v:.7g}") for k, v in case.items()}))
    with open(os.path.join(HERE, "values.json"), "w") as file:
        file.write("[\n" + ",\n".join(rows) + "\n]\n")


if __name__ == "__main__":
    write_values()
    write_tables()
