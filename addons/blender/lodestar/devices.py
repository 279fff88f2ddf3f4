"""Devices: what can render on this machine, and what keeps a device from use, in the words of `lodestar devices`."""

from __future__ import annotations

import json
import re
import subprocess
from collections import Counter
from typing import Any, NamedTuple, Optional

from . import inside, process

_found: Optional["Found"] = None


class Found(NamedTuple):
    """Devices of this machine."""

    names: list[str]  # as the preference Device takes them
    default: str  # empty where no device can render
    advice: list[str]  # sentences of `lodestar devices`; what to do comes first


def found(program: str) -> Found:
    """Devices that a renderer finds. They are looked for once: `forget` says that they have changed."""
    global _found
    if _found is None:
        _found = _look(program)
    return _found


def forget() -> None:
    """Lets the next call of `found` look again."""
    global _found
    _found = None


def option(device: str) -> Optional[str]:
    """Value of the option `--device` for a preference; None where the renderer chooses."""
    numbered = re.match(r"#(\d+) ", device)
    return numbered.group(1) if numbered is not None else device.strip() or None


def _look(program: str) -> Found:
    package = inside.package() if not program.strip() else None
    try:
        listed = _listed(package, program)
    except (OSError, ValueError, subprocess.SubprocessError) as fault:
        return Found([], "", [str(fault)])
    counts = Counter(each["name"] for each in listed["devices"])
    named = {each["index"]: each["name"] if counts[each["name"]] == 1 else f"#{each['index']} {each['name']}" for each in listed["devices"]}
    return Found(list(named.values()), named.get(listed["default"], ""), listed["advice"])


def _listed(package: Optional[Any], program: str) -> dict[str, Any]:
    """What `lodestar devices --json` prints."""
    if package is None:
        ended = subprocess.run([process.find(program), "devices", "--json"], capture_output=True, text=True, timeout=60, check=False)
        return json.loads(ended.stdout)
    try:
        devices = package.devices()
    except package.Error as fault:
        return {"devices": [], "default": None, "advice": [str(fault)]}
    default = next((each["index"] for each in devices if each["default"]), None)
    advice = [] if default is not None else [each["refused"] for each in devices if each["refused"]]
    return {"devices": devices, "default": default, "advice": advice}
