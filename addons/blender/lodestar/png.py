"""Writer of PNG files of 8 bits (ISO/IEC 15948)."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np

# Color types by the number of channels.
TYPES = {3: 2, 4: 6}


def write(path: Path, texels: np.ndarray) -> None:
    """Writes texels of three or four bytes, rows from the top."""
    height, width, channels = texels.shape
    # Each row begins with its filter: none.
    rows = np.zeros((height, 1 + width * channels), np.uint8)
    rows[:, 1:] = texels.reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, TYPES[channels], 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 1)), (b"IEND", b""))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, data) for kind, data in chunks))


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
