"""Closed forms of units, and transforms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from lodestar import exr, images, units, world


def test_lamps_shed_their_power() -> None:
    """The flux of each lamp is its power."""
    assert 4.0 * math.pi * units.point_intensity(7.0) == pytest.approx(7.0)
    assert 4.0 * math.pi * 0.3**2 * math.pi * units.sphere_radiance(7.0, 0.3) == pytest.approx(7.0)
    assert 2.5 * math.pi * units.area_radiance(7.0, 2.5) == pytest.approx(7.0)


def test_points_of_a_ball_look_like_an_even_disk() -> None:
    """The mean square of each coordinate is that of an even disk, 1/4, and so is the share within half of the disk's area."""
    points = np.array(units.ball_points(4096))
    assert (points**2).mean(axis=0) == pytest.approx([0.25] * 3, abs=0.003)
    assert np.abs(points.mean(axis=0)).max() < 0.003
    for axis in range(3):
        seen = np.delete(points, axis, axis=1)
        assert ((seen**2).sum(axis=1) < 0.5).mean() == pytest.approx(0.5, abs=0.01)
    few = np.array(units.ball_points(64))
    assert (few**2).mean(axis=0) == pytest.approx([0.25] * 3, abs=0.03) and np.abs(few.mean(axis=0)).max() < 0.03


def integral(falloff: object, half_angle: float) -> float:
    angles = (np.arange(20000) + 0.5) / 20000 * half_angle
    values = np.array([falloff(angle) for angle in angles])  # type: ignore[operator]
    return float((values * np.sin(angles)).sum() * half_angle / 20000 * 2.0 * math.pi)


@pytest.mark.parametrize("half_angle,blend", [(0.3, 0.0), (0.4, 0.5), (0.7, 1.0), (1.5, 0.15)])
def test_spots_keep_their_flux(half_angle: float, blend: float) -> None:
    """Closed forms agree with numeric integrals, and the beam that is chosen has the flux that is asked for."""
    blender = integral(lambda angle: units.spot_falloff(math.cos(angle), half_angle, blend), half_angle)
    assert units.spot_flux(half_angle, blend) == pytest.approx(blender, rel=1e-3)
    beam = units.beam_width(half_angle, blend)
    linear = lambda angle: min(max((half_angle - angle) / max(half_angle - beam, 1e-9), 0.0), 1.0)  # noqa: E731
    assert units.linear_spot_flux(half_angle, beam) == pytest.approx(integral(linear, half_angle), rel=1e-3)
    assert units.linear_spot_flux(half_angle, beam) == pytest.approx(units.spot_flux(half_angle, blend), rel=1e-2)


def test_sun_is_covered_evenly() -> None:
    """The parts of a sun have its center as their mean, and the mean height of a cap of the sphere."""
    for angle in (0.2, 1.1, math.pi):
        parts = np.array(units.sun_directions(angle, 64))
        assert np.linalg.norm(parts, axis=1) == pytest.approx(np.ones(64))
        assert np.abs(parts[:, :2].mean(axis=0)).max() < 0.02 * math.sin(0.5 * angle)
        assert (1.0 + parts[:, 2]).mean() == pytest.approx(0.5 * (1.0 - math.cos(0.5 * angle)), rel=1e-6)
        # The irradiance on a plane that faces the sun is its strength.
        share = units.sun_irradiance(3.0, angle) / 64
        assert (share * -parts[:, 2]).sum() == pytest.approx(3.0, rel=1e-6)


def test_index_of_refraction() -> None:
    assert units.specular_index(1.5, 0.5) == 1.5
    assert units.specular_index(1.5, 0.0) == 1.0
    assert ((units.specular_index(1.5, 1.0) - 1) / (units.specular_index(1.5, 1.0) + 1)) ** 2 == pytest.approx(0.08)


def test_environment_is_turned_as_in_cycles() -> None:
    """Blender's and Mitsuba's closed forms give one place of the image for any direction."""
    local = np.array(world.ENVIRONMENT).T
    for direction in np.random.default_rng(0).normal(size=(100, 3)):
        x, y, z = direction / np.linalg.norm(direction)
        blender = (0.5 - math.atan2(y, x) / (2 * math.pi), 0.5 - math.asin(z) / math.pi)
        a, b, c = local @ (x, y, z)
        mitsuba = (math.atan2(a, -c) / (2 * math.pi) % 1.0, math.acos(b) / math.pi)
        assert mitsuba == pytest.approx(blender, abs=1e-6)


def test_turned_texture_coordinates() -> None:
    """A transform of UVs, seen with v downwards."""
    rows = ((1.5, 0.3, 0.1), (-0.2, 0.7, 0.2), (0.0, 0.0, 1.0))
    flipped = np.array(images._flipped(rows))
    u, v = 0.3, 0.8
    expected = np.array(rows) @ (u, v, 1.0)
    found = flipped @ (u, 1.0 - v, 0.0, 1.0)
    assert found[:2] == pytest.approx((expected[0], 1.0 - expected[1]))


def test_exr_files(tmp_path: object) -> None:
    """What is written is read, and a file that is cut short is an error that names it."""
    path = tmp_path / "a.exr"  # type: ignore[operator]
    colors = np.random.default_rng(0).normal(size=(5, 7, 3)).astype(np.float32)
    exr.write(path, colors)
    assert (exr.read(path).layer(["R", "G", "B"]) == colors).all()
    for length in (3, 40, 200, path.stat().st_size - 5):
        short = tmp_path / "short.exr"  # type: ignore[operator]
        short.write_bytes(path.read_bytes()[:length])
        with pytest.raises(ValueError, match="short.exr"):
            exr.read(short)
