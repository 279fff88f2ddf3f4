"""EXR files: a reader of scanline files such as Lodestar and Blender write, and a writer of colors without compression.

Blender's own reader knows only the channel names that Blender writes. Lodestar's layers have other names.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import NamedTuple

import numpy as np

MAGIC = b"\x76\x2f\x31\x01"
TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
# Lines per chunk of the compressions that are read: none, ZIPS, ZIP.
LINES = {0: 1, 2: 1, 3: 16}
# ZIP makes at most this many bytes of one.
MOST_RATIO = 1032


class Picture(NamedTuple):
    """Channels by name, each an array of rows from the top, and the place of the data within the display."""

    channels: dict[str, np.ndarray]
    offset: tuple[int, int]
    size: tuple[int, int]

    def layer(self, names: list[str]) -> np.ndarray | None:
        """Channels side by side, or None where one is missing."""
        if any(name not in self.channels for name in names):
            return None
        return np.stack([self.channels[name].astype(np.float32) for name in names], axis=-1)


def _name(data: bytes, at: int) -> tuple[str, int]:
    end = data.index(0, at)
    return data[at:end].decode(), end + 1


def _header(data: bytes) -> tuple[dict[str, bytes], int]:
    attributes, at = {}, 8
    while data[at] != 0:
        name, at = _name(data, at)
        _, at = _name(data, at)
        size = struct.unpack_from("<i", data, at)[0]
        if size < 0:
            raise ValueError(f"the attribute {name} has a negative size")
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _channels(text: bytes) -> list[tuple[str, np.dtype]]:
    channels, at = [], 0
    while text[at] != 0:
        name, at = _name(text, at)
        channels.append((name, TYPES[struct.unpack_from("<i", text, at)[0]]))
        at += 16
    return channels


def _unpack(chunk: bytes, size: int) -> bytes:
    """Content of a ZIP chunk: halves interleaved, differences summed."""
    if len(chunk) == size:
        return chunk
    # One byte more than the header says is enough to see that the chunk is another one.
    unpacking = zlib.decompressobj()
    content = unpacking.decompress(chunk, size + 1)
    if len(content) != size or not unpacking.eof:
        raise ValueError(f"a chunk has {len(content)} bytes or more in place of {size}, or its end is missing")
    data = np.frombuffer(content, np.uint8).copy()
    data[1:] -= 128
    np.cumsum(data, dtype=np.uint8, out=data)
    half = (len(data) + 1) // 2
    result = np.empty_like(data)
    result[0::2], result[1::2] = data[:half], data[half:]
    return result.tobytes()


def read(path: Path) -> Picture:
    """Reads the picture at `path`. A ValueError says what is wrong with the file."""
    data = Path(path).read_bytes()
    if data[:4] != MAGIC:
        raise ValueError(f"{path} is not an EXR file")
    try:
        has_lines = not struct.unpack_from("<I", data, 4)[0] & 0x1A00
        if has_lines:
            return _read_lines(data)
    except (IndexError, KeyError, ValueError, struct.error, zlib.error) as fault:
        raise ValueError(f"{path} is cut short, or is compressed otherwise than by ZIP ({fault!r})") from fault
    raise ValueError(f"{path} has tiles, depth or several parts; only scanline files are read")


def _read_lines(data: bytes) -> Picture:
    attributes, at = _header(data)
    channels = _channels(attributes["channels"])
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    display = struct.unpack("<4i", attributes["displayWindow"])
    width, height = right - left + 1, bottom - top + 1
    lines, compression = LINES[attributes["compression"][0]], attributes["compression"][0]
    bytes_per_line = sum(dtype.itemsize for _, dtype in channels) * width
    # A header may announce any size, but the file must hold it.
    if width < 1 or height < 1 or bytes_per_line * height > MOST_RATIO * len(data) or height > len(data):
        raise ValueError(f"{width} x {height} pixels do not fit the file")
    arrays = {name: np.empty((height, width), dtype) for name, dtype in channels}
    for offset in struct.unpack_from(f"<{-(-height // lines)}Q", data, at):
        if offset > len(data):
            raise ValueError("a chunk is outside of the file")
        y, size = struct.unpack_from("<2i", data, offset)
        if not top <= y <= bottom or not 0 <= size <= len(data) - offset - 8:
            raise ValueError("a chunk has no place in the picture or in the file")
        count = min(lines, bottom - y + 1)
        chunk = data[offset + 8 : offset + 8 + size]
        content = _unpack(chunk, bytes_per_line * count) if compression else chunk
        place = 0
        for row in range(y - top, y - top + count):
            for name, dtype in channels:
                arrays[name][row] = np.frombuffer(content, dtype, width, place)
                place += dtype.itemsize * width
    return Picture(arrays, (left - display[0], top - display[1]), (width, height))


def _attribute(name: str, kind: str, value: bytes) -> bytes:
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def write(path: Path, colors: np.ndarray) -> None:
    """Writes linear colors, rows from the top, as 32-bit floats without compression."""
    height, width = colors.shape[:2]
    channel = lambda name: name + b"\0" + struct.pack("<iBxxxii", 2, 0, 1, 1)  # noqa: E731
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = MAGIC + struct.pack("<I", 2)
    header += _attribute("channels", "chlist", b"".join(map(channel, (b"B", b"G", b"R"))) + b"\0")
    header += _attribute("compression", "compression", b"\0")
    header += _attribute("dataWindow", "box2i", window) + _attribute("displayWindow", "box2i", window)
    header += _attribute("lineOrder", "lineOrder", b"\0")
    header += _attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0))
    header += _attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0))
    header += _attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)) + b"\0"
    line = 8 + 12 * width
    begin = len(header) + 8 * height
    offsets = struct.pack(f"<{height}Q", *(begin + y * line for y in range(height)))
    planes = np.ascontiguousarray(colors[:, :, 2::-1].transpose(0, 2, 1), "<f4")
    rows = (struct.pack("<2i", y, 12 * width) + planes[y].tobytes() for y in range(height))
    Path(path).write_bytes(header + offsets + b"".join(rows))
