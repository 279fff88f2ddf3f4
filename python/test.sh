#!/usr/bin/env bash
# Builds the wheel, installs it in an empty virtual environment, and tests it in a folder away from the repository: pictures beside
# the command line's, dictionaries beside XML, stubs, notebooks.
#
# usage: python/test.sh [PYTEST ARGUMENT...]
set -euo pipefail
cd "$(dirname "$0")/.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

python3 -m venv "$work/venv"
pip() { "$work/venv/bin/python" -m pip --quiet --disable-pip-version-check "$@"; }
if ! pip install numpy hypothesis ipykernel matplotlib mypy nbclient nbformat pytest typing_extensions; then
  echo "skipped: pip cannot install the tools of Python's tests"
  exit 0
fi

cargo fmt --check -p lodestar-python
cargo clippy --release --quiet -p lodestar-python -- -D warnings
pip wheel --no-deps ./python -w "$work/dist"
pip install --no-deps "$work"/dist/*.whl

cp -r python/tests python/notebooks scenes "$work"
cd "$work/tests"
LODESTAR_TEST_SCENES=$work/scenes ../venv/bin/python -m pytest -p no:cacheprovider "$@"
