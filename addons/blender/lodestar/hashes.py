"""Hashes by which Cycles shifts noises and numbers objects."""

from __future__ import annotations

import struct
from typing import Any


def lookup3(*words: Any) -> Any:
    """Hash of one to three words (Jenkins 2006). A word may be an array of many, of 64 bits."""
    mask = 0xFFFFFFFF
    rotated = lambda x, by: ((x << by) | (x >> (32 - by))) & mask  # noqa: E731
    a = b = c = (0xDEADBEEF + (len(words) << 2) + 13) & mask
    a, b, c = ((value + (words[at] if at < len(words) else 0)) & mask for at, value in enumerate((a, b, c)))
    c = ((c ^ b) - rotated(b, 14)) & mask
    a = ((a ^ c) - rotated(c, 11)) & mask
    b = ((b ^ a) - rotated(a, 25)) & mask
    c = ((c ^ b) - rotated(b, 16)) & mask
    a = ((a ^ c) - rotated(c, 4)) & mask
    b = ((b ^ a) - rotated(a, 14)) & mask
    return ((c ^ b) - rotated(b, 24)) & mask


def hash_of_floats(*values: float) -> float:
    """Number in [0, 1] of one to three numbers in single precision."""
    words = (struct.unpack("<I", struct.pack("<f", value))[0] for value in values)
    return lookup3(*words) / 4294967295.0


def number_of_object(name: str) -> int:
    """Word by which Cycles tells an object from others that are no instances."""
    word = 0
    for byte in name.encode():
        word = (37 * word + byte) & 0xFFFFFFFF
    return lookup3(word, 0)
