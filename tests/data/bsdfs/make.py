"""Values of Mitsuba's dielectrics, conductors, plastics and hair: `values.json` of directions in general, `single.json` of
directions that light takes alone. Run with Mitsuba 3.9.1 installed; `wo` goes to the eye, `wi` to the light."""

import json
import math
import os
import random

import mitsuba as mi

mi.set_variant("scalar_rgb")
numbers = random.Random(1)
WHITE, COLOR = [1.0, 1.0, 1.0], [0.9, 0.5, 0.2]
OUTSIDE, BOTH = (1.0,), (1.0, -1.0)


def rgb(value):
    return {"type": "rgb", "value": value}


def rough(**more):
    """Both distributions, isotropic and not."""
    for distribution in ("beckmann", "ggx"):
        for alpha_u, alpha_v in ((0.05, 0.05), (0.2, 0.2), (1.0, 1.0), (0.1, 0.4), (0.6, 0.15)):
            yield {"distribution": distribution, "alpha_u": alpha_u, "alpha_v": alpha_v, **more}


def metals(plugin):
    for material in ("Cu", "Al", "Au", "none"):
        yield {"type": plugin, "material": material, "specular_reflectance": rgb(COLOR)}
    yield {"type": plugin, "eta": rgb([0.2, 1.5, 3.0]), "k": rgb([4.0, 1.0, 0.0])}


def dielectrics(plugin):
    for inside, outside in ((1.5, 1.0), (1.0, 1.33), (2.4, 1.0)):
        colors = {"specular_reflectance": rgb(COLOR), "specular_transmittance": rgb(COLOR[::-1])}
        yield {"type": plugin, "int_ior": inside, "ext_ior": outside, **colors}


def plastics(plugin):
    for nonlinear in (False, True):
        for ior in (1.3, 1.49, 1.9):
            yield {"type": plugin, "int_ior": ior, "ext_ior": 1.0, "nonlinear": nonlinear,
                   "diffuse_reflectance": rgb(COLOR), "specular_reflectance": rgb([0.6, 0.8, 1.0])}


def rough_plastics():
    for index, base in enumerate(plastics("roughplastic")):
        for distribution in ("beckmann", "ggx"):
            for alpha in (0.05, 0.1, 0.3, 0.6, 1.0)[index % 2::2]:
                yield {**base, "distribution": distribution, "alpha": alpha}


def polarized_plastics():
    for ior in (1.3, 1.49, 1.9):
        yield {"type": "pplastic", "int_ior": ior, "ext_ior": 1.0,
               "diffuse_reflectance": rgb(COLOR), "specular_reflectance": rgb([0.6, 0.8, 1.0])}


def hairs():
    for absorption in ([0.3, 0.3, 0.3], [0.1, 0.5, 1.5], [0.0, 0.0, 0.0]):
        for along, around, tilt, ior in ((0.3, 0.3, 2.0, 1.55), (0.15, 0.6, -4.0, 1.4), (0.7, 0.2, 0.0, 1.8), (1.0, 1.0, 3.0, 1.55)):
            yield {"type": "hair", "sigma_a": rgb(absorption), "longitudinal_roughness": along, "azimuthal_roughness": around,
                   "scale_tilt": tilt, "int_ior": ior, "ext_ior": 1.0}


def color(value):
    return [float(value)] * 3 if isinstance(value, float) else [float(value[i]) for i in range(3)]


def index_of_metal(description):
    params = mi.traverse(mi.load_dict(description))
    return {name: color(params[f"{name}.value"]) for name in ("eta", "k")}


def parameters(description):
    row = {"kind": description["type"]}
    for name, value in description.items():
        if isinstance(value, dict):
            row[name] = value["value"]
        elif name in ("alpha", "alpha_u", "alpha_v", "nonlinear", "longitudinal_roughness", "azimuthal_roughness", "scale_tilt"):
            row[name] = value
    if row["kind"] != "hair":
        row.setdefault("specular_reflectance", WHITE)
    if "int_ior" in description:
        row["eta"] = description["int_ior"] / description["ext_ior"]
    if "conductor" in row["kind"]:
        row.update(index_of_metal(description))
    if "distribution" in description:
        row["ggx"] = description["distribution"] == "ggx"
    return row


def direction(cosine, azimuth):
    sine = math.sqrt(1.0 - cosine * cosine)
    return [sine * math.cos(azimuth), sine * math.sin(azimuth), cosine]


def interaction(wo):
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(wo)
    return si


def digits(value):
    if isinstance(value, list):
        return [digits(v) for v in value]
    return float(f"{value:.7g}") if isinstance(value, float) else value


def general(descriptions, sides, count):
    """Directions drawn by the BSDF itself, and others."""
    for description in descriptions:
        bsdf = mi.load_dict(description)
        for index in range(count):
            wo = direction(sides[index % len(sides)] * (0.05 + 0.95 * numbers.random()), 6.28 * numbers.random())
            u = numbers.random(), mi.Point2f(numbers.random(), numbers.random())
            sample, _ = bsdf.sample(mi.BSDFContext(), interaction(wo), *u)
            wi = [float(sample.wo[i]) for i in range(3)]
            if index % 3 == 2 or abs(wi[2]) < 0.02 or sample.pdf == 0.0:
                wi = direction(sides[index // 2 % len(sides)] * (0.1 + 0.9 * numbers.random()), 6.28 * numbers.random())
            value = bsdf.eval(mi.BSDFContext(), interaction(wo), mi.Vector3f(wi))
            pdf = bsdf.pdf(mi.BSDFContext(), interaction(wo), mi.Vector3f(wi))
            yield {**parameters(description), "wo": wo, "wi": wi, "eval": color(value), "pdf": float(pdf)}


def single(descriptions, sides):
    for description in descriptions:
        bsdf = mi.load_dict(description)
        for side in sides:
            for cosine in (1.0, 0.8, 0.5, 0.2, 0.05):
                wo = direction(side * cosine, 1.0)
                for u in (0.0, 0.9999999):
                    sample, weight = bsdf.sample(mi.BSDFContext(), interaction(wo), u, mi.Point2f(0.5, 0.5))
                    if not mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta) or sample.pdf == 0.0:
                        continue
                    wi = [float(sample.wo[i]) for i in range(3)]
                    yield {**parameters(description), "wo": wo, "wi": wi, "weight": color(weight),
                           "probability": float(sample.pdf), "bent": float(sample.eta)}


def write(name, rows):
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), name)
    lines = (json.dumps({key: digits(value) for key, value in row.items()}) for row in rows)
    with open(path, "w") as file:
        file.write("[\n" + ",\n".join(lines) + "\n]\n")


def combined(bases, surfaces):
    surfaces = list(surfaces)
    return ({**base, **surfaces[(3 * i + j) % len(surfaces)]} for i, base in enumerate(bases) for j in range(4))


def main():
    values = list(general(combined(metals("roughconductor"), rough()), OUTSIDE, 8))
    values += general(combined(dielectrics("roughdielectric"), rough()), BOTH, 16)
    values += general(plastics("plastic"), OUTSIDE, 6)
    values += general(rough_plastics(), OUTSIDE, 6)
    values += general(combined(polarized_plastics(), rough()), OUTSIDE, 8)
    values += general(hairs(), BOTH, 12)
    write("values.json", values)
    lobes = list(single(metals("conductor"), OUTSIDE))
    lobes += single(dielectrics("dielectric"), BOTH)
    lobes += single(dielectrics("thindielectric"), BOTH)
    lobes += single(plastics("plastic"), OUTSIDE)
    write("single.json", lobes)


main()
