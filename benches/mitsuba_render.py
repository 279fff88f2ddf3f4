"""Renders with Mitsuba 3's `path` integrator for some seconds, compilation and loading not counted.

mitsuba_render.py SCENE.xml WIDTH HEIGHT SECONDS SEED OUT.exr prints the samples per pixel and the seconds.
"""
import sys
import time

import mitsuba as mi
import numpy as np

SPP = 16

mi.set_variant("llvm_ad_rgb")
path, width, height, seconds, first_seed, out = sys.argv[1:]
scene = mi.load_file(path)
params = mi.traverse(scene.sensors()[0])


def number(name):
    return float(np.ravel(params[name])[0])


sensor = mi.load_dict({
    "type": "perspective", "fov_axis": "x", "fov": number("x_fov"),
    "to_world": mi.ScalarTransform4f(np.array(params["to_world"].matrix, dtype=np.float64).reshape(4, 4)),
    "near_clip": number("near_clip"), "far_clip": number("far_clip"),
    "principal_point_offset_x": number("principal_point_offset_x"),
    "principal_point_offset_y": number("principal_point_offset_y"),
    "film": {"type": "hdrfilm", "width": int(width), "height": int(height), "rfilter": {"type": "box"},
             "pixel_format": "rgb", "component_format": "float32"},
    "sampler": {"type": "independent"},
})
integrator = mi.load_dict({"type": "path", "max_depth": 16, "rr_depth": 8})


def render(seed):
    return np.array(mi.render(scene, sensor=sensor, integrator=integrator, spp=SPP, seed=seed), dtype=np.float64)


render(int(first_seed))
total, passes, begin = 0.0, 0, time.perf_counter()
while time.perf_counter() - begin < float(seconds):
    passes += 1
    total = total + render(int(first_seed) + passes)
elapsed = time.perf_counter() - begin
mi.Bitmap((total / passes).astype(np.float32)).write(out)
print(passes * SPP, elapsed)
