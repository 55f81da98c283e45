"""The program ``adumbra``, without what draws on a GPU and without remote stores."""

from __future__ import annotations

import signal
import sys

from . import _native


def main() -> int:
    """Run the program with the process's arguments, and return its exit code."""
    # The program has its own way to end when it is interrupted.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.run_program(sys.argv[0], sys.argv[1:])
