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

from . import exr

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


# Exit codes of renders that a signal has ended: they have their picture.
STOPPED = (130, 143)


class Process:
    """A render by a program of its own, which writes its picture into a file."""

    def __init__(self, program: str, arguments: list[str], folder: Path, picture: str, environment: dict[str, str] | None = None) -> None:
        self._path = folder / picture
        self._path.unlink(missing_ok=True)
        self._messages: list[str] = []
        flags = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)
        self._process = subprocess.Popen(
            [program, *arguments],
            cwd=folder,
            env=environment,
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
            if event.get("message") and event.get("event") in ("text", "end"):
                self._messages.append(str(event["message"]))
            if event.get("event") == "written" and self._path.exists():
                event["picture"] = exr.read(self._path)
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
    def failure(self) -> str | None:
        """Why the program has failed; None where it has not."""
        code = self._process.poll()
        if code in (0, None, *STOPPED):
            return None
        return self._messages[-1] if self._messages else f"the program ended with the code {code}"

    def picture(self) -> exr.Picture | None:
        """The last picture; None where there is none."""
        return exr.read(self._path) if self._path.exists() else None
