"""Models of the atmosphere of Blender's Sky Texture.

They are those of Blender's files `sky_multiple_scattering.cpp` (Fernando García Liñán and Blender authors, MIT license) and
`sky_single_scattering.cpp` (Blender authors, Apache License 2.0). Directions have `z` up, and the sun stands at the azimuth 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np


class Air(NamedTuple):
    """Height of the viewer in meters, and densities of what the atmosphere consists of, relative to the models'."""

    altitude: float
    molecules: float
    aerosols: float
    ozone: float


def to_atmosphere(height: np.ndarray, cosine: np.ndarray, radius: float) -> np.ndarray:
    """Distance from a point to a sphere around the planet's center. The point has the distance `height` from the center, and the ray
    the cosine `cosine` to its zenith; the larger of two distances."""
    along = height * cosine
    return -along + np.sqrt(np.maximum(along * along - (height * height - radius * radius), 0.0))


class MultipleScattering:
    """Atmosphere of which light is scattered many times, at four wavelengths. Lengths are in kilometers."""

    PLANET, TOP = 6371.0, 6471.0
    STEPS = 64
    COLUMNS, ROWS = 256, 64
    ASYMMETRY = 0.8
    SUN = np.array([1.679, 1.828, 1.986, 1.307])
    MOLECULES = np.array([6.605e-3, 1.067e-2, 1.842e-2, 3.156e-2])
    OZONE = 334.5 * np.array([3.472e-25, 3.914e-25, 1.349e-25, 11.03e-27])
    AEROSOL_ABSORPTION = np.array([2.8722e-24, 4.6168e-24, 7.9706e-24, 1.3578e-23])
    AEROSOL_SCATTERING = np.array([1.5908e-22, 1.7711e-22, 2.0942e-22, 2.4033e-22])
    XYZ = np.array([
        [53.386917738564668023, 22.981337506691024754, 0.0],
        [43.904844466369358263, 71.347795700053393866, 0.102506867965741307],
        [1.6137278251608962005, 18.422960591455485011, 31.742921188390805758],
        [20.762668673810577145, 2.3614213523314368527, 110.48009643252140334],
    ])  # fmt: skip

    def __init__(self, air: Air) -> None:
        self.air = air
        self.altitude = min(max(air.altitude, 1.0), 99999.0) / 1000.0
        cosines = np.linspace(-1.0, 1.0, self.COLUMNS)[None, :]
        heights = np.linspace(self.PLANET, self.TOP, self.ROWS)[:, None]
        self._transmittances = self._transmittance(heights, cosines)

    def _scattering(self, altitude: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Coefficients of scattering by molecules and by aerosols, and of extinction."""
        h = altitude[..., None]
        molecules = self.MOLECULES * np.exp(-0.07771971 * h**1.16364243) * self.air.molecules
        log = np.log(np.maximum(h, 1e-4))
        ozone = self.OZONE * (3.78547397e20 * np.exp(-((log - 3.22261) ** 2) * 5.55555555 - log)) * self.air.ozone
        aerosols = 1.3681e20 * (np.exp(-h / 0.73) + 2e6 / 1.3681e20) * self.air.aerosols
        scattering = self.AEROSOL_SCATTERING * aerosols
        return molecules, scattering, molecules + scattering + ozone + self.AEROSOL_ABSORPTION * aerosols

    def _transmittance(self, height: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Transmittance from a distance from the planet's center to the sun."""
        step = to_atmosphere(height, cosine, self.TOP) / self.STEPS
        depth = 0.0
        for at in range(self.STEPS):
            t = (at + 0.5) * step
            altitude = np.maximum(np.sqrt(height * height + t * t + 2.0 * height * cosine * t) - self.PLANET, 0.0)
            depth = depth + self._scattering(altitude)[2] * step[..., None]
        return np.exp(-depth)

    def _looked_up(self, cosine: np.ndarray, altitude: np.ndarray) -> np.ndarray:
        x = np.clip(cosine * 0.5 + 0.5, 0.0, 1.0) * (self.COLUMNS - 1)
        y = np.clip(altitude, 0.0, 1.0) * (self.ROWS - 1)
        column, row = x.astype(int), y.astype(int)
        s, t = (x - column)[..., None], (y - row)[..., None]
        right, above = np.minimum(column + 1, self.COLUMNS - 1), np.minimum(row + 1, self.ROWS - 1)
        table = self._transmittances
        return (1 - t) * ((1 - s) * table[row, column] + s * table[row, right]) + t * (
            (1 - s) * table[above, column] + s * table[above, right]
        )

    def _scattered_before(self, cosine: np.ndarray, altitude: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """Light that has been scattered by the ground and by the air, for each unit of the sun's."""
        omega = 2.0 * math.pi * (1.0 - np.sqrt(np.maximum(1.0 - (self.PLANET / distance) ** 2, 0.0)))
        one, none = np.ones_like(cosine), np.zeros_like(cosine)
        to_sample = self._looked_up(one, none) / self._looked_up(one, altitude)
        ground = (0.3 / math.pi / (4.0 * math.pi)) * (omega * cosine)[..., None] * self._looked_up(cosine, none) * to_sample
        fit = 0.02 * np.array([0.217, 0.347, 0.594, 1.0]) / (1.0 + 5.0 * np.exp(-17.92 * cosine))[..., None]
        return fit + ground

    def half_table(self, elevation: float, columns: int, rows: int) -> np.ndarray:
        """Colors in XYZ of elevations and of azimuths up to half a turn, for the sun's elevation in radians."""
        azimuth = 2.0 * math.pi * (np.arange(columns) + 0.5)[None, :] / (2 * columns)
        l = ((np.arange(rows) + 0.5) / rows * 2.0 - 1.0)[:, None]
        angle = np.copysign(l * l, l) * (0.5 * math.pi)
        sun = np.array([math.cos(elevation), 0.0, math.sin(elevation)])
        direction = np.stack(np.broadcast_arrays(np.cos(angle) * np.cos(azimuth), np.cos(angle) * np.sin(azimuth), np.sin(angle)), axis=-1)
        return self._inscattered(direction, sun) @ self.XYZ

    def _inscattered(self, direction: np.ndarray, sun: np.ndarray) -> np.ndarray:
        height = self.PLANET + self.altitude
        z = direction[..., 2]
        reaches_ground = (z < 0.0) & ((height * z) ** 2 >= height**2 - self.PLANET**2)
        to_ground = -height * z - np.sqrt(np.maximum((height * z) ** 2 - (height**2 - self.PLANET**2), 0.0))
        step = np.where(reaches_ground, to_ground, to_atmosphere(np.full_like(z, height), z, self.TOP)) / self.STEPS
        cosine = -(direction @ sun)
        g = self.ASYMMETRY
        denominator = 1.0 + g * g + 2.0 * g * cosine
        rayleigh = (3.0 / (16.0 * math.pi) * (1.0 + cosine * cosine))[..., None]
        mie = ((1.0 - g * g) / (4.0 * math.pi) / (denominator * np.sqrt(denominator)))[..., None]
        light, passed = 0.0, 1.0
        for at in range(self.STEPS):
            t = ((at + 0.5) * step)[..., None]
            place = np.array([0.0, 0.0, height]) + direction * t
            distance = np.linalg.norm(place, axis=-1)
            altitude = np.maximum(distance - self.PLANET, 0.0)
            share = altitude / (self.TOP - self.PLANET)
            to_sun = (place @ sun) / distance
            molecules, aerosols, extinction = self._scattering(altitude)
            direct, before = self._looked_up(to_sun, share), self._scattered_before(to_sun, share, distance)
            source = self.SUN * (molecules * (rayleigh * direct + before) + aerosols * (mie * direct + before))
            through = np.exp(-step[..., None] * extinction)
            light = light + passed * (source - source * through) / np.maximum(extinction, 1e-7)
            passed = passed * through
        return light

    def sun(self, elevation: float) -> np.ndarray:
        """Irradiance in XYZ of a sun of which all light comes from one elevation."""
        # Altitudes are shares of the atmosphere's thickness.
        height, cosine = np.array(self.PLANET + self.altitude), np.array(math.sin(elevation))
        return (self.SUN * self._transmittance(height, cosine)) @ self.XYZ


class SingleScattering:
    """Atmosphere of which light is scattered once, at 21 wavelengths. Lengths are in meters."""

    PLANET, TOP = 6360e3, 6420e3
    STEPS = 32
    ASYMMETRY = 0.76
    # Distance in nanometers between the wavelengths, from 380.
    WAVELENGTH_STEP = 20.0
    AEROSOLS = 2e-5
    SUN = np.array(
        """1.45756829855592995315 1.56596305557738380175 1.65148449067670455293 1.71496242737209314555 1.75797983805020541226
        1.78256407885924539336 1.79095108475838560302 1.78541550133410664714 1.76815554864306845317 1.74122069647250410362
        1.70647127164943679389 1.66556087452739887134 1.61993437242451854274 1.57083597368892080581 1.51932335059305478886
        1.46628494965214395407 1.41245852740172450623 1.35844961970384092709 1.30474913844739281998 1.25174963272610817455
        1.19975998755420620867""".split(),
        float,
    )
    MOLECULES = 1e-5 * np.array(
        """5.424820087636473 4.418549866505454 3.635151910165377 3.017929012024763 2.526320226989157 2.130859310621843
        1.809838025320633 1.547057129129042 1.330284977336850 1.150184784075764 0.999557429990163 0.872799973630707
        0.765513700977967 0.674217203751443 0.596134125832052 0.529034598065810 0.471115687557433 0.420910481110487
        0.377218381260133 0.339051255477280 0.305591531679811""".split(),
        float,
    )
    OZONE = 1e-7 * np.array(
        """0.0325126849861 0.0585395365047 0.1977191155085 0.7309568762914 2.0084561514287 4.0383958096161 6.3551335912363
        9.6707041180970 15.4797400424410 20.9038647223331 24.6128056164565 27.3551299461512 21.5125863128643 15.9051840791988
        11.2356197979857 7.3527551487574 4.6450130357806 3.3096079921048 2.2512612292678 1.4879129266490 1.6828623364192""".split(),
        float,
    )
    XYZ = np.array(
        """0.001368 0.000039 0.006450001 0.01431 0.000396 0.06785001 0.13438 0.004 0.6456 0.34828 0.023 1.74706 0.2908 0.06 1.6692
        0.09564 0.13902 0.8129501 0.0049 0.323 0.272 0.06327 0.71 0.07824999 0.2904 0.954 0.0203 0.5945 0.995 0.0039
        0.9163 0.87 0.001650001 1.0622 0.631 0.0008 0.8544499 0.381 0.00019 0.4479 0.175 0.00002 0.1649 0.061 0 0.04677 0.017 0
        0.01135916 0.004102 0 0.002899327 0.001047 0 0.0006900786 0.0002492 0 0.0001661505 0.00006 0 0.00004150994 0.00001499 0""".split(),
        float,
    ).reshape(21, 3)
    # Nodes and weights of a quadrature of Gauss and Laguerre, with exponentials, over the distance to the top.
    NODES = (0.006811185292, 0.03614807107, 0.09004346519, 0.1706680068, 0.2818362161, 0.4303406404, 0.6296271457, 0.9145252695)
    WEIGHTS = (0.01750893642, 0.04135477391, 0.06678839063, 0.09507698807, 0.1283416365, 0.1707430204, 0.2327233347, 0.3562490486)

    def __init__(self, air: Air) -> None:
        self.air = air
        self.height = self.PLANET + min(max(air.altitude, 1.0), 59999.0)
        self.densities = np.array([air.molecules, air.aerosols, air.ozone])
        self.extinction = np.stack([self.MOLECULES, np.full(21, 1.11 * self.AEROSOLS), self.OZONE])

    def _density(self, distance: np.ndarray) -> np.ndarray:
        """Densities of molecules, aerosols and ozone at distances from the planet's center."""
        # Where the planet hides the sun, the path to the sun goes through the planet.
        h = np.maximum(distance - self.PLANET, 0.0)
        ozone = np.maximum(0.0, 1.0 - np.abs(h - 25e3) / 15e3)
        return np.stack([np.exp(-h / 8e3), np.exp(-h / 1.2e3), ozone], axis=-1)

    def _depth(self, height: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Integrals of the densities from a distance from the planet's center to the top."""
        whole = to_atmosphere(height, cosine, self.TOP)
        depth = 0.0
        for node, weight in zip(self.NODES, self.WEIGHTS):
            t = node * whole
            depth = depth + weight * self._density(np.sqrt(height * height + t * t + 2.0 * height * cosine * t))
        return depth * whole[..., None]

    def half_table(self, elevation: float, columns: int, rows: int) -> np.ndarray:
        """Colors in XYZ of elevations and of azimuths up to half a turn. Below the horizon, its colors fade."""
        azimuth = math.pi * (np.arange(columns) + 0.5)[None, :] / columns
        l = (np.arange(rows) + 0.5) / rows * 2.0 - 1.0
        angle = (l * l * 0.5 * math.pi)[rows // 2 :, None]
        parts = np.broadcast_arrays(np.cos(angle) * np.cos(azimuth), np.cos(angle) * np.sin(azimuth), np.sin(angle))
        sun = np.array([math.cos(elevation), 0.0, math.sin(elevation)])
        above = self._inscattered(np.stack(parts, axis=-1), sun) @ (self.XYZ * self.WAVELENGTH_STEP)
        fade = np.maximum(1.0 - 2.5 * np.sin(angle[::-1]), 0.0) ** 3
        return np.concatenate([above[:1] * fade[..., None], above])

    def _inscattered(self, direction: np.ndarray, sun: np.ndarray) -> np.ndarray:
        z = direction[..., 2]
        step = to_atmosphere(np.full_like(z, self.height), z, self.TOP) / self.STEPS
        cosine = direction @ sun
        g = self.ASYMMETRY
        rayleigh = 3.0 / (16.0 * math.pi) * (1.0 + cosine**2)
        mie = 3.0 * (1.0 - g * g) * (1.0 + cosine**2) / (8.0 * math.pi * (2.0 + g * g) * (1.0 + g * g - 2.0 * g * cosine) ** 1.5)
        depth, light = 0.0, 0.0
        for at in range(self.STEPS):
            place = np.array([0.0, 0.0, self.height]) + direction * ((at + 0.5) * step)[..., None]
            distance = np.linalg.norm(place, axis=-1)
            to_sun = (place @ sun) / distance
            density = self.densities * self._density(distance)
            depth = depth + step[..., None] * density
            total = depth + self.densities * self._depth(distance, to_sun)
            # Where the planet hides the sun.
            hidden = (sun[2] < 0.0) & ((distance * to_sun) ** 2 >= distance**2 - self.PLANET**2)
            scattered = (rayleigh * density[..., 0])[..., None] * self.MOLECULES + (mie * density[..., 1])[..., None] * self.AEROSOLS
            weight = np.where(hidden, 0.0, step)[..., None]
            light = light + weight * np.exp(-(total @ self.extinction)) * scattered * self.SUN
        return light

    def sun(self, elevation: float) -> np.ndarray:
        """Irradiance in XYZ of a sun of which all light comes from one elevation."""
        cosine = np.array(math.sin(max(elevation, 0.0)))
        depth = (self.densities * self._depth(np.array(self.height), cosine))[:2]
        return (self.SUN * np.exp(-(depth @ self.extinction[:2]))) @ (self.XYZ * self.WAVELENGTH_STEP)
