"""Report: what the export could not translate, and what is wrong with the file, each thing once, with the place where it stands."""

from __future__ import annotations


class Report:
    """Warnings and notes of one export, in the order of their first appearance.

    A warning tells what is not rendered as in Cycles. A note tells a fault of the scene: a missing image, a node that Cycles does not know,
    faces in one place.
    """

    def __init__(self) -> None:
        self._warnings: dict[str, None] = {}
        self._notes: dict[str, None] = {}

    def warn(self, place: str, message: str) -> None:
        """Adds a warning about `place`, such as ``material "Wood"``."""
        self._warnings.setdefault(f"{place}: {message}")

    def note(self, place: str, message: str) -> None:
        """Adds a note about `place`."""
        self._notes.setdefault(f"{place}: {message}")

    @property
    def notes(self) -> list[str]:
        """All notes."""
        return list(self._notes)

    @property
    def warnings(self) -> list[str]:
        """All warnings."""
        return list(self._warnings)

    def __contains__(self, text: str) -> bool:
        return any(text in warning for warning in self._warnings)
