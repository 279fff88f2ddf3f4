"""Prints the millions of paths per second of Mitsuba 3's `path` integrator: mitsuba_speed.py SCENE.xml WIDTH HEIGHT."""
import sys
import time

import mitsuba as mi
import numpy as np

SECONDS, SPP = 3.0, 16

mi.set_variant("llvm_ad_rgb")
scene = mi.load_file(sys.argv[1])
width, height = int(sys.argv[2]), int(sys.argv[3])
params = mi.traverse(scene.sensors()[0])
sensor = mi.load_dict({
    "type": "perspective", "fov_axis": "x", "fov": float(np.ravel(params["x_fov"])[0]),
    "to_world": mi.ScalarTransform4f(np.array(params["to_world"].matrix, dtype=np.float64).reshape(4, 4)),
    "near_clip": float(np.ravel(params["near_clip"])[0]), "far_clip": float(np.ravel(params["far_clip"])[0]),
    "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
    "sampler": {"type": "independent"},
})
integrator = mi.load_dict({"type": "path", "max_depth": 16, "rr_depth": 8})


def render(seed):
    np.array(mi.render(scene, sensor=sensor, integrator=integrator, spp=SPP, seed=seed))


render(0)
passes, begin = 0, time.perf_counter()
while time.perf_counter() - begin < SECONDS:
    passes += 1
    render(passes)
print(passes * SPP * width * height / (time.perf_counter() - begin) / 1e6)
