"""Prints the table of src/scene/named_conductors.rs: what Mitsuba's rgb variants reduce each named conductor to.

Run with Mitsuba 3.9 installed: python3 tests/data/mitsuba_conductors.py
"""

import os

import mitsuba as mi

mi.set_variant("scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)


def names():
    folder = os.path.join(os.path.dirname(mi.__file__), "data", "ior")
    return sorted(file[: -len(".eta.spd")] for file in os.listdir(folder) if file.endswith(".eta.spd"))


def rust(color):
    return "[" + ", ".join(str(round(float(channel), 6)) for channel in color) + "]"


for name in names():
    parameters = mi.traverse(mi.load_dict({"type": "conductor", "material": name}))
    print(f'    ("{name}", {rust(parameters["eta.value"])}, {rust(parameters["k.value"])}),')
