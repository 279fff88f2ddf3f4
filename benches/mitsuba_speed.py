"""Prints the millions of paths per second of Mitsuba 3's `path` integrator: mitsuba_speed.py SCENE.xml WIDTH HEIGHT."""
import sys
import time

import mitsuba as mi
import mitsuba_scene
import numpy as np

SECONDS, SPP = 3.0, 16

mi.set_variant("llvm_ad_rgb")
scene = mi.load_file(sys.argv[1])
width, height = int(sys.argv[2]), int(sys.argv[3])
sensor = mitsuba_scene.sensor(scene, width, height)
integrator = mitsuba_scene.integrator()


def render(seed):
    np.array(mi.render(scene, sensor=sensor, integrator=integrator, spp=SPP, seed=seed))


render(0)
passes, begin = 0, time.perf_counter()
while time.perf_counter() - begin < SECONDS:
    passes += 1
    render(passes)
print(passes * SPP * width * height / (time.perf_counter() - begin) / 1e6)
