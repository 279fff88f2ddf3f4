#!/usr/bin/env python3
"""Writes a forest of instances, for measurements of what a ray costs among them.

    benches/forest.py TREES TRIANGLES FOLDER

Each tree has about so many triangles, and stands turned and scaled at a random place of a square that keeps the distance between trees. The
folder gets scene.xml, which Mitsuba 3 reads, too, and tree.ply.
"""

import array
import math
import pathlib
import random
import sys

SCENE = """<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="4"/></integrator>
<sensor type="perspective">
<float name="fov" value="60"/>
<transform name="to_world"><lookat origin="0, 9, -30" target="0, 3, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="128"/><integer name="height" value="96"/><rfilter type="box"/></film>
</sensor>
<emitter type="constant"/>
<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="SIDE"/></transform></shape>
<shape type="shapegroup" id="tree"><shape type="ply"><string name="filename" value="tree.ply"/></shape></shape>
"""


def leaf(numbers):
    """Three corners of a leaf in the crown of a tree of the height 6."""
    direction = [numbers.gauss(0.0, 1.0) for _ in range(3)]
    length = math.sqrt(sum(x * x for x in direction)) or 1.0
    radius = 2.0 * numbers.random() ** (1.0 / 3.0)
    center = [radius * x / length + (4.0 if axis == 1 else 0.0) for axis, x in enumerate(direction)]
    return [[x + numbers.uniform(-0.1, 0.1) for x in center] for _ in range(3)]


def write_tree(path, count, numbers):
    """A trunk of eight triangles, and leaves."""
    ring = [(0.2 * math.cos(math.pi / 2 * i), 0.2 * math.sin(math.pi / 2 * i)) for i in range(4)]
    corners = []
    for (x0, z0), (x1, z1) in zip(ring, ring[1:] + ring[:1]):
        corners += [(x0, 0, z0), (x1, 0, z1), (x1, 4, z1), (x0, 0, z0), (x1, 4, z1), (x0, 4, z0)]
    for _ in range(max(count - 8, 0)):
        corners += leaf(numbers)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(corners)}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += f"element face {len(corners) // 3}\nproperty list uchar int vertex_indices\nend_header\n"
    with open(path, "wb") as file:
        file.write(header.encode())
        file.write(array.array("f", [x for corner in corners for x in corner]).tobytes())
        for first in range(0, len(corners), 3):
            file.write(b"\3" + array.array("i", range(first, first + 3)).tobytes())


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__.strip())
    trees, triangles, folder = int(sys.argv[1]), int(sys.argv[2]), pathlib.Path(sys.argv[3])
    folder.mkdir(parents=True, exist_ok=True)
    numbers = random.Random(48)
    write_tree(folder / "tree.ply", triangles, numbers)
    side = 2.5 * math.sqrt(trees)
    with open(folder / "scene.xml", "w", encoding="utf-8") as file:
        file.write(SCENE.replace("SIDE", f"{side + 20:.1f}"))
        for _ in range(trees):
            x, z = numbers.uniform(-side, side), numbers.uniform(-side, side)
            angle, scale = numbers.uniform(0.0, 360.0), numbers.uniform(0.6, 1.2)
            file.write(
                f'<shape type="instance"><ref id="tree"/><transform name="to_world"><rotate y="1" angle="{angle:.2f}"/>'
                f'<scale value="{scale:.3f}"/><translate x="{x:.3f}" z="{z:.3f}"/></transform></shape>\n'
            )
        file.write("</scene>\n")


main()
