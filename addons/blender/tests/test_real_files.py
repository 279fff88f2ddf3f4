"""The script that renders a folder of .blend files."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import bpy
import real_files
import scenes
import support


def test_a_folder(tmp_path: Path) -> None:
    """Files that agree, have faces in the same place, are refused, have no camera or no view layer, or are no .blend files."""
    scene = scenes.empty()
    scenes.camera(scene, (0, 0, 3), (0, 0, 0))
    scenes.world(scene, (1, 1, 1))
    plane = scenes.plane(scene, "ground", 9, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    save = lambda name: bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / f"{name}.blend"))  # noqa: E731
    save("agrees")
    twin = scenes.plane(scene, "twin", 9, plane.data.materials[0])
    scenes.lamp(scene, "SUN", (0, 0, 3), energy=3.0, angle=0.0)
    save("twins")
    bpy.data.objects.remove(twin)
    bpy.data.objects.remove(scene.objects["sun"])
    plane.is_holdout = True
    save("differs")
    scene.view_layers[0].use = False
    save("layerless")
    scene.view_layers[0].use = True
    scene.camera.data.type = "PANO"
    save("panorama")
    scene.camera = None
    save("without")
    (tmp_path / "noise.blend").write_bytes(b"noise")
    command = [sys.executable, real_files.__file__, str(tmp_path), "--compare", "--samples", "16", "--size", "32"]
    ended = subprocess.run(command, env={**os.environ, "LODESTAR": support.PROGRAM}, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    lines = ended.stdout.splitlines()
    for start in (
        "agrees.blend: rendered, 0 warnings, agrees: mean 1.00",
        "differs.blend: rendered, 1 warnings, differs",
        "twins.blend: rendered, 0 warnings, differs",
        "1 more agree with faces apart, 1 of them without a warning",
        "noise.blend: not opened",
        "panorama.blend: refused",
        "without.blend: no camera",
        "layerless.blend: no view layer",
        "2 of 3 without a warning",
        "1 agree with Cycles, 1 of them without a warning",
        "    1 object: a holdout is not supported; it is an ordinary surface",
    ):
        assert any(line.startswith(start) for line in lines), (start, ended.stdout)
    for line in lines[:7]:
        assert ("by Cycles itself with another seed" in line) == ("warnings, differs" in line), line


def test_files_that_cycles_cannot_judge() -> None:
    """A file that differs is counted apart where two seeds of Cycles differ, too, and where it does not agree otherwise."""
    differs, same = {"ratio": 1.4, "block": 0.5}, {"ratio": 1.0, "block": 0.01}
    result = {"state": "rendered", "warnings": [], **differs}
    for itself, apart, found in ((differs, differs, 1), (same, differs, 0), (differs, same, 0)):
        lines = real_files.summary([{**result, "itself": itself, "apart": apart}])
        assert f"{found} more differ between two seeds of Cycles, {found} of them without a warning" in lines
    line = real_files.line_of("a", {**result, "itself": same, "apart": differs})
    assert "agrees by Cycles itself with another seed: mean 1.000" in line and "differs with faces apart: mean 1.400" in line


def test_kinds_of_warnings() -> None:
    """Names and numbers of one file are no part of a kind."""
    kind = 'material: the node "..." (Noise Texture) is not supported'
    assert real_files.kind_of('material "A": the node "Noise.001" (Noise Texture) is not supported') == kind
    assert real_files.kind_of('material "B: 2": the node "N" (Noise Texture) is not supported') == kind
