"""The command `lodestar`, also as `python -m lodestar`."""

import signal
import sys

from ._lodestar import run_command


def main() -> None:
    """Runs the command line and ends the program with its exit code."""
    # The command handles Ctrl-C itself: it ends a render with the picture so far.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run_command(["lodestar", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
