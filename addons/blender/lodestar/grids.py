"""Grids of Volume objects: the values of a .vdb file as dense grids, and these as files of the scene."""

from __future__ import annotations

import hashlib
import struct
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Optional

import numpy as np

from . import xml
from .nodes import Reader
from .report import Report

# Most numbers of a grid of the renderer.
MOST_NUMBERS = 2**25
# Names of grids that the node Volume Info gives.
OF_VOLUME_INFO = {"Density": "density", "Flame": "flame", "Temperature": "temperature"}


class Grid:
    """Dense grid over a box. `to_world` maps the unit cube to the box. Equal grids are one object."""

    def __init__(self, values: np.ndarray, to_world: Any, write: Callable[[np.ndarray], str]) -> None:
        self.values, self.to_world, self.write = values, to_world, write

    def of(self, values: np.ndarray) -> Grid:
        """Grid of other values in the same place."""
        return Grid(values.astype(np.float32), self.to_world, self.write)

    def ones(self) -> Grid:
        """Grid of the same box that is 1 everywhere."""
        return self.of(np.ones_like(self.values))

    def mapped(self, function: Callable[[float], tuple[float, float, float]]) -> Grid:
        """Grid of colors, each a function of a value."""
        steps = np.linspace(0.0, max(float(self.values.max()), 1e-9), 1024)
        table = np.array([function(float(value)) for value in steps])
        colors = [np.interp(self.values, steps, table[:, channel]) for channel in range(3)]
        return self.of(np.stack(colors, axis=-1))

    def element(self) -> xml.Element:
        """`gridvolume` of the grid."""
        volume = xml.add(xml.plugin("volume", "gridvolume"), "filename", self.write(self.values))
        return xml.add_matrix(volume, self.to_world)


class Grids:
    """Grids of one Volume object in one place."""

    def __init__(self, owner: Any, matrix: Any, folder: Path, used: set[str], report: Report) -> None:
        self.folder, self.used, self.matrix = folder, used, matrix
        self.place, self.report = f'object "{owner.name}"', report
        self.found: dict[str, Grid] = {}
        self.clipping = float(owner.data.render.clipping)
        self._read(owner.data)

    @property
    def box(self) -> Optional[Any]:
        """Matrix from the unit cube to the box that holds the grids; None where there is nothing."""
        return next((grid.to_world for grid in self.found.values()), None)

    def named(self, name: str) -> Optional[Grid]:
        """Grid of a name, if there is one."""
        return self.found.get(name)

    def linked(self, reader: Reader, socket: Any, groups: tuple[Any, ...]) -> Optional[tuple[float, Optional[Grid]]]:
        """A factor and a grid that a socket is linked to; None where it is linked to something else."""
        source = reader.source(socket, groups)
        if source is None or source.node is None:
            return None
        node, name = source.node, None
        if node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY" and source.socket.name in ("Fac", "Factor", "Color"):
            name = node.attribute_name
        elif node.type == "VOLUME_INFO":
            name = OF_VOLUME_INFO.get(source.socket.name)
        elif node.type == "MATH" and node.operation == "MULTIPLY":
            for at in (0, 1):
                inner = self.linked(reader, node.inputs[at], source.groups)
                if inner is not None:
                    return inner[0] * reader.constant(node.inputs[1 - at], source.groups), inner[1]
        if name is None:
            return None
        grid = self.named(name)
        return (0.0, None) if grid is None else (1.0, grid)

    # ---------------------------------------------------------------------------------------------------- files

    def _read(self, data: Any) -> None:
        module = openvdb()
        if module is None:
            self.report.warn(self.place, "volumes need Blender's module openvdb, which this Blender does not have; it is left out")
            return
        data.grids.load()
        path = data.grids.frame_filepath
        if data.grids.error_message or not path:
            self.report.warn(self.place, f"its file cannot be read ({data.grids.error_message or 'it has none'}); it is left out")
            return
        scalars = [grid.name for grid in data.grids if grid.data_type in ("FLOAT", "DOUBLE", "INT", "MASK", "BOOLEAN")]
        grids = {name: module.read(path, name) for name in scalars}
        grids = {name: grid for name, grid in grids.items() if not grid.empty() and grid.activeVoxelCount() > 0}
        if not grids:
            return
        first = next(iter(grids.values()))
        same = {name: grid for name, grid in grids.items() if _rows(grid.transform) == _rows(first.transform)}
        for name in grids.keys() - same.keys():
            self.report.warn(self.place, f'its grid "{name}" has other voxels than the first one, which is not supported; it is left out')
        boxes = np.array([grid.evalActiveVoxelBoundingBox() for grid in same.values()])
        # A border of empty voxels: beyond the active voxels, values fall to the background within one voxel.
        low, high = boxes[:, 0].min(axis=0) - 1, boxes[:, 1].max(axis=0) + 1
        size = high - low + 1
        if np.prod(size.astype(np.float64)) > 16 * MOST_NUMBERS:
            self.report.warn(self.place, f"its {size[0]} x {size[1]} x {size[2]} voxels are too many; it is left out")
            return
        for name, grid in same.items():
            self.found[name] = self._dense(name, grid, low, size)

    def _dense(self, name: str, grid: Any, low: np.ndarray, size: np.ndarray) -> Grid:
        from mathutils import Matrix

        values = np.zeros(tuple(size), np.float32)
        grid.copyToArray(values, ijk=tuple(int(v) for v in low))
        values = np.nan_to_num(values, nan=0.0, posinf=0.0)
        values[values < self.clipping] = 0.0
        scale = 1
        while values.size * 3 > MOST_NUMBERS:
            values, scale = _halved(values), 2 * scale
        if scale > 1:
            shape = " x ".join(map(str, values.shape))
            self.report.warn(self.place, f'its grid "{name}" has too many voxels; it is rendered with {shape}')
        to_index = Matrix.Translation([float(v) - 0.5 for v in low]) @ Matrix.Diagonal((*(float(scale * n) for n in values.shape), 1.0))
        # The file has x fastest.
        return Grid(np.ascontiguousarray(values.transpose(2, 1, 0)), self.matrix @ Matrix(_rows(grid.transform)) @ to_index, self._write)

    def _write(self, values: np.ndarray) -> str:
        """File of a grid, named by a hash of its content."""
        channels = values.shape[3] if values.ndim == 4 else 1
        depth, height, width = values.shape[:3]
        head = b"VOL\x03" + struct.pack("<5i6f", 1, width, height, depth, channels, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
        content = head + values.astype("<f4").tobytes()
        name = f"grid-{hashlib.blake2b(content, digest_size=12).hexdigest()}.vol"
        self.used.add(name)
        path = self.folder / name
        if not path.exists():
            whole = path.with_suffix(".part")
            whole.write_bytes(content)
            whole.replace(path)
        return name


def _halved(values: np.ndarray) -> np.ndarray:
    """Means of 2 x 2 x 2 voxels; what is missing at the border is empty."""
    padded = np.pad(values, [(0, n % 2) for n in values.shape])
    x, y, z = (n // 2 for n in padded.shape)
    return padded.reshape(x, 2, y, 2, z, 2).mean(axis=(1, 3, 5), dtype=np.float32)


def _rows(transform: Any) -> tuple[tuple[float, ...], ...]:
    """Matrix from the indices of voxels to the object."""
    origin = np.array(transform.indexToWorld((0, 0, 0)))
    columns = [np.array(transform.indexToWorld(axis)) - origin for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    rows = np.stack([*columns, origin], axis=1)
    return (*(tuple(map(float, row)) for row in rows), (0.0, 0.0, 0.0, 1.0))


def openvdb() -> Any:
    """Blender's module for .vdb files. The package `bpy` has it in a folder of its own."""
    import bpy

    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    folder = Path(bpy.utils.resource_path("LOCAL")) / "python" / "lib" / version / "site-packages"
    if folder.is_dir() and str(folder) not in sys.path:
        sys.path.append(str(folder))
    for name in ("openvdb", "pyopenvdb"):
        try:
            return __import__(name)
        except ImportError:
            continue
    return None
