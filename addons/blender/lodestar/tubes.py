"""Tubes: strands of hair as triangles.

A strand is a Catmull-Rom spline through its points, swept by a circle and open at both ends, or the hull of spheres at its points: the two
shapes of Cycles' 3D curves. The radius is a fourth coordinate of the spline. Its rings stand as densely as straight lines between them need.
A frame that turns as little as possible goes along the strand, so that the sides do not twist.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple, Optional

import numpy as np

# Numbers of sides, the preferred one first. Few are enough for what is thin.
SIDES = (26, 19, 13, 10, 7, 5, 4, 3)
# Radius over length below which a strand is thin, and the number of its sides.
THIN, SIDES_OF_THIN = 0.02, 13
# Largest distance between a strand and straight lines with the preferred number of sides, as shares of the length and of the radius.
SAG_OF_LENGTH, SAG_OF_RADIUS = 2e-4, 0.0025
# Largest turn from one ring to the next, in radians.
MOST_TURN = 0.8
# Rings that are joined at one time, which bounds the memory.
RINGS_AT_ONCE = 1 << 17
# Number of triangles above which there are fewer sides: the larger of the first and of that of each strand, and never more than the last.
MANY_TRIANGLES, MANY_OF_A_STRAND, MOST_TRIANGLES = 1 << 21, 48, 1 << 24


class Rings(NamedTuple):
    """Circles of all strands, from the first point of each to its last."""

    strand: np.ndarray
    center: np.ndarray
    tangent: np.ndarray
    radius: np.ndarray
    # The normal in direction `d` from the center is `share d + slope tangent`.
    share: np.ndarray
    slope: np.ndarray
    # Segment of the strand, and the place in it from 0 to 1.
    segment: np.ndarray
    u: np.ndarray


class Tubes(NamedTuple):
    """Triangles, with the strand, the place along it and the place around it, from 0 to 1, of each vertex."""

    positions: np.ndarray
    normals: np.ndarray
    strand: np.ndarray
    segment: np.ndarray
    u: np.ndarray
    around: np.ndarray
    triangles: np.ndarray


class Quality(NamedTuple):
    """How fine the tubes are."""

    sides: int
    # Pieces of each strand between its rings.
    pieces: np.ndarray
    triangles: int
    is_coarse: bool


class Splines:
    """Splines through points with radii: four numbers each. `counts` are the numbers of points of the strands, two at least."""

    def __init__(self, points: np.ndarray, counts: np.ndarray) -> None:
        self.points, self.counts = points.astype(np.float64), counts
        self.firsts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        self.segment_counts = counts - 1
        self.first_segments = self.firsts - np.arange(len(counts))
        owners = np.repeat(np.arange(len(counts)), self.segment_counts)
        begin = np.arange(len(owners)) + owners
        first, last = self.firsts[owners], self.firsts[owners] + counts[owners] - 1
        p0, p1, p2, p3 = (
            self.points[at] for at in (np.maximum(begin - 1, first), begin, begin + 1, np.minimum(begin + 2, last))
        )
        self.owners = owners
        self._terms = p1, 0.5 * (p2 - p0), p0 - 2.5 * p1 + 2.0 * p2 - 0.5 * p3, 0.5 * (p3 - p0) + 1.5 * (p1 - p2)
        steps = np.linalg.norm(p2[:, :3] - p1[:, :3], axis=1)
        self.lengths = np.bincount(owners, steps, len(counts))
        self.radii = np.maximum.reduceat(self.points[:, 3], self.firsts)

    def at(self, segment: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Point, first and second derivative at places of segments."""
        a, b, c, d = (term[segment] for term in self._terms)
        u = u[:, None]
        return ((d * u + c) * u + b) * u + a, (3.0 * d * u + 2.0 * c) * u + b, 6.0 * d * u + 2.0 * c

    def needs(self) -> tuple[np.ndarray, np.ndarray]:
        """How far each segment is bent: by its second derivative across its direction, and by the angle that it turns."""
        bend, turn = np.zeros(len(self.owners)), np.zeros(len(self.owners))
        every = np.arange(len(self.owners))
        for u in (0.0, 0.5, 1.0):
            _, first, second = self.at(every, np.full(len(every), u))
            square = np.maximum(np.sum(first[:, :3] ** 2, axis=1), 1e-300)
            across = second - first * (np.sum(first[:, :3] * second[:, :3], axis=1) / square)[:, None]
            is_moving = square > (1e-9 * self.lengths[self.owners]) ** 2
            sideways = np.where(is_moving, np.linalg.norm(across[:, :3], axis=1), 0.0)
            bend = np.maximum(bend, sideways + np.where(is_moving, np.abs(across[:, 3]), 0.0))
            turn = np.maximum(turn, sideways / np.sqrt(square))
        return bend, turn

    def quality(self, *later: Splines) -> Quality:
        """The finest tubes that are not too many triangles, or the coarsest ones. They suit splines of as many points at later times, too."""
        most = _most_triangles(len(self.counts))
        for each in later:
            self.lengths, self.radii = np.maximum(self.lengths, each.lengths), np.maximum(self.radii, each.radii)
        bend, turn = (np.maximum.reduce(needs) for needs in zip(*(each.needs() for each in (self, *later))))
        levels = _levels(self.radii, self.lengths)
        for sides, coarseness in levels:
            sag = coarseness * np.maximum(SAG_OF_LENGTH * self.lengths, SAG_OF_RADIUS * self.radii)[self.owners]
            most_turn = np.minimum(MOST_TURN, np.sqrt(8.0 * sag / np.maximum(self.radii[self.owners], 1e-300)))
            self.density = np.maximum(np.sqrt(bend / (8.0 * np.maximum(sag, 1e-300))), turn / most_turn) + 1e-6
            pieces = np.maximum(np.ceil(np.bincount(self.owners, self.density, len(self.counts)) - 1e-3), 1.0).astype(np.int64)
            triangles = int(2 * sides * pieces.sum())
            if triangles <= (most if sides > SIDES[-1] else MOST_TRIANGLES):
                break
        return Quality(sides, pieces, triangles, sides != levels[0][0])

    def rings(self, quality: Quality) -> Rings:
        """Rings at equal shares of the density of each strand."""
        counts = quality.pieces + 1
        strand = np.repeat(np.arange(len(counts)), counts)
        place = _indices(counts) / quality.pieces[strand]
        up_to = np.concatenate([[0.0], np.cumsum(self.density)])
        low, high = up_to[self.first_segments[strand]], up_to[self.first_segments[strand] + self.segment_counts[strand]]
        wanted = low + place * (high - low)
        last = self.first_segments[strand] + self.segment_counts[strand] - 1
        segment = np.clip(np.searchsorted(up_to, wanted, "right") - 1, self.first_segments[strand], last)
        u = np.where(place < 1.0, np.clip((wanted - up_to[segment]) / self.density[segment], 0.0, 1.0), 1.0)
        return self._rings(strand, segment, u)

    def rings_like(self, others: Rings) -> Rings:
        """Rings at the places of those of splines with as many points."""
        return self._rings(others.strand, others.segment + self.first_segments[others.strand], others.u)

    def _rings(self, strand: np.ndarray, segment: np.ndarray, u: np.ndarray) -> Rings:
        point, first, _ = self.at(segment, u)
        # Where a strand stops, its direction is that close by.
        is_still = np.linalg.norm(first[:, :3], axis=1) <= 1e-6 * self.lengths[strand]
        _, beside, _ = self.at(segment, np.where(u < 0.5, u + 1e-3, u - 1e-3))
        direction = np.where(is_still[:, None], beside, first)[:, :3]
        # A tip is off 0 by rounding.
        radius = np.where(point[:, 3] > 1e-9 * self.radii[strand], point[:, 3], 0.0)
        # As in Cycles, normals are those of a tube of one radius.
        share, slope = np.ones(len(strand)), np.zeros(len(strand))
        return Rings(strand, point[:, :3], _unit(direction), radius, share, slope, segment - self.first_segments[strand], u)


class Polylines:
    """Hulls of spheres at points with radii: four numbers each. No two points of a strand that follow each other are in one place."""

    def __init__(self, points: np.ndarray, counts: np.ndarray) -> None:
        self.points, self.counts = points.astype(np.float64), counts
        self.firsts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        strand = np.repeat(np.arange(len(counts)), counts)
        is_last = np.zeros(len(points), bool)
        is_last[self.firsts + counts - 1] = True
        step = np.diff(self.points, axis=0, append=self.points[-1:])
        length = np.where(is_last, 1.0, np.maximum(np.linalg.norm(step[:, :3], axis=1), 1e-300))
        # Cones touch the spheres where their normals rise by this angle; a sphere that holds the next one ends in a point.
        rise = np.arcsin(np.clip(-step[:, 3] / length, -1.0, 1.0))
        before = np.concatenate([[0], np.arange(len(points) - 1)])
        is_first = np.zeros(len(points), bool)
        is_first[self.firsts] = True
        self._after = _unit(np.where(is_last[:, None], step[before, :3], step[:, :3])), np.where(is_last, 0.5 * math.pi, rise)
        self._before = _unit(np.where(is_first[:, None], step[:, :3], step[before, :3])), np.where(is_first, -0.5 * math.pi, rise[before])
        self.strand = strand
        self.lengths = np.bincount(strand, np.where(is_last, 0.0, length), len(counts))
        self.radii = np.maximum.reduceat(self.points[:, 3], self.firsts)
        turn = np.arccos(np.clip(np.sum(self._before[0] * self._after[0], axis=1), -1.0, 1.0))
        self._largest = np.where(self.points[:, 3] > 0.0, np.maximum(turn, np.abs(self._after[1] - self._before[1])), 0.0)

    def quality(self) -> Quality:
        """The finest tubes that are not too many triangles, or the coarsest ones."""
        most = _most_triangles(len(self.counts))
        levels = _levels(self.radii, self.lengths)
        for sides, _ in levels:
            turn = min(2.0 * math.pi / sides, MOST_TURN)
            # At the least, a joint ends the cone before it and begins the one after it.
            self._steps = np.where(self._largest > 1e-6, np.ceil(self._largest / turn), 0.0).astype(np.int64)
            pieces = np.bincount(self.strand, self._steps + 1, len(self.counts)).astype(np.int64) - 1
            triangles = int(2 * sides * pieces.sum())
            if triangles <= most:
                break
        return Quality(sides, pieces, triangles, sides != levels[0][0])

    def rings(self, quality: Quality) -> Rings:
        """Rings on the spheres, between the cones."""
        counts = self._steps + 1
        at = np.repeat(np.arange(len(counts)), counts)
        share = _indices(counts) / np.maximum(self._steps, 1)[at]
        tangent = _between(self._before[0][at], self._after[0][at], share)
        angle = self._before[1][at] + share * (self._after[1] - self._before[1])[at]
        sine, cosine = np.sin(angle), np.maximum(np.cos(angle), 0.0)
        cosine[cosine < 1e-9] = 0.0
        radius = self.points[at, 3]
        strand = self.strand[at]
        # The last point ends the last segment.
        own = at - self.firsts[strand]
        is_end = own == self.counts[strand] - 1
        center = self.points[at, :3] + (sine * radius)[:, None] * tangent
        return Rings(strand, center, tangent, cosine * radius, cosine, sine, own - is_end, is_end.astype(np.float64))


def parts(rings: Rings) -> Iterator[Rings]:
    """Rings of some strands at a time."""
    count = len(rings.strand)
    first = 0
    while first < count:
        last = min(first + RINGS_AT_ONCE, count) - 1
        # To the end of a strand.
        end = int(np.searchsorted(rings.strand, rings.strand[last], "right"))
        yield Rings(*(each[first:end] for each in rings))
        first = end


def _levels(radii: np.ndarray, lengths: np.ndarray) -> list[tuple[int, float]]:
    """Numbers of sides, and by how much more than with the first one straight lines may be off. Of the fewest sides there are several."""
    is_thin = bool((radii < THIN * lengths).all())
    sides = SIDES[SIDES.index(SIDES_OF_THIN) if is_thin else 0 :]
    # Distances grow as those of the sides do.
    levels = [(number, (sides[0] / number) ** 2) for number in sides]
    return levels + [(levels[-1][0], levels[-1][1] * 4.0**more) for more in range(1, 5)]


def _most_triangles(strands: int) -> int:
    return min(max(MANY_TRIANGLES, MANY_OF_A_STRAND * strands), MOST_TRIANGLES)


def mesh(rings: Rings, first: np.ndarray, sides: int, has_seam: bool, is_point: Optional[np.ndarray] = None) -> Tubes:
    """Triangles around rings that begin in the directions `first`, across the strand. With a seam, the last column of vertices repeats the
    first, so that the place around ends at 1. `is_point` tells which rings are points at all times."""
    second = np.cross(rings.tangent, first)
    columns = sides + 1 if has_seam else sides
    count = len(rings.strand)
    is_point = rings.radius <= 0.0 if is_point is None else is_point
    step = 2.0 * math.pi / sides
    # A point has normals of the middles of the sides that meet there.
    angle = step * np.array([np.arange(columns), np.arange(columns) + 0.5])
    cosine, sine = (each[is_point.astype(np.intp)][..., None] for each in (np.cos(angle), np.sin(angle)))
    outward = cosine * first[:, None, :] + sine * second[:, None, :]
    positions = rings.center[:, None, :] + (_corner(sides) * rings.radius)[:, None, None] * outward
    normals = rings.share[:, None, None] * outward + (rings.slope[:, None] * rings.tangent)[:, None, :]
    return Tubes(
        positions.reshape(-1, 3),
        _unit(normals.reshape(-1, 3)),
        np.repeat(rings.strand, columns),
        np.repeat(rings.segment, columns),
        np.repeat(rings.u, columns),
        np.tile(np.arange(columns) / sides, count),
        _triangles(rings.strand, is_point, sides, columns),
    )


def _triangles(strand: np.ndarray, is_point: np.ndarray, sides: int, columns: int) -> np.ndarray:
    """Triangles between rings that follow each other on a strand. Diagonals alternate, so that shading leans to no side."""
    below = np.flatnonzero(strand[1:] == strand[:-1])
    column = np.arange(sides)
    following = (column + 1) % columns
    a, b = ((below * columns)[:, None] + each for each in (column, following))
    c, d = a + columns, b + columns
    is_odd = (column % 2 == 1)[None, :] | is_point[below + 1][:, None]
    is_odd = is_odd & ~is_point[below][:, None]
    lower = np.stack([a, b, np.where(is_odd, c, d)], axis=2)[~is_point[below]]
    upper = np.stack([np.where(is_odd, b, a), d, c], axis=2)[~is_point[below + 1]]
    return np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3)]).astype(np.int32)


def _corner(sides: int) -> float:
    """Distance from the center to the corners of a ring, in radii, with which the mean distance over all directions is the radius."""
    half = math.pi / sides
    return half / (math.cos(half) * math.log(math.tan(half) + 1.0 / math.cos(half)))


def frames_like(first: np.ndarray, rings: Rings) -> np.ndarray:
    """Directions across other tubes that are close to given ones, so that tubes which move do not twist."""
    across = first - np.sum(first * rings.tangent, axis=1, keepdims=True) * rings.tangent
    length = np.linalg.norm(across, axis=1, keepdims=True)
    return np.where(length > 1e-3, across / np.maximum(length, 1e-300), _any_across(rings.tangent))


def frames(rings: Rings) -> np.ndarray:
    """Directions across the tubes, which turn along a strand as little as possible."""
    strand, tangent = rings.strand, rings.tangent
    is_first = np.ones(len(strand), bool)
    is_first[1:] = strand[1:] != strand[:-1]
    before = np.concatenate([tangent[:1], tangent[:-1]])
    # Least rotation from the tangent before to this one, as a quaternion: the number first.
    half = before + tangent
    half = np.where(np.linalg.norm(half, axis=1, keepdims=True) > 1e-6, half, _any_across(tangent))
    half = _unit(half)
    turn = np.concatenate([np.sum(before * half, axis=1)[:, None], np.cross(before, half)], axis=1)
    turn[is_first] = (1.0, 0.0, 0.0, 0.0)
    own = _indices(np.bincount(strand - strand[0]))
    # All rotations since the strand's beginning: in each round, those of twice as many rings.
    reach = 1
    while reach <= own.max():
        at = np.flatnonzero(own >= reach)
        turn[at] = _product(turn[at], turn[at - reach])
        reach *= 2
    start = _any_across(tangent[is_first])[np.cumsum(is_first) - 1]
    turned = _rotated(turn, start)
    turned -= np.sum(turned * tangent, axis=1, keepdims=True) * tangent
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.where(length > 1e-6, turned / np.maximum(length, 1e-300), _any_across(tangent))


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products of quaternions, of length 1."""
    number = a[:, 0] * b[:, 0] - np.sum(a[:, 1:] * b[:, 1:], axis=1)
    vector = a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])
    return _unit(np.concatenate([number[:, None], vector], axis=1))


def _rotated(turn: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    twice = 2.0 * np.cross(turn[:, 1:], vectors)
    return vectors + turn[:, :1] * twice + np.cross(turn[:, 1:], twice)


def _between(a: np.ndarray, b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Directions on the shortest way from `a` to `b`."""
    cosine = np.clip(np.sum(a * b, axis=1), -1.0, 1.0)
    sideways = b - cosine[:, None] * a
    length = np.linalg.norm(sideways, axis=1, keepdims=True)
    sideways = np.where(length > 1e-9, sideways / np.maximum(length, 1e-300), _any_across(a))
    angle = (share * np.arccos(cosine))[:, None]
    return _unit(np.cos(angle) * a + np.sin(angle) * sideways)


def _any_across(vectors: np.ndarray) -> np.ndarray:
    """A direction across each direction."""
    axis = np.zeros_like(vectors)
    axis[np.arange(len(vectors)), np.argmin(np.abs(vectors), axis=1)] = 1.0
    return _unit(np.cross(vectors, axis))


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)


def _indices(counts: np.ndarray) -> np.ndarray:
    """For each item of groups of these sizes its index in its group."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - counts, counts)
