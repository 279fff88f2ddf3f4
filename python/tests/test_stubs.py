"""Stubs agree with the package, and with the table of options."""

import os
import pathlib
import re
import subprocess
import sys

import lodestar

STUB = pathlib.Path(lodestar.__file__).with_name("_lodestar.pyi")
BLOCK = re.compile(r"(# --- keywords: [^\n]*\n)(.*?)(# --- end of keywords\n)", re.DOTALL)
# The signatures name these.
EXPLICIT = {"spp", "time", "seed", "width", "height", "device", "guide"}


def keywords():
    lines = ["@final", "class _Keywords(TypedDict, total=False):"]
    lines += [f"    {o['name']}: {o['type']} | None" for o in lodestar.options() if o["name"] not in EXPLICIT]
    return "\n".join(["", *lines, "", ""])


def test_keywords_of_the_stub_are_those_of_the_table():
    written = os.environ.get("LODESTAR_WRITE_STUB")
    if written:
        text = pathlib.Path(written).read_text()
        pathlib.Path(written).write_text(BLOCK.sub(lambda match: match[1] + keywords() + match[3], text))
        return
    found = BLOCK.search(STUB.read_text())[2]
    assert found == keywords(), "write them with LODESTAR_WRITE_STUB=python/lodestar/_lodestar.pyi"


def run(*arguments, folder):
    told = subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True, cwd=folder)
    assert told.returncode == 0, told.stdout + told.stderr


def test_stubs_agree_with_the_package(tmp_path):
    run("mypy.stubtest", "lodestar", "--ignore-missing-stub", folder=tmp_path)


GOOD = """
import lodestar
import numpy as np

def watch(renderer: lodestar.Renderer) -> bool:
    return renderer.samples < 8

picture = lodestar.render("scene.xml", spp=64, seed=1, sampler="bsdf", nee=False, crop=(0, 0, 4, 4), callback=watch)
total: float = float(picture.radiance.sum()) + lodestar.compare(picture, np.zeros((4, 4, 3)))["mse"]
scene: lodestar.Scene = lodestar.load({"type": "scene"})
guide: lodestar.Guide = lodestar.Renderer(scene, grid="auto").guide
"""
BAD = ['lodestar.render("a", spp="many")', 'lodestar.render("a", sampler="mine")', 'lodestar.render("a", sppp=1)',
       "lodestar.load(3)", 'lodestar.render("a").radiance = 1']


def test_mypy_accepts_right_programs_and_refuses_wrong_ones(tmp_path):
    (tmp_path / "good.py").write_text(GOOD)
    run("mypy", "--strict", "good.py", folder=tmp_path)
    (tmp_path / "bad.py").write_text("import lodestar\n" + "\n".join(BAD) + "\n")
    told = subprocess.run([sys.executable, "-m", "mypy", "--strict", "bad.py"], capture_output=True, text=True, cwd=tmp_path)
    faulty = {int(line.split(":")[1]) for line in told.stdout.splitlines() if ": error:" in line}
    assert faulty == set(range(2, 2 + len(BAD))), told.stdout
    run("mypy", "--strict", "-p", "lodestar", folder=tmp_path)


def test_help_teaches():
    for name in (name for name in lodestar.__all__ if not name.startswith("_")):
        thing = getattr(lodestar, name)
        assert thing.__doc__ and len(thing.__doc__) > 40, name
        for member in (vars(thing) if isinstance(thing, type) and name != "Error" else []):
            if not member.startswith("_"):
                assert getattr(thing, member).__doc__, f"{name}.{member}"
    assert "Parameters" in lodestar.render.__doc__ and "lodestar.Error" in lodestar.load.__doc__
