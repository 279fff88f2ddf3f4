#!/usr/bin/env python3
"""Converts models in glTF that nobody of this project made, and compares with Mitsuba.

    tests/real_files/gltf.py LODESTAR    (pip install mitsuba numpy)

LODESTAR_REAL_MODELS names the folder of the models, a copy of the repository that gltf.tsv names; without it, nothing is done. The
models of gltf.tsv are tried: `lodestar convert` writes each as a Mitsuba file, which Mitsuba must load. Both render the file. The
means of 4 x 4 blocks must agree: |z| < 5, as in run.py. A model without a light gets light of radiance 1 from all sides."""
import doctest
import os
import pathlib
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import run  # noqa: E402

LIGHT = '<emitter type="constant"><rgb name="radiance" value="1"/></emitter>'
BOUNCES = 8
# A principled surface of a white base color reflects more light than it gets, so that unbounded paths have no sum.
PLAIN = '<integrator type="path"/>'
BOUNDED = f'<integrator type="path"><integer name="max_depth" value="{BOUNCES + 1}"/></integrator>'


def models():
    """Paths of the models."""
    lines = pathlib.Path(__file__).with_name("gltf.tsv").read_text(encoding="utf8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def lit(text):
    """Scene with a light, where it has none.

    >>> lit('<scene version="3.0.0">\\n</scene>').count("constant")
    1
    >>> lit('<scene version="3.0.0"><emitter type="point"/></scene>').count("constant")
    0
    """
    return text if "<emitter" in text else text.replace("</scene>", LIGHT + "</scene>")


def converted(lodestar, model, folder):
    """Mitsuba file that `lodestar convert` makes of a model, with light."""
    out = pathlib.Path(folder) / "converted.xml"
    subprocess.run([lodestar, "convert", model, out], capture_output=True, check=True)
    text = lit(out.read_text(encoding="utf8"))
    assert PLAIN in text, "the converted file names its integrator"
    # Mitsuba keeps the horizontal field of view when a film's size changes later.
    text = re.sub(r'(name="(?:width|height)" value=")\d+', rf"\g<1>{run.SIZE}", text)
    # At the border of a picture, the two treat a filter wider than a pixel differently (docs/differences.md).
    text = text.replace("</film>", '<rfilter type="box"/></film>')
    out.write_text(text.replace(PLAIN, BOUNDED), encoding="utf8")
    return out


def with_mitsuba(lodestar, model):
    with tempfile.TemporaryDirectory() as folder:
        agrees, message = run.compare(lodestar, converted(lodestar, model, folder))
    return bool(agrees), message


def main():
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    if doctest.testmod().failed:
        return 1
    folder = os.environ.get("LODESTAR_REAL_MODELS")
    if not folder:
        print("skipped: LODESTAR_REAL_MODELS names no folder of models")
        return 0
    faults = 0
    for path in models():
        agrees, message = with_mitsuba(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(folder, path).resolve())
        faults += not agrees
        print(f"{'agrees' if agrees else 'differs'}  {path}  {message}", flush=True)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
