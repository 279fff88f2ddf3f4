"""Mattes: Cryptomattes (Friedman and Jones 2015) of objects, of their topmost parents and of materials, as Cycles makes them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import NamedTuple, Optional

import numpy as np

from . import exr

# Things that Lodestar's files hold for each pixel.
RANKS = 6
MASK = 0xFFFFFFFF


def murmur3(data: bytes) -> int:
    """MurmurHash3 of 32 bits with the seed 0 (Appleby 2011)."""
    whole = len(data) // 4 * 4
    words = [int.from_bytes(data[at : at + 4], "little") for at in range(0, whole, 4)]
    found = 0
    for word in words:
        found = _rotated(found ^ _scrambled(word), 13) * 5 + 0xE6546B64 & MASK
    found ^= _scrambled(int.from_bytes(data[whole:], "little")) ^ len(data)
    found = (found ^ found >> 16) * 0x85EBCA6B & MASK
    found = (found ^ found >> 13) * 0xC2B2AE35 & MASK
    return found ^ found >> 16


def _rotated(word: int, by: int) -> int:
    return (word << by | word >> 32 - by) & MASK


def _scrambled(word: int) -> int:
    return _rotated(word * 0xCC9E2D51 & MASK, 15) * 0x1B873593 & MASK


@lru_cache(maxsize=1 << 18)
def identifier(name: str) -> int:
    """Bits of the number that stands for a name in a picture: its hash, changed where that would be no number or nearly 0."""
    found = murmur3(name.encode(errors="surrogateescape"))
    return found ^ 1 << 23 if (found >> 23 & 255) in (0, 255) else found


class Matte(NamedTuple):
    """Things that pixels show: bits of their identifiers, and their shares of the pixel, the largest first. Both have a row for each pixel."""

    ids: np.ndarray
    shares: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """Share of each pixel that shows anything."""
        return self.shares.sum(axis=1).clip(max=1.0)

    def renamed(self, names: dict[str, str]) -> Matte:
        """Matte of which each thing has another name. Those of one name are one, and those without a name are none."""
        table = {identifier(name): identifier(new) for name, new in names.items()}
        ids = self._looked_up(table, np.uint32)
        shares = np.where(ids != 0, self.shares, np.float32(0.0))
        if len(set(table.values())) < len(table):
            for later in range(1, ids.shape[1]):
                for first in range(later):
                    is_same = ids[:, first] == ids[:, later]
                    shares[:, first] += np.where(is_same, shares[:, later], np.float32(0.0))
                    shares[:, later][is_same] = 0.0
        ids[shares == 0.0] = 0
        order = np.argsort(-shares, axis=1, kind="stable")
        return Matte(np.take_along_axis(ids, order, axis=1), np.take_along_axis(shares, order, axis=1))

    def numbers(self, of_names: Mapping[str, float]) -> np.ndarray:
        """Numbers of the things by their names; 0 where there is none."""
        return self._looked_up({identifier(name): value for name, value in of_names.items()}, np.float32)

    def _looked_up(self, table: Mapping[int, float], kind: type) -> np.ndarray:
        """Values of a table for the identifiers; 0 where it has none."""
        known = np.array(sorted({0, *table}), np.uint32)
        values = np.array([table.get(int(each), 0) for each in known], kind)
        at = np.searchsorted(known, self.ids).clip(max=len(known) - 1)
        return np.where(known[at] == self.ids, values[at], kind(0))

    def indices(self, of_names: Mapping[str, float]) -> np.ndarray:
        """Number of what has the largest share of each pixel; 0 where that is nothing."""
        return np.where(self.shares[:, 0] >= 1.0 - self.total, self.numbers(of_names)[:, 0], np.float32(0.0))

    def layer(self, at: int) -> np.ndarray:
        """Two things of each pixel, as identifier, share, identifier, share."""
        pixels = np.zeros((len(self.ids), 4), np.float32)
        for column, rank in ((0, 2 * at), (2, 2 * at + 1)):
            if rank < self.ids.shape[1]:
                pixels[:, column], pixels[:, column + 1] = self.ids[:, rank].view(np.float32), self.shares[:, rank]
        return pixels


def read(picture: exr.Picture, layer: str) -> Optional[Matte]:
    """Matte of a file; None where it has none of that name."""
    found = [picture.layer([f"{layer}{at:02}.{letter}" for letter in "RGBA"]) for at in range(RANKS // 2)]
    if any(each is None for each in found):
        return None
    numbers = np.concatenate([each.reshape(-1, 4) for each in found if each is not None], axis=1)
    ids = np.ascontiguousarray(numbers[:, 0::2], np.float32).view(np.uint32)
    return Matte(np.where(numbers[:, 1::2] > 0.0, ids, np.uint32(0)), numbers[:, 1::2].copy())


def facts(layer: str, names: Iterable[str]) -> dict[str, str]:
    """What a picture says about the mattes of a layer, by the keys of its header."""
    key = f"cryptomatte/{murmur3(layer.encode(errors='surrogateescape')):08x}"[: len("cryptomatte/") + 7]
    manifest = {name: f"{identifier(name):08x}" for name in sorted(set(names))}
    return {
        f"{key}/name": layer,
        f"{key}/hash": "MurmurHash3_32",
        f"{key}/conversion": "uint32_to_float32",
        f"{key}/manifest": json.dumps(manifest, ensure_ascii=False, separators=(",", ":")),
    }
