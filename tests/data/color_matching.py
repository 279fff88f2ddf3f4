"""Prints the tables of src/scene/color_matching.rs: the CIE 1931 observer and the illuminant D65 as Mitsuba holds them.

Run with Mitsuba 3.9 installed: python3 tests/data/color_matching.py
"""

import mitsuba as mi

mi.set_variant("scalar_rgb")

for wavelength in range(360, 831, 5):
    x, y, z = (float(value) for value in mi.cie1931_xyz(wavelength))
    row = (round(value, 9) for value in (x, y, z, float(mi.cie_d65(wavelength))))
    print("    [" + ", ".join(f"{value:.9f}".rstrip("0").ljust(3, "0") for value in row) + "],")
