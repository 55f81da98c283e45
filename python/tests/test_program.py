"""The program that comes with the package: its answers, exit codes and jobs."""

from __future__ import annotations

import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
from conftest import SUN, Program

import adumbra

INSTALLED = Path(sysconfig.get_path("scripts")) / ("adumbra.exe" if sys.platform == "win32" else "adumbra")


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Run the installed program."""
    return subprocess.run([str(INSTALLED), *map(str, arguments)], capture_output=True, text=True, check=False)


def test_it_bakes_the_bytes_of_the_package_and_of_the_program(program: Program, solids: Path, tmp_path: Path) -> None:
    sun = "--sun=" + ",".join(map(str, SUN))
    done = run("bake", solids, sun, "--resolution", 512, "-o", tmp_path / "installed.adumbra")
    assert done.returncode == 0, done.stderr
    program("bake", solids, sun, "--resolution", 512, "-o", tmp_path / "program.adumbra")
    baked = (tmp_path / "installed.adumbra").read_bytes()
    assert baked == (tmp_path / "program.adumbra").read_bytes()
    assert baked == adumbra.bake(solids, to_sun=SUN, resolution=512).to_bytes()
    assert run("info", tmp_path / "installed.adumbra", "--json").stdout == program("info", tmp_path / "installed.adumbra", "--json")


def test_it_ends_with_the_exit_codes_of_the_program(tmp_path: Path) -> None:
    assert run("--help").returncode == 0 and "Usage: adumbra" in run("--help").stdout
    wrong: list[tuple[list[object], int, str]] = [
        (["bake", tmp_path / "none.glb", "-o", tmp_path / "out"], 3, "none.glb"),
        (["bake"], 2, "Usage: adumbra bake"),
    ]
    for words, code, said in wrong:
        done = run(*words)
        assert done.returncode == code and said in done.stderr and "Traceback" not in done.stderr, done


@pytest.mark.skipif(sys.platform == "win32", reason="jobs are run by POSIX programs")
def test_its_jobs_run_it_again(solids: Path, tmp_path: Path) -> None:
    if shutil.which("make") is None:
        pytest.skip("make is not installed")
    output = tmp_path / "solids.adumbra"
    words = ["--resolution", 512, "--export", "make", "--shards", 2, "--shadow-file", output]
    done = run("plan", solids, *words, "-o", tmp_path / "solids.plan.json")
    assert done.returncode == 0, done.stderr
    (job,) = (path for path in tmp_path.iterdir() if str(INSTALLED) in path.read_text(encoding="utf-8"))
    made = subprocess.run(["make", "-f", job], capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stdout + made.stderr
    assert output.read_bytes() == adumbra.bake(solids, resolution=512).to_bytes()
