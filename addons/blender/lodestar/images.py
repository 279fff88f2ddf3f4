"""Images: textures as Mitsuba's `bitmap`, and the files that they name.

An image file that Lodestar reads as Blender does is named where it is. Any other image (packed, generated, painted, one channel of
it, a function of it) is written to the export's folder, under a name made of its content.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Optional

import numpy as np

from . import exr, png, xml
from .programs import Expression, Graph, square_root
from .report import Report

Matrix3 = tuple[tuple[float, ...], ...]
IDENTITY: Matrix3 = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
READ_FORMATS = {"PNG", "JPEG", "BMP", "TARGA", "HDR"}
LINEAR_SPACES = {"Non-Color", "Linear Rec.709", "Linear", "Raw", "scene_linear"}
# Operations of which an image of encoded bytes stays one: Cycles mixes such texels, and decodes the mix.
OF_BYTES = {"color", "premultiplied", "r", "g", "b", "luminance"}
# Color that Cycles shows where an image cannot be loaded.
MISSING = (1.0, 0.0, 1.0)


@dataclass(frozen=True)
class Texture:
    """Texture of an image, or a program, or a mesh's colors."""

    image: Any = None
    # "color" or "alpha", then functions: "covered" (times alpha), "premultiplied" (times alpha
    # before the sRGB curve is undone), "r", "g", "b", "luminance", "invert", "square", "sqrt", "normal STRENGTH", "environment".
    operations: tuple[str, ...] = ("color",)
    to_uv: Matrix3 = IDENTITY
    wrap: str = "repeat"
    interpolation: str = "bilinear"
    attribute: Optional[str] = None
    program: Optional[Expression] = None
    factor: tuple[float, float, float] = (1.0, 1.0, 1.0)

    @staticmethod
    def of_vertices(name: str) -> "Texture":
        """Colors of a mesh's attribute."""
        return Texture(attribute=name)

    def with_operation(self, operation: str) -> "Texture":
        """Texture of which each texel is changed."""
        if self.program is not None:
            return replace(self, program=_changed(self.program * self.factor, operation), factor=(1.0, 1.0, 1.0))
        return replace(self, operations=(*self.operations, operation))

    def covered(self) -> "Texture":
        """Colors of an image times its alpha."""
        return replace(self, operations=(self.operations[0], "covered", *self.operations[1:]))

    def scaled(self, factor: tuple[float, float, float]) -> "Texture":
        """Texture times a color."""
        own = self.factor
        return replace(self, factor=(own[0] * factor[0], own[1] * factor[1], own[2] * factor[2]))


def _changed(value: Expression, operation: str) -> Expression:
    if operation == "square":
        return value * value
    if operation == "sqrt":
        return square_root(value)
    if operation == "invert":
        return 1.0 - value
    return value.component("rgb".index(operation))


class Images:
    """Image files and programs of one export."""

    def __init__(self, folder: Path, report: Report) -> None:
        self.folder = folder
        self.report = report
        self.used: set[str] = set()
        self.graph = Graph()
        # Names of the expressions that materials refer to.
        self.used_programs: set[str] = set()
        self._files: dict[tuple[str, tuple[str, ...], bool], str] = {}

    def element(self, texture: Texture) -> xml.Element:
        """`<texture>` of a texture, or `<ref>` to one."""
        if texture.program is not None:
            element = self.graph.reference(texture.program)
            self.used_programs.add(element.get("id", ""))
        elif texture.attribute is not None:
            element = xml.add(xml.plugin("texture", "mesh_attribute"), "name", "vertex_color")
        else:
            element = self._bitmap(texture)
        if texture.factor != (1.0, 1.0, 1.0):
            scale = xml.add(xml.plugin("texture", "scale"), "scale", texture.factor)
            element = xml.with_children(scale, element)
        return element

    def of_color(self, color: tuple[float, float, float], operation: str) -> xml.Element:
        """`<texture>` of an image of one color, after an operation."""
        path = self.written(apply(np.array([[[*color, 1.0]]], np.float32), (operation,)))
        return xml.add(xml.add(xml.plugin("texture", "bitmap"), "filename", path), "raw", True)

    def _bitmap(self, texture: Texture) -> xml.Element:
        if not has_alpha(texture.image):
            texture = replace(texture, operations=tuple(each for each in texture.operations if each != "covered"))
        is_mixed_first = texture.interpolation == "bilinear" and _is_encoded(texture)
        path, is_raw = self.file(texture.image, texture.operations, is_mixed_first)
        element = xml.add(xml.plugin("texture", "bitmap"), "filename", path)
        xml.add(element, "raw", is_raw)
        if is_mixed_first:
            xml.add(element, "decode_after_filter", True)
        if texture.wrap != "repeat":
            xml.add(element, "wrap_mode", texture.wrap)
        if texture.interpolation != "bilinear":
            xml.add(element, "filter_type", texture.interpolation)
        if texture.to_uv != IDENTITY:
            xml.add_matrix(element, _flipped(texture.to_uv), "to_uv")
        return element

    def file(self, image: Any, operations: tuple[str, ...], as_bytes: bool = False) -> tuple[str, bool]:
        """Path of a file with an image, and whether its numbers are linear. `as_bytes` keeps the bytes of an encoded image."""
        space = image.colorspace_settings.name
        path = os.path.abspath(_path(image))
        is_plain = image.source == "FILE" and image.packed_file is None and not image.is_dirty
        is_known = space == "sRGB" or space in LINEAR_SPACES
        if operations == ("color",) and is_plain and is_known and not has_alpha(image) and image.file_format in READ_FORMATS:
            if os.path.isfile(path) and not (image.is_float and space == "sRGB"):
                return path, space in LINEAR_SPACES or image.is_float
        key = (image.name_full, operations, as_bytes)
        if key not in self._files:
            if as_bytes:
                self._files[key] = self.written(texels(image, operations))
            else:
                self._files[key] = self.written(apply(pixels(image, self.report), operations))
        return self._files[key], not as_bytes

    def written(self, colors: np.ndarray) -> str:
        """Name of a file with linear colors, or with encoded bytes, rows from the top."""
        digest = hashlib.blake2b(np.ascontiguousarray(colors).tobytes(), digest_size=12).hexdigest()
        kind, write = ("png", png.write) if colors.dtype == np.uint8 else ("exr", exr.write)
        name = f"image-{digest}-{colors.shape[1]}x{colors.shape[0]}.{kind}"
        self.used.add(name)
        if not (self.folder / name).exists():
            write(self.folder / name, colors)
        return name


def has_alpha(image: Any) -> bool:
    """Whether an image has a channel of alpha."""
    return image.channels == 4 and image.depth in (32, 64, 128)


def _is_encoded(texture: Texture) -> bool:
    """Whether the texture is an image of bytes in sRGB, of which no linear numbers have to be made."""
    image = texture.image
    return image.colorspace_settings.name == "sRGB" and not image.is_float and OF_BYTES.issuperset(texture.operations)


def texels(image: Any, operations: tuple[str, ...]) -> np.ndarray:
    """Encoded bytes of an image after operations, with alpha where Cycles mixes colors by it, rows from the top."""
    data = np.rint(np.clip(_stored(image), 0.0, 1.0) * np.float32(255.0)).astype(np.uint8)
    colors, alpha = data[:, :, :3], data[:, :, 3:4]
    # Cycles keeps colors times alpha in bytes, and divides the mix of colors by that of alpha where Alpha is linked.
    is_premultiplied = "premultiplied" in operations
    is_divided = not is_premultiplied and image.alpha_mode in ("STRAIGHT", "PREMUL") and bool((alpha < 255).any())
    if is_premultiplied or is_divided:
        colors = (colors.astype(np.uint16) * alpha // 255).astype(np.uint8)
    if is_divided:
        colors = np.rint(colors * np.float32(255.0) / np.maximum(alpha, 1)).astype(np.uint8)
    for operation in operations:
        if operation in ("r", "g", "b"):
            colors = np.repeat(colors[:, :, "rgb".index(operation)][:, :, None], 3, axis=2)
        elif operation == "luminance":
            linear = apply(linear_from_srgb(colors / np.float32(255.0)), ("luminance",))
            colors = np.rint(srgb_from_linear(linear) * 255.0).astype(np.uint8)
    return np.concatenate([colors, alpha], axis=2) if is_divided else colors


def _stored(image: Any) -> np.ndarray:
    """Colors and alpha of an image as Blender keeps them, rows from the top."""
    width, height = image.size
    data = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(data)
    data = data.reshape(height, width, image.channels)[::-1]
    if image.channels < 3:
        gray = data[:, :, :1]
        alpha = data[:, :, 1:2] if image.channels == 2 else np.ones_like(gray)
        data = np.concatenate([gray, gray, gray, alpha], axis=2)
    elif image.channels == 3:
        data = np.concatenate([data, np.ones_like(data[:, :, :1])], axis=2)
    return data


def pixels(image: Any, report: Report) -> np.ndarray:
    """Linear colors and alpha of an image, rows from the top."""
    data, height = _stored(image), image.size[1]
    space = image.colorspace_settings.name
    if space == "sRGB" and not image.is_float:
        data = data.copy()
        # Such an image has bytes, and so 256 values.
        table = linear_from_srgb(np.arange(256, dtype=np.float32) / np.float32(255.0)).astype(np.float32)
        for rows in np.array_split(data, max(height // 256, 1)):
            rows[:, :, :3] = table[np.rint(np.clip(rows[:, :, :3], 0.0, 1.0) * np.float32(255.0)).astype(np.uint8)]
    elif space != "sRGB" and space not in LINEAR_SPACES:
        report.warn(f'image "{image.name}"', f"the color space {space} is not supported; the colors are taken as linear")
    return data


def linear_from_srgb(encoded: np.ndarray) -> np.ndarray:
    """Linear values of numbers that the sRGB curve encodes."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((np.maximum(encoded, 0.0) + 0.055) / 1.055) ** 2.4)


def srgb_from_linear(linear: np.ndarray) -> np.ndarray:
    """Numbers as the sRGB curve encodes them."""
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * np.maximum(linear, 0.0) ** (1.0 / 2.4) - 0.055)


def apply(data: np.ndarray, operations: tuple[str, ...]) -> np.ndarray:
    """Colors after a texture's operations."""
    colors = data[:, :, :3]
    for operation in operations:
        if operation == "alpha":
            colors = np.repeat(data[:, :, 3:4], 3, axis=2)
        elif operation == "premultiplied":
            colors = linear_from_srgb(srgb_from_linear(colors) * data[:, :, 3:4])
        elif operation == "covered":
            colors = colors * data[:, :, 3:4]
        elif operation in ("r", "g", "b"):
            at = "rgb".index(operation)
            colors = np.repeat(colors[:, :, at : at + 1], 3, axis=2)
        elif operation == "luminance":
            colors = np.repeat(colors @ np.array([[0.2126], [0.7152], [0.0722]], np.float32), 3, axis=2)
        elif operation == "invert":
            colors = 1.0 - colors
        elif operation == "square":
            colors = colors * colors
        elif operation == "sqrt":
            colors = np.sqrt(np.maximum(colors, 0.0))
        elif operation == "environment":
            colors = _with_poles(colors)
        elif operation.startswith("normal "):
            strength = float(operation.split()[1])
            colors = _weakened(colors, strength)
    return colors.astype(np.float32)


def _with_poles(colors: np.ndarray) -> np.ndarray:
    """Image whose first and last rows are the poles, as Mitsuba's environments have it, with the same linear interpolation.

    Blender's rows lie half a row away from the poles. Rows at half the distance hold all of them, and the means between them.
    """
    height, width = colors.shape[:2]
    result = np.empty((2 * height + 1, width, 3), np.float32)
    result[1::2] = colors
    result[2:-1:2] = 0.5 * (colors[1:] + colors[:-1])
    result[0], result[-1] = colors[0], colors[-1]
    return result


def _weakened(colors: np.ndarray, strength: float) -> np.ndarray:
    """Normal map of which each normal is mixed with the surface's."""
    normals = colors * 2.0 - 1.0
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-9)
    mixed = normals * strength + np.array([0.0, 0.0, 1.0]) * (1.0 - strength)
    mixed /= np.maximum(np.linalg.norm(mixed, axis=2, keepdims=True), 1e-9)
    return mixed * 0.5 + 0.5


def _path(image: Any) -> str:
    import bpy

    return bpy.path.abspath(image.filepath, library=image.library)


def _flipped(rows: Matrix3) -> list[list[float]]:
    """Transform of UVs whose v runs downwards, as Mitsuba's images have it: F M F with F: v -> 1 - v; as four rows."""
    (a, b, e), (c, d, f), _ = rows
    return [[a, -b, 0.0, e + b], [-c, d, 0.0, 1.0 - d - f], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
