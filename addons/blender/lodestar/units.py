"""Units: closed forms from Blender's lamp powers to radiance and intensity, and from lens settings to angles.

Nothing here needs Blender, so that tests can run it anywhere.
"""

from __future__ import annotations

import math


def point_intensity(power: float) -> float:
    """Intensity in W/sr of a point lamp of `power` watts, which shines evenly in all directions."""
    return power / (4.0 * math.pi)


def sphere_radiance(power: float, radius: float) -> float:
    """Radiance of a Lambertian sphere of `power` watts: P / (4 pi^2 r^2)."""
    return power / (4.0 * math.pi**2 * radius**2)


def area_radiance(power: float, area: float) -> float:
    """Radiance of a Lambertian flat lamp of `area` that sheds `power` watts from one side: P / (pi A)."""
    return power / (math.pi * area)


def exposed(power: float, exposure: float) -> float:
    """Power after a lamp's own exposure in stops."""
    return power * 2.0**exposure


def spot_falloff(cosine: float, half_angle: float, blend: float) -> float:
    """Falloff of Blender's spot: smoothstep in the cosine from the cone's rim inwards."""
    edge = math.cos(half_angle)
    width = (1.0 - edge) * blend
    if width <= 1e-6:
        return 1.0 if cosine > edge else 0.0
    t = min(max((cosine - edge) / width, 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def smooth_beam(half_angle: float, blend: float) -> float:
    """Half angle within which `spot_falloff` is 1."""
    edge = math.cos(half_angle)
    return math.acos(min(max(edge + (1.0 - edge) * blend, -1.0), 1.0))


def spot_flux(half_angle: float, blend: float) -> float:
    """Flux of a spot of intensity 1, in closed form: 2 pi times the integral of `spot_falloff` over the cosine.

    A smoothstep has the mean 1/2 over its width, so the flux is that of a cone whose rim lies in the middle of the blend.
    """
    return 2.0 * math.pi * (1.0 - math.cos(half_angle)) * (1.0 - 0.5 * blend)


def linear_spot_flux(cutoff: float, beam: float) -> float:
    """Flux of Mitsuba's spot of intensity 1: full within `beam`, then linear in the angle down to 0 at `cutoff`."""
    if cutoff - beam < 1e-9:
        return 2.0 * math.pi * (1.0 - math.cos(cutoff))
    return 2.0 * math.pi * (1.0 - (math.sin(cutoff) - math.sin(beam)) / (cutoff - beam))


def beam_width(half_angle: float, blend: float) -> float:
    """Beam width in radians that gives Mitsuba's spot the flux of Blender's, as near as a beam within the cone comes."""
    target = spot_flux(half_angle, blend)
    low, high = 0.0, half_angle
    for _ in range(60):
        middle = 0.5 * (low + high)
        if linear_spot_flux(half_angle, middle) < target:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def sun_directions(angle: float, count: int) -> list[tuple[float, float, float]]:
    """Directions that cover a sun of angular diameter `angle` about -z evenly in solid angle, on a sunflower spiral."""
    versine = 1.0 - math.cos(0.5 * angle)
    golden = math.pi * (3.0 - math.sqrt(5.0))
    cosines = ((1.0 - versine * (i + 0.5) / count, i * golden) for i in range(count))
    return [(math.sin(math.acos(c)) * math.cos(phi), math.sin(math.acos(c)) * math.sin(phi), -c) for c, phi in cosines]


def ball_points(count: int) -> list[tuple[float, float, float]]:
    """Points of the unit ball that from every side look like a disk that is evenly bright.

    Their density at a distance r from the center is that whose projection is even: 1 / sqrt(1 - r^2). With r = sin(a), the share within r
    is (a - sin(a) cos(a)) 2 / pi.
    """
    golden = math.pi * (3.0 - math.sqrt(5.0))
    points = []
    for at in range(count):
        share = 0.5 / count + sum((at >> bit & 1) * 0.5 ** (bit + 1) for bit in range(at.bit_length()))
        low, high = 0.0, 0.5 * math.pi
        for _ in range(40):
            middle = 0.5 * (low + high)
            if (middle - math.sin(middle) * math.cos(middle)) * 2.0 / math.pi < share:
                low = middle
            else:
                high = middle
        z = 1.0 - (2.0 * at + 1.0) / count
        radius, flat = math.sin(low), math.sqrt(1.0 - z * z)
        points.append((radius * flat * math.cos(at * golden), radius * flat * math.sin(at * golden), radius * z))
    return points


def sun_irradiance(strength: float, angle: float) -> float:
    """Sum of the irradiances of the parts of a sun, each on a plane that faces its part. `strength` is the irradiance on a plane
    that faces the middle: the radiance is strength / (pi sin^2), and the solid angle 2 pi (1 - cos)."""
    return strength * 2.0 / (1.0 + math.cos(0.5 * angle))


def field_of_view(sensor: float, lens: float) -> float:
    """Field of view in degrees along a sensor's side of `sensor` millimeters behind a lens of `lens` millimeters."""
    return math.degrees(2.0 * math.atan(0.5 * sensor / lens))


def aperture_radius(lens: float, fstop: float) -> float:
    """Radius of the lens opening in scene units, from millimeters and an f-number."""
    return 0.5 * lens * 1e-3 / fstop


def index_from_reflectance(f0: float) -> float:
    """Index of refraction whose reflectance at normal incidence is `f0`."""
    root = math.sqrt(min(max(f0, 0.0), 0.99))
    return (1.0 + root) / (1.0 - root)


def specular_index(ior: float, level: float) -> float:
    """Index of refraction of a Principled surface after its `Specular IOR Level`, which scales the reflectance by twice itself."""
    f0 = ((ior - 1.0) / (ior + 1.0)) ** 2
    return ior if level == 0.5 else index_from_reflectance(f0 * 2.0 * level)


def mean_reflectance(ior: float) -> float:
    """Mean of Schlick's reflectance over the hemisphere, weighted by the cosine: F0 + (1 - F0) / 21."""
    f0 = ((ior - 1.0) / (ior + 1.0)) ** 2
    return f0 + (1.0 - f0) / 21.0


# First temperatures of the ranges in which a blackbody's color has one fit, and the coefficients of the fits: red and green are
# a / t + b t + c, blue is ((a t + b) t + c) t + d. They are Cycles'.
_RANGES = (965.0, 1167.0, 1449.0, 1902.0, 3315.0, 6365.0)
_RED = (
    (1.61919106e03, -2.05010916e-03, 5.02995757e00),
    (2.48845471e03, -1.11330907e-03, 3.22621544e00),
    (3.34143193e03, -4.86551192e-04, 1.76486769e00),
    (4.09461742e03, -1.27446582e-04, 7.25731635e-01),
    (4.67028036e03, 2.91258199e-05, 1.26703442e-01),
    (4.59509185e03, 2.87495649e-05, 1.50345020e-01),
    (3.78717450e03, 9.35907826e-06, 3.99075871e-01),
)
_GREEN = (
    (-4.88999748e02, 6.04330754e-04, -7.55807526e-02),
    (-7.55994277e02, 3.16730098e-04, 4.78306139e-01),
    (-1.02363977e03, 1.20223470e-04, 9.36662319e-01),
    (-1.26571316e03, 4.87340896e-06, 1.27054498e00),
    (-1.42529332e03, -4.01150431e-05, 1.43972784e00),
    (-1.17554822e03, -2.16378048e-05, 1.30408023e00),
    (-5.00799571e02, -4.59832026e-06, 1.09098763e00),
)
_BLUE = (
    (5.96945309e-11, -4.85742887e-08, -9.70622247e-05, -4.07936148e-03),
    (2.40430366e-11, 5.55021075e-08, -1.98503712e-04, 2.89312858e-02),
    (-1.40949732e-11, 1.89878968e-07, -3.56632824e-04, 9.10767778e-02),
    (-3.61460868e-11, 2.84822009e-07, -4.93211319e-04, 1.56723440e-01),
    (-1.97075738e-11, 1.75359352e-07, -2.50542825e-04, -2.22783266e-02),
    (-1.61997957e-13, -1.64216008e-08, 3.86216271e-04, -7.38077418e-01),
    (6.72650283e-13, -2.73078809e-08, 4.24098264e-04, -7.52335691e-01),
)


def blackbody(temperature: float) -> tuple[float, float, float]:
    """Color of a blackbody of some kelvin, linear sRGB, as the node Blackbody gives it."""
    if temperature >= 12000.0:
        return (0.8262954810464208, 0.9945080501520986, 1.566307710274283)
    if temperature < 800.0:
        return (5.413294490189271, 0.0, 0.0)
    at = sum(temperature >= first for first in _RANGES)
    r, g, b = _RED[at], _GREEN[at], _BLUE[at]
    t = temperature
    color = (r[0] / t + r[1] * t + r[2], g[0] / t + g[1] * t + g[2], ((b[0] * t + b[1]) * t + b[2]) * t + b[3])
    return (max(color[0], 0.0), max(color[1], 0.0), max(color[2], 0.0))
