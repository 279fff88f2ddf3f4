#!/usr/bin/env python3
"""Writes six scenes whose light comes through glass or off metal, in Mitsuba's format; Mitsuba 3 reads them, too.

    benches/glass_scenes.py FOLDER

water.xml: a glass of water under a small lamp. pane.xml: a room behind a pane that has a thickness, under a low sun. pool.xml: a pool under a
small sun. frosted.xml: a lamp in a box of rough glass. ring.xml: a ring of metal under a lamp. diamond.xml: a diamond on a table.
"""

import math
import pathlib
import random
import sys

SCENE = """<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="16"/><integer name="rr_depth" value="8"/></integrator>
<sensor type="perspective"><float name="fov" value="{fov}"/>
<transform name="to_world"><lookat origin="{eye}" target="{target}" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/><rfilter type="box"/></film></sensor>
{shapes}</scene>
"""
GLASS = '<bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf>'
PEBBLES = '<bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.45, 0.4"/></bsdf>'
WALL = '<bsdf type="diffuse"><rgb name="reflectance" value="0.7"/></bsdf>'


def shape(kind, bsdf, steps, more=""):
    return f'<shape type="{kind}">{more}<transform name="to_world">{steps}</transform>{bsdf}</shape>\n'


def floor(size, y=0.0, bsdf=PEBBLES):
    return shape("rectangle", bsdf, f'<scale value="{size}"/><rotate x="1" angle="-90"/><translate y="{y}"/>')


def lamp(center, radius, radiance):
    values = f'<point name="center" x="{center[0]}" y="{center[1]}" z="{center[2]}"/><float name="radius" value="{radius}"/>'
    return f'<shape type="sphere">{values}<emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter></shape>\n'


def mesh(folder, name, vertices, faces, bsdf):
    """A mesh of triangles, as a PLY file."""
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}", *(f"property float {axis}" for axis in "xyz")]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(f"{x:.6f}" for x in vertex) for vertex in vertices]
    lines += ["3 " + " ".join(map(str, face)) for face in faces]
    (folder / f"{name}.ply").write_text("\n".join(lines) + "\n")
    return f'<shape type="ply"><string name="filename" value="{name}.ply"/>{bsdf}</shape>\n'


def lathe(profile, sides=96):
    """Vertices and faces of a profile of (radius, height), turned about the y-axis, outwards where the profile goes up."""
    vertices, faces = [], []
    for radius, height in profile:
        for side in range(sides):
            angle = 2 * math.pi * side / sides
            vertices.append((radius * math.cos(angle), height, radius * math.sin(angle)))
    for row in range(len(profile) - 1):
        for side in range(sides):
            a, b = row * sides + side, row * sides + (side + 1) % sides
            faces += [(a, a + sides, b), (b, a + sides, b + sides)]
    return vertices, faces


def water(folder):
    outer = [(0.0001, 0.01), (0.5, 0.01), (0.55, 1.5), (0.5, 1.5), (0.47, 1.0)]
    inside = [(0.47, 1.0), (0.45, 0.1), (0.0001, 0.1)]
    surface = [(0.47, 1.0), (0.0001, 1.0)]
    wet = '<bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1.33"/></bsdf>'
    air = '<bsdf type="dielectric"><float name="int_ior" value="1.33"/></bsdf>'
    shapes = floor(6, bsdf=WALL) + mesh(folder, "glass", *lathe(outer), GLASS) + mesh(folder, "wall", *lathe(inside), wet)
    shapes += mesh(folder, "water", *lathe(surface), air) + lamp((1.6, 3.0, -0.8), 0.15, 120)
    return shapes, "0, 2.2, 4", "0, 0.5, 0", 35


def pane(folder):
    shapes = ""
    for steps in ('<scale value="2"/><rotate x="1" angle="-90"/>', '<scale value="2"/><rotate x="1" angle="90"/><translate y="2.4"/>',
                  '<scale value="2"/><translate z="-2"/>', '<scale value="2"/><rotate y="1" angle="-90"/><translate x="2"/>',
                  '<scale value="2"/><rotate y="1" angle="180"/><translate z="2"/>'):
        shapes += shape("rectangle", f'<bsdf type="twosided">{WALL}</bsdf>', steps)
    for y, half in ((0.3, 0.3), (2.1, 0.3)):
        shapes += shape("cube", WALL, f'<scale x="0.05" y="{half}" z="2"/><translate x="-2" y="{y}"/>')
    for z in (-1.4, 1.4):
        shapes += shape("cube", WALL, f'<scale x="0.05" y="1.2" z="0.6"/><translate x="-2" y="1.2" z="{z}"/>')
    shapes += shape("cube", GLASS, '<scale x="0.01" y="0.61" z="0.81"/><translate x="-2" y="1.2"/>')
    shapes += lamp((-60, 42, 18), 1.5, 900) + '<emitter type="constant"><rgb name="radiance" value="0.3, 0.4, 0.6"/></emitter>\n'
    return shapes, "1.6, 1.3, 1.6", "-1.5, 0.9, -0.6", 70


def pool(folder):
    numbers = random.Random(3)
    waves = [(numbers.uniform(2, 9), numbers.uniform(0, 2 * math.pi), numbers.uniform(0, 2 * math.pi)) for _ in range(12)]
    count, size = 160, 2.0
    vertices, faces = [], []
    for i in range(count + 1):
        for j in range(count + 1):
            x, z = size * (2 * i / count - 1), size * (2 * j / count - 1)
            height = sum(0.035 / f * math.sin(f * (x * math.cos(a) + z * math.sin(a)) + p) for f, a, p in waves)
            vertices.append((x, height, z))
    for i in range(count):
        for j in range(count):
            a = i * (count + 1) + j
            faces += [(a, a + 1, a + count + 1), (a + 1, a + count + 2, a + count + 1)]
    air = '<bsdf type="dielectric"><float name="int_ior" value="1.33"/></bsdf>'
    shapes = mesh(folder, "waves", vertices, faces, air) + floor(2, -0.8, WALL)
    for turn in (0, 90, 180, 270):
        steps = f'<scale x="2" y="0.45" z="1"/><translate y="-0.35" z="-2"/><rotate y="1" angle="{turn}"/>'
        shapes += shape("rectangle", WALL, steps)
    shapes += lamp((20, 40, -10), 1.2, 900) + '<emitter type="constant"><rgb name="radiance" value="0.2, 0.3, 0.5"/></emitter>\n'
    return shapes, "0, 2.4, 3.4", "0, -0.5, 0", 50


def frosted(folder):
    rough = '<bsdf type="roughdielectric"><float name="alpha" value="0.15"/><float name="int_ior" value="1.5"/></bsdf>'
    shapes = floor(3, bsdf=WALL) + shape("rectangle", WALL, '<scale value="3"/><translate y="2" z="-1.6"/>')
    for x in (-0.45, 0.45):
        shapes += shape("cube", rough, f'<scale x="0.02" y="0.5" z="0.45"/><translate x="{x}" y="0.52"/>')
    for z in (-0.45, 0.45):
        shapes += shape("cube", rough, f'<scale x="0.42" y="0.5" z="0.02"/><translate y="0.52" z="{z}"/>')
    shapes += shape("cube", WALL, '<scale x="0.5" y="0.02" z="0.5"/><translate y="1.06"/>') + lamp((0, 0.5, 0), 0.1, 60)
    return shapes, "1.6, 1.6, 3.4", "0, 0.5, 0", 45


def ring(folder):
    section = [(0.8 - 0.12 * math.cos(2 * math.pi * k / 48), 0.25 + 0.25 * math.sin(2 * math.pi * k / 48)) for k in range(49)]
    metal = '<bsdf type="conductor"><string name="material" value="Au"/></bsdf>'
    shapes = floor(4, bsdf=WALL) + mesh(folder, "ring", *lathe(section, 192), f'<bsdf type="twosided">{metal}</bsdf>')
    return shapes + lamp((1.5, 2.0, 1.0), 0.1, 150), "0, 2.6, 2.6", "0, 0.1, 0", 40


def diamond(folder):
    cut = '<bsdf type="dielectric"><float name="int_ior" value="2.4"/></bsdf>'
    sides = 16
    profile = [(0.0001, 0.0), (0.5, 0.43), (0.5, 0.46), (0.28, 0.62), (0.0001, 0.62)]
    vertices, faces = lathe(profile, sides)
    corners = [vertices[k] for face in faces for k in face]
    faces = [(3 * k, 3 * k + 1, 3 * k + 2) for k in range(len(faces))]
    shapes = floor(3, bsdf=WALL) + mesh(folder, "diamond", corners, faces, cut)
    shapes += lamp((1.2, 2.5, 0.6), 0.12, 150) + '<emitter type="constant"><rgb name="radiance" value="0.1"/></emitter>\n'
    return shapes, "0, 1.3, 2.2", "0, 0.3, 0", 35


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for make in (water, pane, pool, frosted, ring, diamond):
        shapes, eye, target, fov = make(folder)
        scene = SCENE.format(shapes=shapes, eye=eye, target=target, fov=fov, width=192, height=144)
        (folder / f"{make.__name__}.xml").write_text(scene)


main()
