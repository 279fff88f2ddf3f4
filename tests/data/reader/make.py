"""Writes mitsuba.json beside this file: what Mitsuba 3 makes of rotations, spectra, folders and vertex colors.
Run: python3 make.py"""
import json
import pathlib
import tempfile

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
FOLDER = pathlib.Path(__file__).parent
SENSOR = '<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="2"/><integer name="height" value="2"/></film></sensor>'

SPECTRA = [
    '<spectrum type="uniform" name="radiance"><float name="value" value="2"/></spectrum>',
    '<spectrum type="d65" name="radiance"><float name="scale" value="2"/></spectrum>',
    '<spectrum type="d65" name="radiance"/>',
    '<spectrum type="d65" name="radiance"><rgb name="color" value="1, 2, 3"/></spectrum>',
    '<spectrum type="srgb" name="radiance"><rgb name="color" value="1, 0.2, 0.3"/></spectrum>',
    '<texture type="rawconstant" name="radiance"><vector name="value" value="0.5, 1, 0.3"/></texture>',
    '<texture type="rawconstant" name="radiance"><float name="value" value="0.7"/></texture>',
]

AXES = [([1, 1, 0], 30), ([0, 0, 2], 90), ([0.3, -0.4, 0.1], -110), ([0, 1, 0], 45)]

COLORS = """<shape type="ply"><string name="filename" value="colors.ply"/><emitter type="area">
<texture type="mesh_attribute" name="radiance"><string name="name" value="vertex_color"/></texture></emitter></shape>"""


def rounded(values):
    return [float(f"{value:.7g}") for value in np.ravel(values)]


def seen(body, origin, direction):
    """Radiance that a ray from the point in the direction meets."""
    scene = mi.load_string(f'<scene version="3.0.0">{SENSOR}{body}</scene>')
    interaction = scene.ray_intersect(mi.Ray3f(origin, direction))
    return rounded(interaction.emitter(scene).eval(interaction))


def rotation(axis, angle):
    x, y, z = axis
    body = f'<shape type="rectangle"><transform name="to_world"><rotate x="{x}" y="{y}" z="{z}" angle="{angle}"/></transform></shape>'
    shape = mi.load_string(f'<scene version="3.0.0">{SENSOR}{body}</scene>').shapes()[0]
    matrix = np.array(mi.traverse(shape)["to_world"].matrix)[:3, :3]
    return {"axis": axis, "angle": angle, "rows": rounded(matrix)}


def folder_found():
    """Which of several files of one name is read: the letter of its folder, by the order of <path> elements."""
    result = []
    for order in ["", "a", "b", "ab", "ba"]:
        with tempfile.TemporaryDirectory() as top:
            for scale, name in [(1, "."), (2, "a"), (3, "b")]:
                pathlib.Path(top, name).mkdir(exist_ok=True)
                pathlib.Path(top, name, "m.obj").write_text(f"v 0 0 0\nv {scale} 0 0\nv 0 1 0\nf 1 2 3\n")
            paths = "".join(f'<path value="{name}"/>' for name in order)
            body = f'<shape type="obj"><string name="filename" value="m.obj"/></shape>{paths}'
            pathlib.Path(top, "scene.xml").write_text(f'<scene version="3.0.0">{body}</scene>')
            width = mi.load_file(f"{top}/scene.xml").shapes()[0].bbox().max.x
            result.append({"paths": order, "width": float(width)})
    return result


def main():
    mi.file_resolver().append(str(FOLDER))
    rng = np.random.default_rng(1)
    points = [rounded(rng.uniform(-0.99, 0.99, 2)) for _ in range(32)]
    values = {
        "rotations": [rotation(axis, angle) for axis, angle in AXES],
        "spectra": [
            {"xml": xml, "rgb": seen(f'<shape type="sphere"><emitter type="area">{xml}</emitter></shape>', [0, 0, 4], [0, 0, -1])}
            for xml in SPECTRA
        ],
        "folders": folder_found(),
        "colors": [{"at": [x, y], "rgb": seen(COLORS, [x, y, 4], [0, 0, -1])} for x, y in points],
    }
    lines = ",\n".join(f'"{key}": [\n' + ",\n".join(json.dumps(row) for row in rows) + "\n]" for key, rows in values.items())
    (FOLDER / "mitsuba.json").write_text("{\n" + lines + "\n}\n")


main()
