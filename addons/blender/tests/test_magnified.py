"""Images of a few texels, magnified, beside Cycles. It mixes the bytes of an image in sRGB before it decodes them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable

import bpy
import numpy as np
import pytest
import scenes
import support
from lodestar import images, png, report

# Largest deviation of blocks of 4 x 4 pixels, where surfaces emit and where they reflect, which is noise; and of means.
EMITTED, REFLECTED, WHOLE = 0.005, 0.03, 0.003

TEXELS = np.array(
    [
        [[0, 0, 0, 255], [255, 255, 255, 255], [30, 200, 90, 255], [255, 20, 20, 255]],
        [[255, 240, 10, 255], [10, 20, 160, 255], [0, 0, 0, 255], [240, 240, 255, 255]],
        [[128, 128, 128, 255], [0, 0, 0, 255], [255, 255, 255, 255], [20, 90, 30, 255]],
        [[0, 0, 0, 255], [250, 120, 0, 255], [60, 0, 90, 255], [255, 255, 255, 255]],
    ],
    np.uint8,
)


def masked() -> np.ndarray:
    """Texels of which some are clear."""
    texels = TEXELS.copy()
    texels[1, :, 3], texels[:, 2, 3] = 40, 150
    texels[2, 0, 3] = 0
    return texels


def loaded(folder: Path, texels: np.ndarray, is_packed: bool = False) -> Any:
    """Image of a PNG file."""
    path = folder / f"texels-{len(bpy.data.images)}.png"
    png.write(path, texels)
    made = bpy.data.images.load(str(path))
    if is_packed:
        made.pack()
    return made


def surface(image: Any, build: Callable[[Any, Any], Any], interpolation: str = "Linear") -> Any:
    """Material with an image. `build(tree, node)` makes the shader's socket."""

    def shader(tree: Any) -> Any:
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image, node.interpolation, node.extension = image, interpolation, "EXTEND"
        return build(tree, node)

    return scenes.material("shown", shader)


def emitted(tree: Any, node: Any) -> Any:
    return scenes.shader(tree, "ShaderNodeEmission", Color=node.outputs["Color"]).outputs[0]


def reflected(tree: Any, node: Any) -> Any:
    return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=node.outputs["Color"]).outputs[0]


def channel(tree: Any, node: Any) -> Any:
    split = scenes.shader(tree, "ShaderNodeSeparateColor", Color=node.outputs["Color"])
    return scenes.shader(tree, "ShaderNodeEmission", Color=split.outputs[0]).outputs[0]


def computed(tree: Any, node: Any) -> Any:
    """A color that a program computes."""
    changed = scenes.shader(tree, "ShaderNodeGamma", Color=node.outputs["Color"], Gamma=1.5)
    return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=changed.outputs[0]).outputs[0]


def covered(tree: Any, node: Any) -> Any:
    """A color times alpha. Where alpha is linked, Cycles divides the mix of colors by that of alpha."""
    product = tree.nodes.new("ShaderNodeVectorMath")
    product.operation = "MULTIPLY"
    for output, socket in zip(("Color", "Alpha"), product.inputs):
        tree.links.new(node.outputs[output], socket)
    return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=product.outputs[0]).outputs[0]


def in_space(image: Any, space: str) -> Any:
    image.colorspace_settings.name = space
    return image


def cases(folder: Path) -> dict[str, Any]:
    """Materials by name."""
    opaque, packed = loaded(folder, TEXELS), loaded(folder, masked(), True)
    clear = loaded(folder, masked())
    return {
        "file": surface(loaded(folder, TEXELS[:, :, :3]), emitted),
        "packed file": surface(loaded(folder, TEXELS[:, :, :3], True), emitted),
        "reflected": surface(opaque, reflected),
        "channel": surface(opaque, channel),
        "computed": surface(opaque, computed),
        "alpha beside": surface(clear, reflected),
        "alpha linked": surface(clear, covered),
        "packed alpha linked": surface(packed, covered),
        "packed alpha beside": surface(packed, emitted),
        "nearest": surface(opaque, emitted, "Closest"),
        "data": surface(in_space(loaded(folder, TEXELS), "Non-Color"), emitted),
        "linear": surface(in_space(loaded(folder, TEXELS), "Linear Rec.709"), emitted),
    }


# Cases with light that is reflected.
NOISY = {"reflected", "computed", "alpha beside", "alpha linked", "packed alpha linked"}
# Squares in a row, and pixels of each.
COLUMNS, SIDE = 4, 32


def compared(folder: Path, only: str = "") -> dict[str, tuple[float, float]]:
    """Largest deviation of blocks and the ratio of means of each case, by its name. All stand side by side in one picture."""
    scene = scenes.empty()
    found = {name: each for name, each in cases(folder).items() if only in ("", name)}
    rows = -(-len(found) // COLUMNS)
    scene.render.resolution_x, scene.render.resolution_y = COLUMNS * SIDE, rows * SIDE
    scenes.camera(scene, (0, 0, 3), (0, 0, 0), type="ORTHO", ortho_scale=max(COLUMNS, rows))
    scenes.world(scene, (0.5, 0.5, 0.5))
    for at, (name, material) in enumerate(found.items()):
        place = (at % COLUMNS + 0.5 - 0.5 * COLUMNS, 0.5 * rows - 0.5 - at // COLUMNS, 0)
        scenes.plane(scene, name, 1, material, location=place)
    theirs, ours = (support.colors(support.render(scene, engine, 128, "magnified")) for engine in ("CYCLES", "LODESTAR"))

    def agreement(at: int) -> tuple[float, float]:
        row, column = at // COLUMNS * SIDE, at % COLUMNS * SIDE
        first, second = (each[row : row + SIDE, column : column + SIDE] for each in (ours, theirs))
        return support.deviation(first, second, 4), support.mean_ratio(first, second)

    return {name: agreement(at) for at, name in enumerate(found)}


def test_bytes_are_mixed_as_in_cycles(tmp_path: Path) -> None:
    found = compared(tmp_path)
    for name, (deviation, ratio) in found.items():
        print(f"{name}: largest deviation {deviation:.4f}, ratio of means {ratio:.4f}")
        assert deviation < (REFLECTED if name in NOISY else EMITTED) and abs(ratio - 1.0) < WHOLE


def test_twin_texels_that_are_decoded_first_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(images, "_is_encoded", lambda texture: False)
    deviation, ratio = compared(tmp_path, "file")["file"]
    assert deviation > 0.3 and ratio > 1.1


def test_a_file_without_alpha_is_named_where_it_is(tmp_path: Path) -> None:
    scenes.empty()
    kept = images.Images(tmp_path, report.Report())
    texture = images.Texture(image=loaded(tmp_path, TEXELS[:, :, :3]))
    element = kept.element(texture)
    assert [each.attrib for each in kept.element(texture.covered())] == [each.attrib for each in element]
    told = {child.get("name"): child.get("value") for child in element}
    assert told == {"filename": element[0].get("value"), "raw": "false", "decode_after_filter": "true"}
    assert Path(element[0].get("value", "")).parent == tmp_path
