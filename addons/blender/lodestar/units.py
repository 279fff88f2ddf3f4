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
