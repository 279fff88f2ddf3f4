"""Writes values.json: what Mitsuba 3 says of `principled` for random parameters and directions."""

import json
import os

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
FOLDER = os.path.dirname(os.path.abspath(__file__))
NUMBERS = ["roughness", "anisotropic", "metallic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness"]
NUMBERS += ["clearcoat", "clearcoat_gloss"]


def parameters(random, index):
    values = {name: round(float(random.uniform(0, 1)), 3) for name in NUMBERS}
    values["roughness"] = round(float(random.uniform(0.2, 1)), 3)
    # One lobe at a time, too.
    if index % 2:
        for name in NUMBERS[1:]:
            values[name] *= random.integers(2)
    eta = round(float(random.uniform(1.1, 2)), 3)
    return {"base_color": [round(float(x), 3) for x in random.uniform(0, 1, 3)], "eta": eta, **values}


def direction(random, side):
    z = side * random.uniform(0.05, 1)
    phi = random.uniform(0, 2 * np.pi)
    r = np.sqrt(1 - z * z)
    return np.round([r * np.cos(phi), r * np.sin(phi), z], 6).tolist()


def value(bsdf, wo, wi):
    si = mi.SurfaceInteraction3f()
    si.t = 1
    si.n = [0, 0, 1]
    si.sh_frame = mi.Frame3f([1, 0, 0], [0, 1, 0], [0, 0, 1])
    # Mitsuba's `wi` is where the path comes from.
    si.wi = mi.Vector3f(wo)
    f, pdf = bsdf.eval_pdf(mi.BSDFContext(), si, mi.Vector3f(wi))
    return [float(f[i][0]) for i in range(3)], float(pdf[0])


def rounded(x):
    return float(f"{x:.7g}")


def main():
    random = np.random.default_rng(4)
    rows = []
    for index in range(60):
        given = parameters(random, index)
        color = {"type": "rgb", "value": given["base_color"]}
        bsdf = mi.load_dict({"type": "principled", **given, "base_color": color})
        transmits = given["spec_trans"] * (1 - given["metallic"]) > 0
        for pair in range(6):
            # From behind there is light only where some is transmitted.
            wo = direction(random, -1 if transmits and pair >= 4 else 1)
            wi = direction(random, -1 if transmits and pair % 2 else 1)
            f, pdf = value(bsdf, wo, wi)
            rows.append({**given, "wo": wo, "wi": wi, "eval": [rounded(x) for x in f], "pdf": rounded(pdf)})
    with open(os.path.join(FOLDER, "values.json"), "w") as file:
        file.write("[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]\n")


if __name__ == "__main__":
    main()
