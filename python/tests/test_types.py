"""The stub beside the native part, and docstrings."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import adumbra
import adumbra_farm


def test_the_stub_describes_the_native_part() -> None:
    words = [sys.executable, "-m", "mypy.stubtest", "adumbra._native"]
    done = subprocess.run(words, capture_output=True, text=True, check=False, cwd=Path(__file__).parent.parent)
    assert done.returncode == 0 and "no issues found" in done.stdout, done.stdout + done.stderr


def test_everything_public_is_documented() -> None:
    for package, name in [(package, name) for package in (adumbra, adumbra_farm) for name in package.__all__]:
        item = getattr(package, name)
        if not inspect.isclass(item) and not inspect.isfunction(item):
            continue
        assert item.__doc__, name
        for member, value in vars(item).items() if inspect.isclass(item) else ():
            if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                assert inspect.getdoc(value), f"{name}.{member}"
