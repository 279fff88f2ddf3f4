"""Renders each .blend file of a folder, each in a process of its own, and counts what the export reports.

usage: LODESTAR=PROGRAM python addons/blender/tests/real_files.py FOLDER [--compare] [--samples N] [--size PIXELS] [--limit SECONDS]

Prints a line for each file: what became of it, the number of warnings and, with --compare, the ratio of the means to Cycles and the largest
deviation of a block of 16 x 16 pixels. A file agrees if its mean is within 2 % and its blocks are within 5 %. For a file that differs, Cycles
renders a second picture with another seed: if Cycles does not agree with itself either, the samples are too few to judge the file. The file
is compared once more with its corners moved a little, and the line says whether it agrees then (`_move_apart`). Then come the kinds of
warnings with the number of files that have them. The exit code is 1 if a file ended the process, or took longer than the limit.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

MOST_OF_MEAN, MOST_OF_BLOCK = 0.02, 0.05
# Bounces of Cycles. Paths of Lodestar have no limit.
BOUNCES = 64
Result = dict[str, Any]


def kind_of(warning: str) -> str:
    """Warning without the names and the numbers of one file."""
    unnamed = re.sub(r'"[^"]*"', '"..."', warning)
    return re.sub(r"[0-9]+([.][0-9]+)?", "N", unnamed.replace(' "..."', "", 1) if not unnamed.startswith("scene:") else unnamed)


def render(path: Path, options: argparse.Namespace) -> Result:
    """Opens and renders one file in this process."""
    import bpy

    sys.path.insert(0, str(Path(__file__).parent.parent))
    import lodestar
    import support
    from lodestar import engine, process

    try:
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False, use_scripts=False)
    except RuntimeError as fault:
        return {"state": "not opened", "message": str(fault).strip().splitlines()[-1], "warnings": []}
    find, export = process.find, engine.export.export
    process.find = lambda preferred: find(preferred or support.PROGRAM)
    warnings: list[str] = []

    def watched(*arguments: Any) -> Any:
        found = export(*arguments)
        warnings.extend(each for each in found.report.warnings if each not in warnings)
        return found

    engine.export.export = watched
    lodestar.register()
    scene = bpy.context.scene
    if scene.camera is None:
        return {"state": "no camera", "warnings": []}
    if not any(layer.use for layer in scene.view_layers):
        # Blender itself ends with a fault when it writes such a picture.
        return {"state": "no view layer", "warnings": []}
    _prepare(scene, options.size)
    try:
        ours = support.colors(support.render(scene, "LODESTAR", options.samples if options.compare else 1, bounces=None))
    except RuntimeError as fault:
        return {"state": "refused", "message": str(fault).strip().splitlines()[0], "warnings": warnings}
    result: Result = {"state": "rendered", "warnings": warnings}
    if options.compare:
        theirs = support.colors(support.render(scene, "CYCLES", options.samples, bounces=BOUNCES))
        if ours.any() or theirs.any():
            result["ratio"], result["block"] = support.mean_ratio(ours, theirs), support.deviation(ours, theirs)
        else:
            result["message"] = "both pictures are black"
    if "ratio" in result and not agrees(result):
        scene.cycles.seed += 1
        again = support.colors(support.render(scene, "CYCLES", options.samples, bounces=BOUNCES))
        result["itself"] = {"ratio": support.mean_ratio(again, theirs), "block": support.deviation(again, theirs)}
        _move_apart(scene)
        theirs = support.colors(support.render(scene, "CYCLES", options.samples, bounces=BOUNCES))
        ours = support.colors(support.render(scene, "LODESTAR", options.samples, bounces=None))
        result["apart"] = {"ratio": support.mean_ratio(ours, theirs), "block": support.deviation(ours, theirs)}
    return result


def _move_apart(scene: Any) -> None:
    """Moves all corners of meshes by chance, by at most 1/3000 of the object's size, so that no faces lie in the same place.

    Where two faces do, a ray of Cycles that starts at one may meet the other at once, or not, as numbers are rounded. So they are dark and
    spotted there, by the luck of the processor, and no other renderer can be compared there.
    """
    import bpy
    import numpy as np

    random = np.random.default_rng(1)
    for owner in [each for each in scene.objects if each.mode != "OBJECT"]:
        bpy.context.view_layer.objects.active = owner
        bpy.ops.object.mode_set(mode="OBJECT")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    # What makes instances stays, with its modifiers.
    instancers = {each.parent.original for each in depsgraph.object_instances if each.is_instance and each.parent is not None}
    meshes = [each for each in scene.objects if each.type == "MESH" and not each.hide_render and each not in instancers]
    made = [(owner, bpy.data.meshes.new_from_object(owner.evaluated_get(depsgraph))) for owner in meshes]
    for owner, mesh in made:
        places = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", places)
        if len(places) > 0:
            size = float(np.ptp(places.reshape(-1, 3), axis=0).max())
            mesh.vertices.foreach_set("co", places + random.uniform(-size / 3000.0, size / 3000.0, len(places)).astype(np.float32))
            mesh.update()
        for modifier in owner.modifiers:
            modifier.show_render = False
        owner.data = mesh


def _prepare(scene: Any, size: int) -> None:
    """Makes the picture small, without a border, and what is rendered without compositing."""
    render = scene.render
    share = size / max(render.resolution_x, render.resolution_y)
    render.resolution_x, render.resolution_y = (max(round(side * share), 16) for side in (render.resolution_x, render.resolution_y))
    render.resolution_percentage = 100
    render.use_border = render.use_multiview = render.use_compositing = render.use_sequencer = False
    formats = {"media_type": "MULTI_LAYER_IMAGE", "file_format": "OPEN_EXR_MULTILAYER"}
    # What the reader of EXR files knows.
    formats |= {"use_exr_interleave": True, "exr_codec": "ZIP", "color_depth": "32"}
    for name, value in formats.items():
        if hasattr(render.image_settings, name):
            setattr(render.image_settings, name, value)


def in_process(path: Path, arguments: list[str], limit: float) -> Result:
    """Result of one file. A crash or a render without an end is a result, too."""
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "result.json"
        command = [sys.executable, __file__, str(path), "--result", str(written), *arguments]
        try:
            ended = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=limit, check=False)
        except subprocess.TimeoutExpired:
            return {"state": "too long", "message": f"more than {limit:g} s", "warnings": []}
        if written.exists():
            return json.loads(written.read_text())
        last = ended.stderr.decode(errors="replace").strip().splitlines()[-1:]
        return {"state": "crash", "message": " ".join([f"exit code {ended.returncode}", *last]), "warnings": []}


def agrees(result: Result) -> bool:
    return "ratio" in result and abs(result["ratio"] - 1.0) < MOST_OF_MEAN and result["block"] < MOST_OF_BLOCK


def line_of(name: str, result: Result) -> str:
    words = [result["state"], f"{len(result['warnings'])} warnings"] if result["state"] == "rendered" else [result["state"]]
    if "ratio" in result:
        verdict = "agrees" if agrees(result) else "differs"
        words.append(f"{verdict}: mean {result['ratio']:.3f}, block {100.0 * result['block']:.1f} %")
    for key, suffix in (("itself", " by Cycles itself with another seed"), ("apart", " with faces apart")):
        if key in result:
            verdict = "agrees" if agrees(result[key]) else "differs"
            words.append(f"{verdict}{suffix}: mean {result[key]['ratio']:.3f}, block {100.0 * result[key]['block']:.1f} %")
    if "message" in result:
        words.append(result["message"])
    return f"{name}: {', '.join(words)}"


def summary(results: list[Result]) -> list[str]:
    """Lines with the numbers of files."""
    states = Counter(result["state"] for result in results)
    lines = [", ".join(f"{count} {state}" for state, count in states.most_common())]
    rendered = [result for result in results if result["state"] == "rendered"]
    silent = [result for result in rendered if not result["warnings"]]
    lines.append(f"{len(silent)} of {len(rendered)} without a warning")
    if any("ratio" in result for result in rendered):
        lines.append(f"{sum(map(agrees, rendered))} agree with Cycles, {sum(map(agrees, silent))} of them without a warning")
        apart = [result for result in rendered if agrees(result.get("apart", {}))]
        lines.append(f"{len(apart)} more agree with faces apart, {sum(result in silent for result in apart)} of them without a warning")
        noisy = [result for result in rendered if "itself" in result and not agrees(result["itself"]) and result not in apart]
        lines.append(f"{len(noisy)} more differ between two seeds of Cycles, {sum(result in silent for result in noisy)} of them without a warning")
    kinds = Counter(kind for result in results for kind in {kind_of(warning) for warning in result["warnings"]})
    return lines + [f"{count:5} {kind}" for kind, count in kinds.most_common()]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("path", type=Path)
    parser.add_argument("--compare", action="store_true", help="render with Cycles, too")
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--size", type=int, default=128, help="pixels of the longer side")
    parser.add_argument("--limit", type=float, default=600.0, help="seconds for a file")
    parser.add_argument("--result", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.result is not None:
        options.result.write_text(json.dumps(render(options.path, options)))
        return 0
    passed = ["--samples", str(options.samples), "--size", str(options.size), *(["--compare"] if options.compare else [])]
    results = []
    for path in sorted(options.path.rglob("*.blend")):
        results.append(in_process(path, passed, options.limit))
        print(line_of(str(path.relative_to(options.path)), results[-1]), flush=True)
    print("\n".join(["", *summary(results)]))
    return 1 if any(result["state"] in ("crash", "too long") for result in results) else 0


if __name__ == "__main__":
    sys.exit(main())
