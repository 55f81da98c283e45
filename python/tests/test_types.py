"""Types: the package and its tests under mypy, the stub beside the native part, and docstrings."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import adumbra
import adumbra_farm

ROOT = Path(__file__).parent.parent


def run(*arguments: str) -> str:
    done = subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_types_pass_mypy() -> None:
    # Beside the packages that are checked, so that a later run checks only what has changed.
    strict = ("mypy", "--strict", "--cache-dir", str(Path(sys.prefix) / "mypy"))
    assert "no issues found" in run(*strict, "--package", "adumbra", "--package", "adumbra_farm")
    assert "no issues found" in run(*strict, "tests", "benches")


def test_the_stub_describes_the_native_part() -> None:
    assert "no issues found" in run("mypy.stubtest", "adumbra._native")


def test_everything_public_is_documented() -> None:
    for package, name in [(package, name) for package in (adumbra, adumbra_farm) for name in package.__all__]:
        item = getattr(package, name)
        if not inspect.isclass(item) and not inspect.isfunction(item):
            continue
        assert item.__doc__, name
        for member, value in vars(item).items() if inspect.isclass(item) else ():
            if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                assert inspect.getdoc(value), f"{name}.{member}"
