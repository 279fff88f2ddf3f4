#!/usr/bin/env python3
"""Errors of two builds at equal samples where light comes straight through surfaces: leaves under a sun, and a mask, a sheet of
glass and both under a lamp. It needs nothing but Python.

    benches/passages.py BEFORE AFTER [SAMPLES]

Each line has the root of the relative mean squared error of SAMPLES (64) samples per pixel against 16384 of AFTER, of each build, and
their ratio. A build whose shadow rays stop at every surface lacks the sun's light altogether."""
import json
import pathlib
import subprocess
import sys
import tempfile

FLOOR = """<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="12"/></integrator>
<sensor type="perspective"><float name="fov" value="45"/>
<transform name="to_world"><lookat origin="0,1,2.4" target="0,0.2,0" up="0,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/><rfilter type="box"/></film></sensor>
<shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
<bsdf type="diffuse"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="-1.5"/></transform><bsdf type="diffuse"/></shape>
{}</scene>"""
LEAF = """<bsdf type="mask"><texture type="checkerboard" name="opacity"><float name="color0" value="0"/><float name="color1" value="1"/>
<transform name="to_uv"><scale x="7" y="9"/></transform></texture>
<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.1,0.5,0.2"/></bsdf></bsdf></bsdf>"""
MASK = """<bsdf type="mask"><float name="opacity" value="0.4"/><bsdf type="diffuse"/></bsdf>"""
GLASS = """<bsdf type="thindielectric"/>"""
SUN = """<emitter type="directional"><vector name="direction" x="-0.3" y="-1" z="-0.4"/><rgb name="irradiance" value="3"/></emitter>"""
LAMP = """<shape type="rectangle"><transform name="to_world"><scale value="0.2"/><rotate x="1" angle="90"/><translate y="2.6"/></transform>
<emitter type="area"><rgb name="radiance" value="60"/></emitter></shape>"""


def roof(height, bsdf):
    steps = f'<scale value="1.5"/><rotate x="1" angle="90"/><translate y="{height}"/>'
    return f'<shape type="rectangle"><transform name="to_world">{steps}</transform>{bsdf}</shape>'


SCENES = {
    "leaves under a sun": roof(1.6, LEAF) + roof(1.9, LEAF) + SUN,
    "mask under a lamp": roof(1.6, MASK) + LAMP,
    "glass under a lamp": roof(1.6, GLASS) + LAMP,
    "leaves and glass under a lamp": roof(1.6, LEAF) + roof(1.9, GLASS) + LAMP,
}


def main():
    before, after = sys.argv[1:3]
    samples = sys.argv[3] if len(sys.argv) > 3 else "64"
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder, "scene.xml")

        def render(binary, name, spp, seed):
            picture = pathlib.Path(folder, name)
            options = ["--spp", spp, "--seed", seed, "--quiet", "--overwrite", "-o", picture]
            subprocess.run([binary, "render", scene, *options], check=True)
            return picture

        for name, parts in SCENES.items():
            scene.write_text(FLOOR.format(parts))
            reference = render(after, "reference.exr", "16384", "1")
            errors = []
            for binary in (before, after):
                picture = render(binary, "picture.exr", samples, "2")
                compared = subprocess.run([after, "compare", "--json", picture, reference], check=True, capture_output=True)
                errors.append(json.loads(compared.stdout)["relmse"] ** 0.5)
            print(f"{name:32} {errors[0]:.5f} {errors[1]:.5f} {errors[1] / errors[0]:.3f}", flush=True)


main()
