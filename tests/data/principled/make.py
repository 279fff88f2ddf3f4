"""Writes values.json and thin.json: what Mitsuba 3 says of `principled` and of `principledthin` for random parameters and
directions."""

import json
import os

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
FOLDER = os.path.dirname(os.path.abspath(__file__))
NUMBERS = ["roughness", "anisotropic", "metallic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness"]
NUMBERS += ["clearcoat", "clearcoat_gloss"]
THIN_NUMBERS = ["roughness", "anisotropic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness", "diff_trans"]


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


def write(name, rows):
    with open(os.path.join(FOLDER, name), "w") as file:
        file.write("[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]\n")


def row(given, bsdf, wo, wi):
    f, pdf = value(bsdf, wo, wi)
    return {**given, "wo": wo, "wi": wi, "eval": [rounded(x) for x in f], "pdf": rounded(pdf)}


def with_color(plugin, given):
    return mi.load_dict({"type": plugin, **given, "base_color": {"type": "rgb", "value": given["base_color"]}})


def thick(random):
    for index in range(60):
        given = parameters(random, index)
        bsdf = with_color("principled", given)
        transmits = given["spec_trans"] * (1 - given["metallic"]) > 0
        for pair in range(6):
            # From behind there is light only where some is transmitted.
            wo = direction(random, -1 if transmits and pair >= 4 else 1)
            wi = direction(random, -1 if transmits and pair % 2 else 1)
            yield row(given, bsdf, wo, wi)


def thin(random):
    for index in range(60):
        given = {name: round(float(random.uniform(0, 1)), 3) for name in THIN_NUMBERS}
        given["roughness"] = round(float(random.uniform(0.2, 1)), 3)
        given["diff_trans"] *= 2
        if index % 2:
            for name in THIN_NUMBERS[1:]:
                given[name] *= random.integers(2)
        given["eta"] = round(float(random.uniform(1.1, 2)), 3)
        given = {"base_color": [round(float(x), 3) for x in random.uniform(0, 1, 3)], **{k: float(v) for k, v in given.items()}}
        bsdf = with_color("principledthin", given)
        for pair in range(8):
            wo = direction(random, -1 if pair >= 4 else 1)
            wi = direction(random, -1 if pair % 2 else 1)
            if pair % 4 == 1:
                # Half of the light that crosses does so near the direction straight on.
                wi = np.round(np.subtract(0.15 * random.normal(size=3), wo), 6)
                wi = np.round(wi / np.linalg.norm(wi), 6).tolist()
            yield row(given, bsdf, wo, wi)


def main():
    write("values.json", thick(np.random.default_rng(4)))
    write("thin.json", thin(np.random.default_rng(5)))


if __name__ == "__main__":
    main()
