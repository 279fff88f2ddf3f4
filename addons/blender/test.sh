#!/usr/bin/env bash
# Tests the Blender add-on with the package `bpy`, which is Blender as a Python module: units, reports, registration, the extension in a
# Blender without settings, and ten scenes beside Cycles. Prints one sentence where Python 3.11 or the package is missing.
#
# usage: addons/blender/test.sh [PYTEST ARGUMENT...]
#
# LODESTAR names the program (default: target/release/lodestar), BPY_PYTHON a Python that has bpy, numpy and pytest already, LODESTAR_ZIP
# the extension (default: one that build.sh builds).
set -euo pipefail
cd "$(dirname "$0")/../.."

export LODESTAR=${LODESTAR:-$PWD/target/release/lodestar}
[ -x "$LODESTAR" ] || cargo build --release --quiet

python=${BPY_PYTHON:-}
if [ -z "$python" ]; then
  venv=target/bpy-venv
  if ! { [ -x $venv/bin/python ] || python3.11 -m venv $venv; } 2>/dev/null \
    || ! $venv/bin/python -m pip install --quiet --disable-pip-version-check 'bpy==5.0.*' numpy pytest; then
    echo "skipped: the tests need Python 3.11 and its package bpy 5.0"
    exit 0
  fi
  python=$venv/bin/python
fi
if ! message=$("$python" -c "import bpy" 2>&1); then
  echo "skipped: bpy cannot be loaded: ${message##*$'\n'}"
  exit 0
fi
[ -n "${LODESTAR_ZIP:-}" ] || LODESTAR_ZIP=$(addons/blender/build.sh target/blender)
export LODESTAR_ZIP
exec "$python" -W ignore::DeprecationWarning -m pytest -p no:cacheprovider -q addons/blender/tests "$@"
