"""Renders each .blend file of a folder, each in a process of its own, and counts what the export reports.

usage: LODESTAR=PROGRAM python addons/blender/tests/real_files.py FOLDER [--compare] [--samples N] [--size PIXELS] [--limit SECONDS]

Prints a line for each file: what became of it, the number of warnings and, with --compare, the ratio of the means to Cycles and the largest
deviation of a block of 16 x 16 pixels. A file agrees if its mean is within 2 % and its blocks are within 5 %. Then come the kinds of
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
    return result


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
