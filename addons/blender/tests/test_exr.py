"""The reader of EXR files: damaged and crafted files raise ValueError, in little memory. It needs numpy, not Blender."""

import importlib.util
import pathlib
import random
import resource
import struct
import zlib

import numpy as np
import pytest

SOURCE = pathlib.Path(__file__).parents[1] / "lodestar" / "exr.py"
spec = importlib.util.spec_from_file_location("exr", SOURCE)
exr = importlib.util.module_from_spec(spec)
spec.loader.exec_module(exr)


def compressed(content, lines):
    """A chunk as ZIP has it."""
    data = np.frombuffer(content, np.uint8)
    data = np.concatenate([data[0::2], data[1::2]]).astype(np.int64)
    data[1:] = data[1:] - data[:-1] + 128
    chunk = zlib.compress(data.astype(np.uint8).tobytes())
    return chunk if len(chunk) < len(content) else content


def picture(width=6, height=5, kind=3, size=None, chunk=None, offset=None, y=0):
    """Bytes of a file; `size`, `chunk`, `offset` and `y` say something else than is true."""
    window = struct.pack("<4i", 0, 0, *(side - 1 for side in (size or (width, height))))
    header = exr.MAGIC + struct.pack("<I", 2)
    header += exr._attribute("channels", "chlist", b"Y\0" + struct.pack("<iBxxxii", 2, 0, 1, 1) + b"\0")
    header += exr._attribute("compression", "compression", bytes([kind]))
    header += exr._attribute("dataWindow", "box2i", window) + exr._attribute("displayWindow", "box2i", window) + b"\0"
    content = np.arange(width * height, dtype="<f4").tobytes()
    chunk = compressed(content, height) if chunk is None else chunk
    place = len(header) + 8 if offset is None else offset
    return header + struct.pack("<Q", place) + struct.pack("<2i", y, len(chunk)) + chunk


@pytest.fixture
def refused(tmp_path):
    """Reads bytes, which must raise ValueError within half a gigabyte."""
    limits = resource.getrlimit(resource.RLIMIT_AS)
    used = int(pathlib.Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + (1 << 29), limits[1]))

    def check(data, may_read=False):
        path = tmp_path / "a.exr"
        path.write_bytes(data)
        try:
            exr.read(path)
        except ValueError as error:
            assert str(path) in str(error)
            return str(error)
        assert may_read, "it was read"
        return ""

    yield check
    resource.setrlimit(resource.RLIMIT_AS, limits)


def test_a_whole_file_is_read(tmp_path):
    path = tmp_path / "a.exr"
    path.write_bytes(picture())
    assert (exr.read(path).channels["Y"] == np.arange(30).reshape(5, 6)).all()


def test_files_that_lie_are_refused(refused):
    refused(exr.MAGIC)
    refused(exr.MAGIC + b"\2")
    assert "do not fit" in refused(picture(size=(1 << 30, 1 << 30)))
    assert "do not fit" in refused(picture(size=(1 << 20, 5)))
    assert "do not fit" in refused(picture(size=(-5, 5)))
    assert "outside" in refused(picture(offset=2**64 - 1))
    assert "no place" in refused(picture(y=-3))
    assert "no place" in refused(picture(y=5))
    # A gigabyte of zeros in a megabyte.
    assert "in place of 120" in refused(picture(chunk=zlib.compress(bytes(1 << 28))))
    negative = picture().replace(struct.pack("<i", 1) + bytes([3]), struct.pack("<i", -64) + bytes([3]))
    assert "negative" in refused(negative)


def test_damaged_files_are_refused_or_read(refused):
    whole, draw = picture(), random.Random(5)
    for length in range(len(whole)):
        refused(whole[:length])
    for _ in range(3000):
        data = bytearray(whole)
        for _ in range(draw.randint(1, 4)):
            data[draw.randrange(len(data))] = draw.choice([0, 1, 127, 128, 255, draw.randrange(256)])
        if data[:4] == exr.MAGIC:
            refused(bytes(data), may_read=True)
