"""The extension's zip in a Blender without settings: it is installed, and renders with no other step."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import bpy
import pytest
import support
from lodestar import devices, inside

ZIP = os.environ.get("LODESTAR_ZIP", "")
KNOWN = [{"name": "grid", "type": 'int | Literal["auto"]'}, {"name": "validate", "type": "bool"}, {"name": "max_depth", "type": "int"}]
needs_zip = pytest.mark.skipif(not ZIP, reason="LODESTAR_ZIP names no extension; addons/blender/test.sh builds one")


def test_more_options_are_keywords() -> None:
    assert inside.keywords("--grid auto --validate --max-depth=8", KNOWN) == {"grid": "auto", "validate": True, "max_depth": "8"}
    assert inside.keywords("", KNOWN) == {}
    for line, fault in (("--view", "--view cannot be"), ("grid", "grid cannot be"), ("--grid", "--grid has no value")):
        with pytest.raises(ValueError, match=fault):
            inside.keywords(line, KNOWN)


def test_devices_of_one_name_are_told_apart() -> None:
    assert [devices.option(name) for name in ("", " ", "llvmpipe (LLVM 15)", "#1 GeForce")] == [None, None, "llvmpipe (LLVM 15)", "1"]


def in_clean_blender(folder: Path, script: str = "in_extension.py", *arguments: str, **variables: str) -> dict[str, Any]:
    """What a script finds in a Blender without settings, and without the program in PATH."""
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(folder / "resources"), "PATH": os.defpath, **variables}
    environment.pop("PYTHONPATH", None)
    program = [str(Path(support.PROGRAM).resolve())] if script == "in_extension.py" else []
    command = [sys.executable, str(Path(__file__).parent / script), str(Path(ZIP).resolve()), *program, str(folder), *arguments]
    ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=900, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return json.loads((folder / "found.json").read_text())


@needs_zip
def test_blender_finds_the_zip_valid() -> None:
    """Blender's strict check, which its public repository makes, too."""
    tool = Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core/bl_pkg/cli/blender_ext.py"
    ended = subprocess.run([sys.executable, str(tool), "validate", ZIP], capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr


@needs_zip
def test_the_zip_renders_with_no_other_step(tmp_path: Path) -> None:
    assert Path(ZIP).stat().st_size < 40e6
    found = in_clean_blender(tmp_path)
    assert found["is_inside"] and found["default"] and found["drawn"][0] == f"Default: {found['default']}"
    assert found["mean"] > 0.0
    assert "--view cannot be among More Options" in found["refused"]
    assert found["is_same_with_options"] and found["is_same_by_program"] and found["listed_by_program"]
    # On a busy machine, two seconds may end before the first picture.
    assert found["stopped"]["seconds"] < 30.0 and found["stopped"]["brightest"] >= 0.0
    assert found["stopped_at_once"]["brightest"] == 0.0


@needs_zip
def test_a_missing_driver_is_explained(tmp_path: Path) -> None:
    found = in_clean_blender(tmp_path, VK_DRIVER_FILES="/none", VK_ICD_FILENAMES="/none")
    assert found["is_inside"] and not found["default"]
    assert "no Vulkan driver found" in " ".join(found["advice"])
    assert " ".join(found["drawn"]).startswith("no Vulkan driver found: install your GPU's, or")
    assert "operator lodestar.look_for_devices" in found["drawn"]
    assert "no Vulkan driver found" in found["fault"]


@needs_zip
def test_a_view_is_drawn_as_it_is_rendered(tmp_path: Path) -> None:
    """The viewport through Blender's own drawing: sides, border, background, noise, the same light as F12, and edits."""
    found = in_clean_blender(tmp_path, "in_viewport.py", "40")
    pictures, edits = found["pictures"], found.get("edits", {})
    assert "fault" not in pictures, pictures["fault"]
    assert pictures["status"] == "Sample 16/16" and abs(pictures["mean"] / found["final"] - 1.0) < 0.02
    left, right = pictures["left"], pictures["right"]
    assert left[0] > 3.0 * left[1] and right[1] > 3.0 * right[0] and pictures["floor"] > 1.05 * pictures["top"]
    assert pictures["outside_of_border"] == 0.0 and pictures["inside_of_border"] < 0.1
    # A transparent film is drawn over what the region shows already.
    assert pictures["covered"] < 0.05 and pictures["background"] < 1e-3 and pictures["room"] > 0.1
    # Blender has Open Image Denoise.
    assert abs(pictures["denoised"] / pictures["mean"] - 1.0) < 0.05
    assert pictures["noise_left"] < 0.8 or "not denoised" in pictures["status_denoised"]
    # Scenes came after each other, each with the guide of the one before and other samples; nothing is left of them.
    assert edits["kinds"] >= 8 and edits["seed"] > 0 and not found["threads"]
    assert set(edits["statuses"]) <= {"Preparing", "Moving", "Sample"}
    assert edits["megabytes"][-1] < 1.3 * edits["megabytes"][len(edits["megabytes"]) // 2]
