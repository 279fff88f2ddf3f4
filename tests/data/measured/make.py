"""Small files of measured materials, of microfacets in place of measurements: `isotropic.bsdf` and `anisotropic.bsdf` with colors,
`spectral.bsdf` with spectra, in the format of Dupuy and Jakob (2018). `values.json` has Mitsuba's values of them. Run with Mitsuba
3.9.1 and NumPy installed; `wo` goes to the eye, `wi` to the light."""

import json
import math
import os
import random
import struct

import numpy as np

FOLDER = os.path.dirname(os.path.abspath(__file__))
COLOR = np.array([0.95, 0.65, 0.35])
WAVELENGTHS = [380.0, 470.0, 550.0, 640.0, 800.0]
SPECTRUM = np.array([0.3, 0.35, 0.6, 0.95, 0.9])
TYPES = {np.uint8: 1, np.float32: 10}


def write(name, fields):
    """Writes a tensor file: a header with the places of all fields, then their numbers."""
    header = 18 + sum(2 + len(key) + 2 + 1 + 8 + 8 * array.ndim for key, array in fields.items())
    head, body = b"tensor_file\0" + bytes([1, 0]) + struct.pack("<I", len(fields)), b""
    for key, array in fields.items():
        head += struct.pack("<H", len(key)) + key.encode() + struct.pack("<H", array.ndim)
        head += struct.pack("<BQ", TYPES[array.dtype.type], header + len(body))
        head += struct.pack(f"<{array.ndim}Q", *array.shape)
        body += array.tobytes()
    assert len(head) == header
    with open(os.path.join(FOLDER, name), "wb") as file:
        file.write(head + body)


class Facets:
    """GGX facets (Walter et al. 2007)."""

    def __init__(self, alpha_u, alpha_v):
        self.alpha = np.array([alpha_u, alpha_v])

    def density(self, m):
        slopes = m[:2] / self.alpha
        return 1.0 / (math.pi * self.alpha.prod() * (slopes @ slopes + m[2] ** 2) ** 2)

    def area(self, w):
        """Projected area of the facets that `w` sees."""
        stretched = self.alpha * w[:2]
        return 0.5 * (w[2] + math.sqrt(stretched @ stretched + w[2] ** 2))

    def masking(self, wo, wi):
        """Share of the facets visible from `wo` that are visible from `wi`, too."""
        first, second = (self.area(w) / max(w[2], 1.0e-6) - 1.0 for w in (wo, wi))
        return (1.0 + first) / (1.0 + first + second)


def direction(theta, phi):
    return np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])


def angles(u):
    """Elevation and azimuth of a point of the unit square (Dupuy and Jakob 2018, equation 14)."""
    return 0.5 * math.pi * u[0] ** 2, (2.0 * u[1] - 1.0) * math.pi


def grid(size):
    """Points of a grid over the unit square: its rows, and in each its columns."""
    return [[np.array([x, y]) / (size - 1) for x in range(size)] for y in range(size)]


def fraction(area, start, end):
    """Place in [0, 1] up to which a line from `start` to `end` covers this area."""
    return 2.0 * area / max(start + math.sqrt(max(start * start + 2.0 * area * (end - start), 0.0)), 1.0e-30)


def warp(table, s):
    """Point at which a bilinear density has the shares `s` of its mass before it: in the row, and in the rows."""
    totals = 0.5 * (table[:, 1:] + table[:, :-1]).sum(1)
    rows = np.concatenate([[0.0], np.cumsum(0.5 * (totals[1:] + totals[:-1]))])
    y = s[1] * rows[-1]
    row = int(np.clip(np.searchsorted(rows, y, side="right") - 1, 0, len(totals) - 2))
    v = fraction(y - rows[row], totals[row], totals[row + 1])
    line = (1.0 - v) * table[row] + v * table[row + 1]
    columns = np.concatenate([[0.0], np.cumsum(0.5 * (line[1:] + line[:-1]))])
    x = s[0] * columns[-1]
    column = int(np.clip(np.searchsorted(columns, x, side="right") - 1, 0, len(line) - 2))
    u = fraction(x - columns[column], line[column], line[column + 1])
    return np.array([(column + u) / (len(line) - 1), (row + v) / (len(totals) - 1)])


def tables(facets, thetas, phis, size, sample_size):
    """Tables of the facets, as they would be measured, and the share of light that a white facet reflects at each sample."""
    isotropic = len(phis) <= 2
    ndf = [[facets.density(direction(*angles(u))) for u in row] for row in grid(size)]
    sigma = [[facets.area(direction(*angles(u))) for u in row] for row in grid(size)]
    vndf, shares, cosines = [], [], []
    for phi in phis:
        for theta in thetas:
            wo = direction(theta, phi)
            turn = phi if isotropic else 0.0

            def facet(u):
                elevation, azimuth = angles(u)
                return elevation, direction(elevation, azimuth + turn)

            def visible(u):
                elevation, m = facet(u)
                jacobian = 2.0 * math.pi ** 2 * u[0] * math.sin(elevation)
                return jacobian * facets.density(m) * max(m @ wo, 0.0) / facets.area(wo)

            table = np.array([[visible(u) for u in row] for row in grid(size)])
            for row in grid(sample_size):
                for s in row:
                    _, m = facet(warp(table, s))
                    wi = 2.0 * (m @ wo) * m - wo
                    shares.append(facets.masking(wo, wi) if wi[2] > 0.0 else 0.0)
                    cosines.append(max(m @ wo, 0.0))
            vndf.append(table)
    shape = (len(phis), len(thetas))
    sampled = (*shape, sample_size, sample_size)
    single = lambda values, shape: np.array(values, np.float32).reshape(shape)
    return {
        "theta_i": single(thetas, -1), "phi_i": single(phis, -1), "ndf": single(ndf, (size, size)),
        "sigma": single(sigma, (size, size)), "vndf": single(vndf, (*shape, size, size)),
    }, np.array(shares).reshape(sampled), np.array(cosines).reshape(sampled)


def material(name, facets, thetas, phis, colors, wavelengths=None):
    """Writes a file. The reflectance of facets rises toward 1 where light grazes them (Schlick 1994)."""
    fields, shares, cosines = tables(facets, thetas, phis, 16, 8)
    white = (1.0 - cosines) ** 5
    spectra = [shares * (color + (1.0 - color) * white) for color in colors]
    fields["luminance"] = np.float32(sum(spectra) / len(spectra))
    fields["spectra" if wavelengths else "rgb"] = np.float32(np.stack(spectra, 2))
    if wavelengths:
        fields["wavelengths"] = np.float32(wavelengths)
    fields["description"] = np.frombuffer(b"Microfacets", np.uint8)
    fields["jacobian"] = np.ones(1, np.uint8)
    write(name, fields)


def numbers(values):
    return [float(f"{float(value):.7g}") for value in values]


def white_light(mi, spectrum):
    """Linear sRGB of light that is reflected by these shares, under D65 (IEC 61966-2-1). White is white."""
    d65, si = mi.load_dict({"type": "d65"}), mi.SurfaceInteraction3f()
    total, white = np.zeros(3), np.zeros(3)
    for wavelength in range(360, 831):
        si.wavelengths = [wavelength] * 4
        light = float(d65.eval(si)[0]) * np.array(mi.cie1931_xyz(float(wavelength))).ravel()
        total += np.interp(wavelength, WAVELENGTHS, spectrum) * light
        white += light
    total, white = (np.array(mi.xyz_to_srgb(mi.Color3f(*xyz))).ravel() for xyz in (total, white))
    return total / white


def rows(name, variant):
    import mitsuba as mi
    mi.set_variant(variant)
    drawn = random.Random(1)
    bsdf = mi.load_dict({"type": "measured", "filename": os.path.join(FOLDER, name)})
    context, si = mi.BSDFContext(), mi.SurfaceInteraction3f()

    def value(wi):
        if variant == "scalar_rgb":
            return numbers(bsdf.eval(context, si, wi))
        spectrum = []
        for wavelength in WAVELENGTHS:
            si.wavelengths = [wavelength] * 4
            spectrum.append(float(bsdf.eval(context, si, wi)[0]))
        return numbers(white_light(mi, spectrum))

    for index in range(80):
        azimuth, cosine = math.tau * drawn.random(), 0.05 + 0.94 * drawn.random()
        si.wi = mi.Vector3f(direction(math.acos(cosine), azimuth))
        u = [drawn.random() for _ in range(3)]
        sample, _ = bsdf.sample(context, si, u[2], mi.Point2f(u[:2]))
        wi = sample.wo
        if index % 3 == 2 or sample.pdf == 0.0 or wi.z < 0.02:
            wi = mi.Vector3f(direction(math.acos(0.05 + 0.95 * drawn.random()), math.tau * drawn.random()))
        yield {"file": name, "wo": numbers(si.wi), "wi": numbers(wi), "u": numbers(u), "sampled": numbers(sample.wo),
               "eval": value(wi), "pdf": numbers([bsdf.pdf(context, si, wi)])[0]}


def main():
    thetas, quarter = [0.0, 0.5, 1.0, 1.45], 0.5 * math.pi
    material("isotropic.bsdf", Facets(0.3, 0.3), thetas, [0.0], COLOR)
    material("anisotropic.bsdf", Facets(0.25, 0.6), thetas, [-2.0 * quarter, -1.5 * quarter, -quarter], COLOR)
    material("spectral.bsdf", Facets(0.5, 0.5), thetas, [0.0], SPECTRUM, WAVELENGTHS)
    found = [*rows("isotropic.bsdf", "scalar_rgb"), *rows("anisotropic.bsdf", "scalar_rgb"),
             *rows("spectral.bsdf", "scalar_spectral")]
    with open(os.path.join(FOLDER, "values.json"), "w") as file:
        file.write("[\n" + ",\n".join(map(json.dumps, found)) + "\n]\n")


main()
