"""Prints the seconds that Mitsuba 3 takes to load a scene, and its peak resident MB: mitsuba_loading.py SCENE.xml VARIANT."""
import resource
import sys
import time

import mitsuba as mi

mi.set_variant(sys.argv[2])
begin = time.perf_counter()
mi.load_file(sys.argv[1])
print(time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
