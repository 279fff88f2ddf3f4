#!/usr/bin/env python3
"""Prints the license texts of all crates that are linked into the program, as their licenses demand.

usage: packages/licenses.py MANIFEST TARGET

A text that several crates share is printed once.
"""

import json
import subprocess
import sys
from pathlib import Path

NAMES = ("LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE", "UNLICENSE")


def cargo(*arguments):
    return subprocess.run(["cargo", *arguments], check=True, capture_output=True, text=True).stdout


def texts(manifest, target):
    """Lines of all texts."""
    lines = []
    place = ["--locked", "--manifest-path", manifest]
    packages = json.loads(cargo("metadata", "--format-version=1", "--filter-platform", target, *place))["packages"]
    tree = ["--edges", "normal", "--prefix", "none", "--target", target, "--format", "{p}"]
    linked = {tuple(line.split()[:2]) for line in cargo("tree", *tree, *place).splitlines()}
    crates_by_text = {}
    for package in sorted(packages, key=lambda package: package["name"]):
        name, version = package["name"], package["version"]
        if (name, "v" + version) not in linked:
            continue
        lines.append(f"{name} {version}: {package['license']}; {', '.join(package['authors']) or package['repository']}")
        for file in sorted(Path(package["manifest_path"]).parent.iterdir()):
            if file.is_file() and file.name.upper().startswith(NAMES):
                text = "\n".join(line.rstrip() for line in file.read_text(errors="replace").strip().splitlines())
                crates_by_text.setdefault(text, []).append(name)
    for text, crates in crates_by_text.items():
        lines.append(f"\n{'=' * 100}\n{', '.join(dict.fromkeys(crates))}\n{'=' * 100}\n{text}")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("licenses.py: usage: packages/licenses.py MANIFEST TARGET")
    sys.stdout.write(texts(*sys.argv[1:]))
