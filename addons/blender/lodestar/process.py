"""Process: runs the program `lodestar`, follows its log, and ends it so that the picture so far is kept."""

from __future__ import annotations

import json
import os
import queue
import shutil
import signal
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

Event = dict[str, Any]


def find(preferred: str) -> str:
    """Path of the program: the preferred one, or the one in PATH. A FileNotFoundError says what to do."""
    name = preferred.strip() or "lodestar"
    found = shutil.which(os.path.expanduser(name))
    if found is None:
        raise FileNotFoundError(f"the program `{name}` was not found; set its path in the add-on's preferences")
    return found


def _as_event(line: str) -> Event:
    """Event of a line of the log. A line that is no JSON is the text of an error or a warning of the system."""
    try:
        event = json.loads(line)
    except ValueError:
        return {"event": "text", "message": line}
    return event if isinstance(event, dict) else {"event": "text", "message": line}


class Process:
    """A render that runs."""

    def __init__(self, program: str, arguments: list[str], folder: Path) -> None:
        flags = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)
        self._process = subprocess.Popen(
            [program, *arguments],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="replace",
            creationflags=flags,
        )
        self._events: queue.Queue[Event | None] = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            if line.strip():
                self._events.put(_as_event(line.strip()))
        self._events.put(None)

    def events(self, patience: float = 0.1) -> Iterator[Event | None]:
        """Events until the program ends; None whenever `patience` seconds have passed without one."""
        while True:
            try:
                event = self._events.get(timeout=patience)
            except queue.Empty:
                yield None
                continue
            if event is None:
                self._process.wait()
                return
            yield event

    def stop(self) -> None:
        """Ends the render as Ctrl-C does: the program writes the picture so far."""
        if self._process.poll() is None:
            self._process.send_signal(getattr(signal, "CTRL_BREAK_EVENT", signal.SIGINT))

    def close(self) -> None:
        """Kills the program if it still runs."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()

    @property
    def exit_code(self) -> int | None:
        """Exit code; None while the program runs."""
        return self._process.poll()
