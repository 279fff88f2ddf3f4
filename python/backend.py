"""Build backend of the wheel: maturin, with the licenses of Lodestar and of all crates that the wheel links.

`pip wheel ./python` calls it. The files that it puts beside pyproject.toml are not in the repository, because cargo knows them all.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import maturin
from maturin import get_requires_for_build_editable, get_requires_for_build_sdist, get_requires_for_build_wheel

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_wheel",
]

HERE = Path(__file__).resolve().parent


def gather_licenses():
    """Puts the texts beside pyproject.toml, whose `license-files` names them."""
    sys.path.insert(0, str(HERE.parent / "packages"))
    import licenses

    version = subprocess.run(["rustc", "-vV"], check=True, capture_output=True, text=True).stdout
    target = next(line.split()[1] for line in version.splitlines() if line.startswith("host:"))
    (HERE / "LICENSES-OF-DEPENDENCIES.txt").write_text(licenses.texts(str(HERE / "Cargo.toml"), target))
    for name in ("LICENSE-MIT", "LICENSE-APACHE"):
        shutil.copy(HERE.parent / name, HERE / name)


def prepare_metadata_for_build_wheel(*arguments, **keywords):
    gather_licenses()
    return maturin.prepare_metadata_for_build_wheel(*arguments, **keywords)


def build_wheel(*arguments, **keywords):
    gather_licenses()
    return maturin.build_wheel(*arguments, **keywords)


def build_editable(*arguments, **keywords):
    gather_licenses()
    return maturin.build_editable(*arguments, **keywords)


def build_sdist(*arguments, **keywords):
    gather_licenses()
    return maturin.build_sdist(*arguments, **keywords)
