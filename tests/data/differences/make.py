"""Writes the scenes and mitsuba.json beside this file: block means of Mitsuba 3 where its semantics were in doubt.
docs/differences.md says how each was settled. Run: python3 make.py"""
import json
import pathlib

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
FOLDER = pathlib.Path(__file__).parent
SAMPLES, SEEDS, BLOCK = 256, 24, 8

SENSOR = """<sensor type="perspective"><float name="fov" value="40"/>
<transform name="to_world"><lookat origin="0.3,1.7,5.2" target="0,1,0" up="0,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="48"/>
<string name="pixel_format" value="rgb"/><boolean name="sample_border" value="true"/>{filter}</film></sensor>
"""
BOX = '<rfilter type="box"/>'
WALLS = """<shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
<bsdf type="diffuse"><rgb name="reflectance" value="0.5,0.5,0.55"/></bsdf></shape>
<shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="-2"/></transform>
<bsdf type="diffuse"><rgb name="reflectance" value="0.6,0.3,0.2"/></bsdf></shape>
"""
LAMPS = """<shape type="rectangle"><transform name="to_world"><scale x="0.9" y="0.7"/><rotate x="1" angle="90"/>
<translate y="3" x="0.5" z="0.6"/></transform><emitter type="area"><rgb name="radiance" value="9,8,6"/></emitter></shape>
<shape type="sphere"><point name="center" x="0.2" y="1.6" z="1"/><float name="radius" value="0.3"/>
<emitter type="area"><rgb name="radiance" value="2,1,1"/></emitter></shape>
<emitter type="constant"><rgb name="radiance" value="0.3,0.5,0.8"/></emitter>
"""
MESH_LAMP = """<shape type="obj"><string name="filename" value="octahedron.obj"/>{flip}
<transform name="to_world"><scale x="0.9" y="0.7" z="0.6"/><rotate x="1" angle="60"/><translate y="2" x="0.3" z="0.2"/>
</transform><emitter type="area"><rgb name="radiance" value="9,8,6"/></emitter></shape>
"""
PATH = '<integrator type="path"><integer name="max_depth" value="4"/>{more}</integrator>'
HIDE = '<boolean name="hide_emitters" value="true"/>'
FLIP = '<boolean name="flip_normals" value="true"/>'
# Mitsuba's emitter sampling does not agree with its BSDF sampling on a mesh with smooth normals.
BY_BSDF = '<integrator type="direct"><integer name="bsdf_samples" value="1"/><integer name="emitter_samples" value="0"/></integrator>'
DIRECT = '<integrator type="path"><integer name="max_depth" value="2"/></integrator>'


def lamp(flip):
    return WALLS + MESH_LAMP.format(flip=flip)


def scene(integrator, filter, content):
    return f'<scene version="3.0.0">{integrator}\n{SENSOR.format(filter=filter)}{content}</scene>\n'


# Name, integrator of the scene, integrator of the values, filter, content.
SCENES = [
    ("hidden-emitters", PATH.format(more=HIDE), None, BOX, WALLS + LAMPS),
    ("gaussian", PATH.format(more=""), None, '<rfilter type="gaussian"><float name="stddev" value="0.8"/></rfilter>', WALLS + LAMPS),
    ("tent", PATH.format(more=""), None, '<rfilter type="tent"><float name="radius" value="1.6"/></rfilter>', WALLS + LAMPS),
    ("smooth-lamp-flipped", DIRECT, BY_BSDF, BOX, lamp(FLIP)),
]


def block_means(image):
    height, width, _ = image.shape
    return image.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean((1, 3)).reshape(-1, 3)


def main():
    values = {}
    for name, integrator, of_values, filter, content in SCENES:
        (FOLDER / f"{name}.xml").write_text(scene(integrator, filter, content))
        reference = FOLDER / "reference.tmp.xml"
        reference.write_text(scene(of_values or integrator, filter, content))
        loaded = mi.load_file(str(reference))
        reference.unlink()
        blocks = np.array([block_means(np.array(mi.render(loaded, spp=SAMPLES, seed=seed))) for seed in range(SEEDS)])
        error = blocks.std(0, ddof=1) / np.sqrt(SEEDS)
        rounded = lambda numbers: [float(f"{number:.6g}") for number in numbers.ravel()]
        values[name] = {"means": rounded(blocks.mean(0)), "errors": rounded(error)}
        print(name, blocks.mean())
    (FOLDER / "mitsuba.json").write_text(json.dumps(values).replace("}, ", "},\n") + "\n")


main()
