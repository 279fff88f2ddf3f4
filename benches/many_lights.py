#!/usr/bin/env python3
"""Writes a scene of sixteen rooms with many small lamps, for measurements of light selection.

    benches/many_lights.py LAMPS FOLDER

Each room is 4 x 4 x 3 m and has a door to each neighbor. The lamps are squares of 2 cm below the ceilings, at random places. Each
is two triangles, so there are twice as many lights as lamps. The camera stands in one room. The folder gets scene.xml, rooms.obj
and lamps.obj.
"""

import pathlib
import random
import sys

ROOMS, SIDE, HEIGHT = 4, 4.0, 3.0
DOOR, DOOR_HEIGHT, LAMP = 1.0, 2.2, 0.02

SCENE = """<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="8"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="75"/>
    <transform name="to_world"><lookat origin="4.4, 1.6, 4.4" target="7.0, 1.3, 7.6" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="128"/><integer name="height" value="96"/></film>
  </sensor>
  <shape type="obj">
    <string name="filename" value="rooms.obj"/>
    <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.6, 0.6"/></bsdf></bsdf>
  </shape>
  <shape type="obj">
    <string name="filename" value="lamps.obj"/>
    <bsdf type="diffuse"/>
    <emitter type="area"><rgb name="radiance" value="RADIANCE, RADIANCE, RADIANCE"/></emitter>
  </shape>
</scene>
"""


def write_obj(path, quads):
    """Quads of four corners each, as a Wavefront OBJ file."""
    with open(path, "w", encoding="utf-8") as file:
        for quad in quads:
            for corner in quad:
                file.write("v {:.5f} {:.5f} {:.5f}\n".format(*corner))
        for first in range(1, 4 * len(quads), 4):
            file.write(f"f {first} {first + 1} {first + 2}\nf {first} {first + 2} {first + 3}\n")


def level(height, low, high):
    """A quad at a height, between two points of the floor plan, that faces down."""
    (x0, z0), (x1, z1) = low, high
    return [(x0, height, z0), (x1, height, z0), (x1, height, z1), (x0, height, z1)]


def wall(at, begin, end, low, high, along_x):
    """A quad across the floor plan, between two heights."""
    corners = [(begin, low), (end, low), (end, high), (begin, high)]
    return [(along, height, at) if along_x else (at, height, along) for along, height in corners]


def rooms():
    """Floor, ceiling and walls. Inner walls have a door in the middle of each room's side."""
    size = ROOMS * SIDE
    quads = [level(0.0, (0.0, 0.0), (size, size)), level(HEIGHT, (0.0, 0.0), (size, size))]
    for along_x in (False, True):
        for line in range(ROOMS + 1):
            at = line * SIDE
            if line in (0, ROOMS):
                quads.append(wall(at, 0.0, size, 0.0, HEIGHT, along_x))
                continue
            for room in range(ROOMS):
                begin, end = room * SIDE, (room + 1) * SIDE
                left, right = 0.5 * (begin + end - DOOR), 0.5 * (begin + end + DOOR)
                quads.append(wall(at, begin, left, 0.0, HEIGHT, along_x))
                quads.append(wall(at, right, end, 0.0, HEIGHT, along_x))
                quads.append(wall(at, left, right, DOOR_HEIGHT, HEIGHT, along_x))
    return quads


def main():
    if len(sys.argv) != 3 or not sys.argv[1].isdecimal() or int(sys.argv[1]) < 1:
        sys.exit("benches/many_lights.py LAMPS FOLDER: LAMPS is a number above 0")
    count, folder = int(sys.argv[1]), pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    numbers = random.Random(1)
    corners = [[numbers.uniform(0.1, ROOMS * SIDE - 0.1) for _ in range(2)] for _ in range(count)]
    lamps = [level(HEIGHT - 0.05 - 0.3 * numbers.random(), at, [place + LAMP for place in at]) for at in corners]
    write_obj(folder / "rooms.obj", rooms())
    write_obj(folder / "lamps.obj", lamps)
    # The lamps bring the same light together, however many there are.
    radiance = 1.0e5 / count
    (folder / "scene.xml").write_text(SCENE.replace("RADIANCE", f"{radiance:.6g}"), encoding="utf-8")


if __name__ == "__main__":
    main()
