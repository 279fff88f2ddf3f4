"""Writes what Mitsuba 3 makes of `sunsky`: values.json beside this file, and src/scene/plugins/sunsky/sun_radiance.rs, the sun's
radiance. Run with Mitsuba 3.9.1 installed: python3 make.py

In Mitsuba's RGB variants the sun is a disk of one radiance. It is linear in the turbidity between whole numbers, and in the
elevation between 2, 5, 8, ... and 89 degrees, beyond which it stays."""
import json
import math
import pathlib

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
FOLDER = pathlib.Path(__file__).parent
TABLE = FOLDER / "../../../src/scene/plugins/sunsky/sun_radiance.rs"
ELEVATIONS = range(2, 90, 3)

HEAD = '''//! Radiance of the sun's disk at the default aperture, as Mitsuba 3.9.1 has it in its RGB variants (Hosek and Wilkie 2013). Written by
//! `tests/data/sunsky/make.py`.

/// Elevation in degrees of the first knot, and of the distance between knots.
pub(super) const ELEVATIONS: (f64, f64) = (2.0, 3.0);

/// Red, green and blue at each knot of the elevation, for each whole turbidity from 1 to 10.
#[rustfmt::skip]
'''


def value(emitter, direction):
    interaction = mi.SurfaceInteraction3f()
    interaction.wi = -mi.Vector3f(*direction)
    return [float(channel) for channel in emitter.eval(interaction)]


def at(elevation, azimuth=0.0):
    c = math.cos(elevation)
    return [c * math.cos(azimuth), c * math.sin(azimuth), math.sin(elevation)]


def sunsky(**more):
    return mi.load_dict({"type": "sunsky", **more})


def sun(turbidity, elevation, **more):
    direction = at(elevation)
    return value(sunsky(turbidity=turbidity, sun_direction=direction, sky_scale=0.0, **more), direction)


def rounded(values):
    return [float(f"{value:.7g}") for value in values]


def write_table():
    rows = []
    for turbidity in range(1, 11):
        knots = (sun(float(turbidity), math.radians(elevation)) for elevation in ELEVATIONS)
        texts = ["[" + ", ".join(f"{float(f'{c:.7g}')}" for c in knot) + "]" for knot in knots]
        lines = (", ".join(texts[start : start + 4]) for start in range(0, len(texts), 4))
        rows.append("    [\n" + "".join(f"        {line},\n" for line in lines) + "    ],\n")
    count = len(ELEVATIONS)
    TABLE.write_text(f"{HEAD}pub(super) const RADIANCE: [[[f32; 3]; {count}]; 10] = [\n{''.join(rows)}];\n")


def skies(rng):
    for _ in range(8):
        turbidity, elevation, azimuth = rng.uniform(1, 10), rng.uniform(0.02, 1.5), rng.uniform(0, 6)
        albedo = rounded(rng.uniform(0, 1, 3))
        direction = rounded(at(elevation, azimuth))
        emitter = sunsky(turbidity=turbidity, albedo={"type": "rgb", "value": albedo}, sun_direction=direction, sun_scale=0.0)
        points = [rounded(at(rng.uniform(0.02, 1.55), rng.uniform(0, 6.28))) for _ in range(32)]
        radiance = [{"direction": point, "radiance": rounded(value(emitter, point))} for point in points]
        yield {"turbidity": turbidity, "albedo": albedo, "sun_direction": direction, "points": radiance}


def suns(rng):
    for _ in range(16):
        turbidity, elevation = rng.uniform(1, 10), rng.uniform(0.03, 1.55)
        yield {"turbidity": turbidity, "sun_direction": at(elevation), "radiance": rounded(sun(turbidity, elevation))}


def times():
    places = [
        {},
        {"hour": 8.5, "minute": 20.0, "second": 30.0},
        {"year": 2024, "month": 2, "day": 29, "latitude": 51.5, "longitude": -0.1, "timezone": 0.0, "hour": 11.0},
        {"latitude": -33.9, "longitude": 151.2, "timezone": 10.0, "month": 12},
    ]
    for place in places:
        direction = mi.traverse(sunsky(**place))["sun_direction"]
        yield {"place": place, "sun_direction": rounded(direction)}


def main():
    write_table()
    rng = np.random.default_rng(7)
    fixture = {"skies": list(skies(rng)), "suns": list(suns(rng)), "times": list(times())}
    text = json.dumps(fixture).replace(", {", ",\n{").replace("[{", "[\n{")
    (FOLDER / "values.json").write_text(text + "\n")


main()
