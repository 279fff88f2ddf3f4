#!/usr/bin/env python3
"""Writes values.json: colors of thin films from Airy's formula at 941 wavelengths, and prints the Gaussians of glsl/include/math/thin_film.glsl.

It needs numpy. A color is the mean of the reflectance of unpolarized light, weighted with the curve of red, green or blue of the CIE 1931
standard observer (src/scene/color_matching.rs) over the wavelength, where each curve has the integral 1.
"""

import json
import math
import re
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
SRGB_FROM_XYZ = np.array([[3.240479, -1.537150, -0.498535], [-0.969256, 1.875991, 0.041556], [0.055648, -0.204043, 1.057311]])


def curves():
    """Wavelengths in nanometers, evenly, and the weights of red, green and blue."""
    text = (HERE / "../../../src/scene/color_matching.rs").read_text()
    rows = re.findall(r"\[([\d.e-]+), ([\d.e-]+), ([\d.e-]+), ([\d.e-]+)\],", text)
    table = np.array(rows, dtype=float)[:, :3]
    wavelengths = np.arange(360.0, 830.01, 0.5)
    xyz = np.array([np.interp(wavelengths, 360.0 + 5.0 * np.arange(len(table)), column) for column in table.T])
    rgb = SRGB_FROM_XYZ @ xyz
    return wavelengths, rgb / rgb.sum(1, keepdims=True)


WAVELENGTHS, WEIGHTS = curves()


def fresnel(n1, n2, c1):
    """Amplitudes of both polarizations, and the cosine behind."""
    c2 = np.sqrt(1.0 - (n1 / n2) ** 2 * (1.0 - c1**2) + 0j)
    c2 = -c2 if c2.imag < 0.0 else c2
    return (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2), (n2 * c1 - n1 * c2) / (n2 * c1 + n1 * c2), c2


def reflectance(film, thickness, base, cosine):
    """Red, green and blue of a film over a base of one complex index."""
    s12, p12, c2 = fresnel(1.0, film, cosine)
    s23, p23, _ = fresnel(film + 0j, base, c2)
    turn = np.exp(2j * np.pi * 2.0 * film * thickness * c2.real / WAVELENGTHS)
    at = [abs((a + b * turn) / (1.0 + a * b * turn)) ** 2 for a, b in ((s12, s23), (p12, p23))]
    return (WEIGHTS * (0.5 * (at[0] + at[1]))).sum(1)


def values():
    rng = np.random.default_rng(1)
    rows = []
    for i in range(300):
        film, thickness = rng.uniform(1.05, 2.5), rng.uniform(5.0, 2000.0)
        cosine = 1.0 if i % 3 == 0 else rng.uniform(0.1, 1.0)
        is_metal = i % 2 == 1
        eta = rng.uniform(0.1, 3.0, 3) if is_metal else np.full(3, rng.uniform(1.1, 2.5))
        k = rng.uniform(1.0, 6.0, 3) if is_metal else np.zeros(3)
        color = [reflectance(film, thickness, complex(eta[c], k[c]), cosine)[c] for c in range(3)]
        row = {"film": film, "thickness": thickness, "cosine": cosine, "eta": eta, "k": k, "color": color, "metal": is_metal}
        rounded = lambda x: [round(float(y), 6) for y in x] if np.ndim(x) else round(float(x), 6)
        rows.append({name: x if isinstance(x, bool) else rounded(x) for name, x in row.items()})
    (HERE / "values.json").write_text("[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]\n")


def fit(count=4):
    """Prints Gaussians over the wavenumber, by Levenberg and Marquardt's method; the areas follow from centers and widths."""
    wavenumbers = 1000.0 / WAVELENGTHS[::-1]
    grid = np.linspace(wavenumbers[0], wavenumbers[-1], 600)
    per_wavenumber = (WEIGHTS / 0.5 * WAVELENGTHS**2 / 1000.0)[:, ::-1]
    target = np.array([np.interp(grid, wavenumbers, curve) for curve in per_wavenumber])

    def heights(p):
        basis = np.exp(-((grid - p[:count, None]) ** 2) / (2.0 * np.exp(2.0 * p[count:, None])))
        # The areas of each color have the sum 1.
        rows = np.vstack([basis.T, 1e3 * np.exp(p[None, count:]) * math.sqrt(2.0 * math.pi)])
        found = np.linalg.lstsq(rows, np.vstack([target.T, np.full((1, 3), 1e3)]), rcond=None)[0].T
        return found, (found @ basis - target).ravel()

    def descend(p, rounds=200):
        damping, off = 1e-2, heights(p)[1]
        for _ in range(rounds):
            slopes = np.array([(heights(p + 1e-5 * unit)[1] - off) / 1e-5 for unit in np.eye(2 * count)]).T
            square = slopes.T @ slopes
            while damping < 1e8:
                step = np.linalg.lstsq(square + damping * np.diag(np.diag(square)), -slopes.T @ off, rcond=None)[0]
                there = heights(p + step)[1]
                if there @ there < off @ off:
                    p, off, damping = p + step, there, damping / 3.0
                    break
                damping *= 3.0
            else:
                break
        return off @ off, p

    rng = np.random.default_rng(1)
    starts = [np.concatenate([np.sort(rng.uniform(1.5, 2.4, count)), np.log(rng.uniform(0.04, 0.12, count))]) for _ in range(12)]
    _, p = min((descend(start) for start in starts), key=lambda found: found[0])
    order = np.argsort(p[:count])
    widths = np.exp(p[count:])
    print("centers", p[:count][order].round(5))
    print("spreads", (2.0 * math.pi**2 * widths**2)[order].round(6))
    print("areas", (heights(p)[0] * widths * math.sqrt(2.0 * math.pi))[:, order].T.round(5))


if __name__ == "__main__":
    values()
    fit()
