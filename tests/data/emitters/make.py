"""Writes map.exr and mitsuba.json beside this file: what Mitsuba 3 makes of emitters. Run: python3 make.py"""
import json
import pathlib

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
FOLDER = pathlib.Path(__file__).parent
mi.file_resolver().append(str(FOLDER))
TURN = '<rotate z="1" angle="30"/><rotate y="1" angle="50"/>'


def scene(version, emitter):
    return f'<scene version="{version}"><sensor type="perspective"/>{emitter}</scene>'


def environment(version, inside, transform):
    name = "toWorld" if version == "0.6.0" else "to_world"
    inside += f'<transform name="{name}">{transform}</transform>' if transform else ""
    return scene(version, f'<emitter type="envmap"><string name="filename" value="map.exr"/>{inside}</emitter>')


ENVIRONMENTS = [
    environment("3.0.0", "", ""),
    environment("3.0.0", '<float name="scale" value="2.5"/>', TURN),
    environment("3.0.0", "", '<scale x="-1"/>' + TURN),
    environment("0.6.0", "", '<matrix value="-4.37114e-008 0 1 0 0 1 0 0 -1 0 -4.37114e-008 0 0 0 0 1"/>'),
    scene("3.0.0", '<emitter type="constant"><rgb name="radiance" value="1, 0.5, 0.25"/></emitter>'),
]

AT = '<transform name="to_world"><lookat origin="0.2, 2, -0.1" target="0, 0, 0.3" up="0, 0, 1"/></transform>'
DELTA_EMITTERS = [
    ("3.0.0", "point", '<point name="position" x="1" y="2" z="-1"/><rgb name="intensity" value="3, 2, 1"/>'),
    ("3.0.0", "point", '<transform name="to_world"><translate x="0.3" y="1"/></transform>'),
    ("3.0.0", "spot", AT),
    ("3.0.0", "spot", AT + '<rgb name="intensity" value="3, 2, 1"/><float name="cutoff_angle" value="50"/>'),
    ("0.6.0", "spot", AT.replace("to_world", "toWorld") + '<float name="cutoffAngle" value="70"/><float name="beamWidth" value="10"/>'),
    ("3.0.0", "spot", AT + '<float name="cutoff_angle" value="40"/><float name="beam_width" value="50"/>'),
    ("3.0.0", "directional", '<vector name="direction" x="1" y="-2" z="0.5"/><rgb name="irradiance" value="3, 2, 1"/>'),
    ("3.0.0", "directional", AT),
    ("3.0.0", "projector", AT + '<rgb name="irradiance" value="3, 2, 1"/><float name="fov" value="50"/>'),
    ("3.0.0", "projector", AT + '<rgb name="irradiance" value="1, 2, 1"/><float name="scale" value="2.5"/>'),
]


def rounded(values):
    return [float(f"{value:.7g}") for value in values]


def unit(rng):
    d = rng.normal(size=3)
    return rounded(d / np.linalg.norm(d))


def radiances(xml, rng):
    emitter = mi.load_string(xml).emitters()[0]
    result = []
    for direction in [unit(rng) for _ in range(64)]:
        interaction = mi.SurfaceInteraction3f()
        interaction.wi = -mi.Vector3f(*direction)
        result.append({"direction": direction, "radiance": rounded(emitter.eval(interaction))})
    return {"xml": xml, "directions": result}


def irradiances(version, plugin, inside, rng):
    xml = scene(version, f'<emitter type="{plugin}">{inside}</emitter>')
    emitter = mi.load_string(xml).emitters()[0]
    emitter.set_scene(mi.load_dict({"type": "scene", "shape": {"type": "sphere"}}))
    result = []
    for point in [rounded(rng.uniform(-1, 1, size=3)) for _ in range(64)]:
        interaction = mi.SurfaceInteraction3f()
        interaction.p = mi.Point3f(*point)
        sample, irradiance = emitter.sample_direction(interaction, [0.5, 0.5], True)
        result.append({"from": point, "wi": rounded(sample.d), "irradiance": rounded(irradiance)})
    return {"xml": xml, "points": result}


def main():
    rng = np.random.default_rng(1)
    texels = rng.random((8, 16, 3)).astype(np.float32)
    texels[3, 0] = [40, 30, 20]
    mi.Bitmap(texels).write(str(FOLDER / "map.exr"))
    fixture = {
        "environments": [radiances(xml, rng) for xml in ENVIRONMENTS],
        "delta_emitters": [irradiances(*emitter, rng) for emitter in DELTA_EMITTERS],
    }
    text = json.dumps(fixture).replace(", {", ",\n{").replace("[{", "[\n{")
    (FOLDER / "mitsuba.json").write_text(text + "\n")


main()
