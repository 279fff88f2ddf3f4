"""Measures Mitsuba 3 on request, compiled and warm: mitsuba_baseline.py VARIANT.

Reads requests from standard input, a JSON array a line, and answers each with a line: seconds, or `none`.
  ["load", SCENE]                      loading the scene
  ["rays", SCENE, RAYS, ANY_HIT]       all rays of a file once: records of 8 words, origin, direction, length, unused
  ["render", SCENE, WIDTH, HEIGHT, SPP]
"""
import json
import sys
import time

import drjit as dr
import mitsuba as mi
import mitsuba_scene
import numpy as np

AT_LEAST = 0.15

mi.set_variant(sys.argv[1])
scenes, rays, sensors = {}, {}, {}


def scene_of(path):
    if path not in scenes:
        scenes[path] = mi.load_file(path)
    return scenes[path]


def load(path):
    begin = time.perf_counter()
    mi.load_file(path)
    return time.perf_counter() - begin


def rays_of(path):
    if path not in rays:
        words = np.fromfile(path, dtype=np.float32).reshape(-1, 8)
        columns = [np.ascontiguousarray(words[:, i]) for i in range(7)]
        rays[path] = mi.Ray3f(mi.Point3f(*columns[0:3]), mi.Vector3f(*columns[3:6]), mi.Float(columns[6]), 0.0, [])
        dr.eval(rays[path])
    return rays[path]


def trace(path, file, any_hit):
    scene, batch = scene_of(path), rays_of(file)
    dr.sync_thread()
    passes, begin = 0, time.perf_counter()
    while passes == 0 or time.perf_counter() - begin < AT_LEAST:
        passes += 1
        if any_hit:
            dr.eval(scene.ray_test(batch))
        else:
            found = scene.ray_intersect_preliminary(batch, coherent=False)
            dr.eval(found.t, found.prim_index)
        dr.sync_thread()
    return (time.perf_counter() - begin) / passes


def render(path, width, height, spp):
    scene = scene_of(path)
    key = (path, width, height)
    if key not in sensors:
        sensors[key] = mitsuba_scene.sensor(scene, width, height), mitsuba_scene.integrator()
    sensor, integrator = sensors[key]
    begin = time.perf_counter()
    np.array(mi.render(scene, sensor=sensor, integrator=integrator, spp=spp, seed=int(begin * 1e6) & 0xffffff))
    return time.perf_counter() - begin


print("ready", mi.__version__, flush=True)
for line in sys.stdin:
    name, *arguments = json.loads(line)
    try:
        print({"load": load, "rays": trace, "render": render}[name](*arguments), flush=True)
    except Exception as error:  # Whatever goes wrong, the bench goes on without this number.
        print(f"{name}: {error}", file=sys.stderr)
        print("none", flush=True)
