"""Writes values.json: what Mitsuba 3 says of white diffuse surfaces below `bumpmap` and `normalmap`, with everything that
the answer depends on in the surface's local frame."""

import json
import os

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
FOLDER = os.path.dirname(os.path.abspath(__file__))
WHITE = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}


def unit(v):
    return v / np.linalg.norm(v)


def listed(v):
    return [round(float(x), 6) for x in v]


def surface(random):
    """A surface whose frames are not aligned with the world's, its shading normal tilted against the geometric one."""
    si = mi.SurfaceInteraction3f()
    si.t = 1.0
    n = unit(random.normal(size=3))
    dp_du = random.normal(size=3)
    dp_dv = np.cross(n, dp_du) * random.choice([-1, 1]) + 0.3 * random.normal(size=3)
    geometric = unit(n + 0.4 * random.normal(size=3))
    s = unit(dp_du - n * n.dot(dp_du))
    frame = np.array([s, np.cross(n, s), n])
    si.n = mi.Normal3f(geometric.tolist())
    si.sh_frame = mi.Frame3f(*[mi.Vector3f(axis.tolist()) for axis in frame])
    si.dp_du, si.dp_dv = mi.Vector3f(dp_du.tolist()), mi.Vector3f(dp_dv.tolist())
    si.uv = mi.Point2f(random.uniform(0, 1, 2).tolist())
    local = {"dp_du": dp_du, "dp_dv": dp_dv, "geometric": geometric}
    return si, {name: listed(frame @ v) for name, v in local.items()}


def directions(random):
    wo, wi = (unit(random.normal(size=3)) for _ in range(2))
    if random.uniform() < 0.8:
        wo[2], wi[2] = abs(wo[2]), abs(wi[2])
    return listed(wo), listed(wi)


def main():
    random = np.random.default_rng(6)
    heights = mi.TensorXf(random.uniform(0, 1, (8, 8, 1)).astype(np.float32))
    texture = mi.load_dict({"type": "bitmap", "data": heights, "raw": True})
    bump = mi.load_dict({"type": "bumpmap", "scale": 0.3, "texture": texture, "bsdf": WHITE})
    rows = []
    for index in range(400):
        si, local = surface(random)
        wo, wi = directions(random)
        si.wi = mi.Vector3f(wo)
        color = [round(float(x), 3) for x in random.uniform([0, 0, 0.4], 1)]
        bsdf = bump
        if index % 2:
            image = mi.TensorXf(np.array(color, dtype=np.float32).reshape(1, 1, 3))
            bitmap = {"type": "bitmap", "data": image, "raw": True}
            bsdf = mi.load_dict({"type": "normalmap", "normalmap": bitmap, "bsdf": WHITE})
        gradient = listed(0.3 * np.array(texture.eval_1_grad(si)).ravel())
        f = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(wi))[0]
        row = {"bump": index % 2 == 0, **local, "gradient": gradient, "color": color, "wo": wo, "wi": wi, "eval": round(f, 7)}
        rows.append(row)
    with open(os.path.join(FOLDER, "values.json"), "w") as file:
        file.write("[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]\n")


if __name__ == "__main__":
    main()
