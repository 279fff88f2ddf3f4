#!/usr/bin/env bash
# Builds the extension lodestar-blender-VERSION-SYSTEM.zip, which Blender installs from disk. It contains the renderer as a wheel.
#
# usage: addons/blender/build.sh [FOLDER] [WHEEL...]   (default: dist in the root of the project, and a wheel that is built for this system)
set -euo pipefail
folder=$(realpath -m "${1:-$(dirname "$0")/../../dist}")
shift $(($# > 0 ? 1 : 0))
wheels=()
for wheel in "$@"; do wheels+=("$(realpath "$wheel")"); done
cd "$(dirname "$0")"
mkdir -p "$folder"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ ${#wheels[@]} = 0 ]; then
  python3 -m venv "$work/venv"
  "$work/venv/bin/python" -m pip wheel --quiet --disable-pip-version-check --no-deps ../../python -w "$work"
  wheels=("$work"/lodestar_render-*.whl)
fi
python3 - "$folder" "${wheels[@]}" <<'PYTHON'
import json, pathlib, re, sys, zipfile

PLATFORMS = {"linux_x86_64": "linux-x64", "linux_aarch64": "linux-arm64", "win_amd64": "windows-x64", "macos_arm64": "macos-arm64"}


def platform(wheel):
    """Blender's name of a wheel's system: `manylinux_2_28_x86_64` is `linux-x64`."""
    tag = re.sub(r"^(many)?(linux|macosx)(_?\d+)*_", lambda found: found.group(2).replace("macosx", "macos") + "_", wheel.stem.split("-")[-1])
    if tag not in PLATFORMS:
        sys.exit(f"{wheel.name}: Blender has no platform `{tag}`")
    return PLATFORMS[tag]


source = pathlib.Path("lodestar")
folder, *wheels = map(pathlib.Path, sys.argv[1:])
manifest = (source / "blender_manifest.toml").read_text()
version = re.search(r'^version = "(.*)"', manifest, re.M).group(1)
systems = sorted(map(platform, wheels))
files = f"wheels = {json.dumps([f'./wheels/{wheel.name}' for wheel in wheels])}\nplatforms = {json.dumps(systems)}\n"
path = folder / f"lodestar-blender-{version}-{'-'.join(systems)}.zip"
with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
    for file in sorted(source.glob("*.py")):
        archive.write(file, file.name)
    # The keys must stand before the first table.
    archive.writestr("blender_manifest.toml", manifest.replace("\n[permissions]", f"\n{files}\n[permissions]", 1))
    for file in ("LICENSE-MIT", "LICENSE-APACHE"):
        archive.write(pathlib.Path("../..") / file, file)
    for wheel in wheels:
        archive.write(wheel, f"wheels/{wheel.name}", zipfile.ZIP_STORED)
print(path.resolve())
PYTHON
