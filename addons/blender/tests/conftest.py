"""Registration of the add-on, whose program the environment variable LODESTAR names."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent.parent))

import lodestar  # noqa: E402
import support  # noqa: E402
from lodestar import process  # noqa: E402


@pytest.fixture(scope="session", autouse=True)
def registered() -> Iterator[None]:
    found = process.find
    process.find = lambda preferred: found(preferred or support.PROGRAM)
    lodestar.register()
    yield
    lodestar.unregister()
    process.find = found
