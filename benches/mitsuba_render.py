"""Renders with Mitsuba 3's `path` integrator for some seconds, compilation and loading not counted.

mitsuba_render.py SCENE.xml WIDTH HEIGHT SECONDS SEED OUT.exr prints the samples per pixel and the seconds.
MITSUBA_VARIANT chooses the variant (llvm_ad_rgb).
"""
import os
import sys
import time

import mitsuba as mi
import mitsuba_scene
import numpy as np

SPP = 16

mi.set_variant(os.environ.get("MITSUBA_VARIANT", "llvm_ad_rgb"))
path, width, height, seconds, first_seed, out = sys.argv[1:]
scene = mi.load_file(path)
sensor = mitsuba_scene.sensor(scene, int(width), int(height))
integrator = mitsuba_scene.integrator()


def render(seed):
    return np.array(mi.render(scene, sensor=sensor, integrator=integrator, spp=SPP, seed=seed), dtype=np.float64)


render(int(first_seed))
total, passes, begin = 0.0, 0, time.perf_counter()
while passes == 0 or time.perf_counter() - begin < float(seconds):
    passes += 1
    total = total + render(int(first_seed) + passes)
elapsed = time.perf_counter() - begin
mi.Bitmap((total / passes).astype(np.float32)).write(out)
print(passes * SPP, elapsed)
