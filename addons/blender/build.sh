#!/usr/bin/env bash
# Builds the extension lodestar-blender-VERSION.zip, which Blender installs from disk.
#
# usage: addons/blender/build.sh [FOLDER]   (default: dist in the root of the project)
set -euo pipefail
folder=$(realpath -m "${1:-$(dirname "$0")/../../dist}")
cd "$(dirname "$0")"
mkdir -p "$folder"
python3 - "$folder" <<'PYTHON'
import pathlib, re, sys, zipfile

source = pathlib.Path("lodestar")
version = re.search(r'^version = "(.*)"', (source / "blender_manifest.toml").read_text(), re.M).group(1)
path = pathlib.Path(sys.argv[1]) / f"lodestar-blender-{version}.zip"
with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
    for file in [*sorted(source.glob("*.py")), source / "blender_manifest.toml"]:
        archive.write(file, file.name)
    for file in ("LICENSE-MIT", "LICENSE-APACHE"):
        archive.write(pathlib.Path("../..") / file, file)
print(path.resolve())
PYTHON
