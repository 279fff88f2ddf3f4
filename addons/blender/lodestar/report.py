"""Report: what the export could not translate, each thing once, with the place where it stands."""

from __future__ import annotations


class Report:
    """Warnings of one export, in the order of their first appearance."""

    def __init__(self) -> None:
        self._warnings: dict[str, None] = {}

    def warn(self, place: str, message: str) -> None:
        """Adds a warning about `place`, such as ``material "Wood"``."""
        self._warnings.setdefault(f"{place}: {message}")

    @property
    def warnings(self) -> list[str]:
        """All warnings."""
        return list(self._warnings)

    def __contains__(self, text: str) -> bool:
        return any(text in warning for warning in self._warnings)
