"""How much memory a call needs, as Linux measures it."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path


def bytes_of(call: Callable[[], object]) -> int:
    """Run ``call`` and return the bytes that it held at its peak beyond those held before."""
    # This sets the peak to what is held now.
    Path("/proc/self/clear_refs").write_text("5")
    before = _peak_bytes()
    call()
    return _peak_bytes() - before


def _peak_bytes() -> int:
    found = re.search(r"^VmHWM:\s*(\d+) kB$", Path("/proc/self/status").read_text(), re.MULTILINE)
    assert found, "no VmHWM in /proc/self/status"
    return 1024 * int(found[1])
