"""Writes scene.xml, one shape every four units along x, and hits.json: what Mitsuba 3 finds where rays hit them."""

import json
import os

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
FOLDER = os.path.dirname(os.path.abspath(__file__))
RAYS_PER_SHAPE = 16

TURNED = '<rotate x="0.36" y="0.48" z="-0.8" angle="37" />'
STRETCHED = '<scale x="0.6" y="1.2" z="0.8" />'
HALF = '<scale value="0.7" />'
MIRRORED = '<scale x="-1" y="1" z="1" />'
FLIPPED = '<boolean name="flip_normals" value="true" />'
FLAT = '<boolean name="face_normals" value="true" />'


def mesh(name):
    return f'<string name="filename" value="{name}.obj" />'


# Plugin, transform, other parameters.
SHAPES = [
    ("rectangle", STRETCHED + TURNED, ""),
    ("rectangle", MIRRORED + TURNED, ""),
    ("rectangle", TURNED, FLIPPED),
    ("disk", STRETCHED + TURNED, ""),
    ("disk", MIRRORED + TURNED, FLIPPED),
    ("cube", HALF + STRETCHED + TURNED, ""),
    ("sphere", HALF + TURNED, ""),
    ("sphere", HALF + MIRRORED + TURNED, ""),
    ("sphere", TURNED, FLIPPED),
    ("obj", STRETCHED + TURNED, mesh("uv")),
    ("obj", TURNED, mesh("uv") + FLAT),
    ("obj", TURNED, mesh("uv") + FLIPPED),
    ("obj", MIRRORED + TURNED, mesh("uv")),
    ("obj", TURNED, mesh("plain") + FLAT),
    ("obj", TURNED, mesh("degenerate") + FLAT),
]


def shape(index):
    plugin, transform, rest = SHAPES[index]
    place = f'<translate x="{4 * index}" />'
    return (
        f'\t<shape type="{plugin}">\n\t\t{rest}<transform name="to_world">{transform}{place}</transform>\n'
        '\t\t<bsdf type="diffuse" />\n\t</shape>\n'
    )


def scene():
    sensor = (
        '\t<sensor type="perspective">\n\t\t<film type="hdrfilm">\n\t\t\t<rfilter type="box" />\n\t\t</film>\n\t</sensor>\n'
    )
    shapes = "".join(shape(index) for index in range(len(SHAPES)))
    return f'<scene version="3.0.0">\n\t<integrator type="path" />\n{sensor}{shapes}</scene>\n'


def ray(random, index):
    target = np.array([4 * index, 0, 0]) + random.uniform(-0.7, 0.7, 3)
    direction = random.normal(size=3)
    direction /= np.linalg.norm(direction)
    return np.round(target - 1.9 * direction, 5).tolist(), np.round(direction, 6).tolist()


def hits(world):
    random = np.random.default_rng(3)
    found = []
    for index in range(len(SHAPES)):
        count = 0
        while count < RAYS_PER_SHAPE:
            origin, direction = ray(random, index)
            si = world.ray_intersect(mi.Ray3f(mi.Point3f(origin), mi.Vector3f(direction)))
            # A shape's own hits only, and none from inside, where Mitsuba starts some rays on the other side.
            if not si.is_valid() or abs(si.p.x - 4 * index) > 2:
                continue
            count += 1
            frame = si.sh_frame
            values = {"p": si.p, "uv": si.uv, "dp_du": si.dp_du, "dp_dv": si.dp_dv, "s": frame.s, "t": frame.t}
            values = {name: [round(float(x), 6) for x in value] for name, value in values.items()}
            found.append({"origin": origin, "direction": direction, "plugin": SHAPES[index][0], **values})
    return found


if __name__ == "__main__":
    path = os.path.join(FOLDER, "scene.xml")
    with open(path, "w") as file:
        file.write(scene())
    lines = ",\n".join(json.dumps(hit) for hit in hits(mi.load_file(path, optimize=False)))
    with open(os.path.join(FOLDER, "hits.json"), "w") as file:
        file.write(f"[\n{lines}\n]\n")
