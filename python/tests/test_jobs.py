"""The jobs that ``adumbra plan --export`` writes, run by their schedulers, give the bytes of one bake."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import Program

import adumbra

pytestmark = pytest.mark.slow

ODD = """a 'b' "c" $HOME `d` \\ e {{Param.Plan}} @PLAN@ ü"""
"""A folder's name with all characters that a shell, YAML or a template would interpret."""

NODE = Path(__file__).parent / "slurm_single_node.sh"


def missing(what: str) -> None:
    """Skip a test because a tool is missing, or fail if the tools are required."""
    if os.environ.get("ADUMBRA_REQUIRE_TOOLS"):
        pytest.fail(what)
    pytest.skip(what)


def run(words: list[str | Path], folder: Path, **variables: str) -> str:
    done = subprocess.run(
        words,
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
        env={**os.environ, **variables},
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.fixture
def scene(city: Path, tmp_path: Path) -> Path:
    """Return a scene in a folder with an odd name."""
    path = tmp_path / ODD / "my city.glb"
    path.parent.mkdir()
    shutil.copy(city, path)
    return path


def openjd() -> Path:
    """Return the program ``openjd``, which is installed beside Python."""
    found = shutil.which("openjd", path=os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")]))
    if found is None:
        missing("openjd is not installed; pip install openjd-cli")
    return Path(str(found))


def test_openjd_bakes_the_job(program: Program, scene: Path) -> None:
    command = openjd()
    program("plan", scene, "--resolution", 2048, "--export", "openjd", "--shards", 3, "--threads", 1)
    job = scene.with_name("my city.plan.yaml")
    assert "my city.plan.json" in job.read_text(encoding="utf-8")
    run([command, "check", job], scene.parent)
    said = run([command, "run", job], scene.parent)
    assert said.count(" were there") == 3, said
    assert scene.with_suffix(".adumbra").read_bytes() == adumbra.bake(scene, resolution=2048).to_bytes()
    # A second run bakes nothing.
    said = run([command, "run", job], scene.parent)
    assert said.count(": 0 parts in ") == 3, said


def test_openjd_ends_with_an_error_if_a_task_fails(program: Program, scene: Path) -> None:
    command = openjd()
    program("plan", scene, "--resolution", 512, "--export", "openjd", "--shards", 2)
    scene.write_bytes(b"not a scene")
    done = subprocess.run(
        [command, "run", scene.with_name("my city.plan.yaml")], capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode != 0 and "my city.glb" in done.stdout + done.stderr
    assert not scene.with_suffix(".adumbra").exists()


@pytest.fixture(scope="module")
def slurm() -> Iterator[str]:
    """Return the configuration of a cluster of one node."""
    # Use a short path, because the names of sockets are limited in length.
    folder = tempfile.mkdtemp(prefix="slurm")
    up = subprocess.run(["bash", NODE, "up", folder], capture_output=True, text=True, check=False, timeout=120)
    if up.returncode == 77:
        missing(f"{up.stderr.strip()}; apt-get install slurmctld slurmd munge slurm-client")
    assert up.returncode == 0, up.stderr
    yield f"{folder}/etc/slurm.conf"
    subprocess.run(["bash", NODE, "down", folder], check=True, timeout=120)
    shutil.rmtree(folder)


@pytest.fixture
def logs(tmp_path: Path) -> Path:
    """Return the folder to submit jobs from. Slurm does not expand log names in a path with a backslash."""
    path = tmp_path / "logs of 'a' job"
    path.mkdir()
    return path


def test_slurm_bakes_the_job(slurm: str, program: Program, scene: Path, logs: Path) -> None:
    program("plan", scene, "--resolution", 2048, "--export", "slurm", "--shards", 3, "--threads", 1)
    job = scene.with_name("my city.plan.slurm.sh")
    said = run(["sh", job, "--wait"], logs, SLURM_CONF=slurm)
    assert "3 shards" in said and "link: job" in said, said
    assert scene.with_suffix(".adumbra").read_bytes() == adumbra.bake(scene, resolution=2048).to_bytes()
    tiles = [path.read_text() for path in logs.glob("adumbra-tile-*.log")]
    assert len(tiles) == 3 and all(" 0 were there" in text for text in tiles), tiles
    # A second run bakes nothing.
    before = set(logs.iterdir())
    run(["sh", job, "--wait"], logs, SLURM_CONF=slurm)
    again = [path.read_text() for path in set(logs.glob("adumbra-tile-*.log")) - before]
    assert len(again) == 3 and all(": 0 parts in " in text for text in again), again


def test_slurm_ends_with_an_error_if_a_task_fails(slurm: str, program: Program, scene: Path, logs: Path) -> None:
    program("plan", scene, "--resolution", 512, "--export", "slurm", "--shards", 2)
    scene.write_bytes(b"not a scene")
    done = subprocess.run(
        ["sh", scene.with_name("my city.plan.slurm.sh"), "--wait"],
        capture_output=True,
        text=True,
        check=False,
        cwd=logs,
        env={**os.environ, "SLURM_CONF": slurm},
        timeout=300,
    )
    assert done.returncode != 0 and "a tile failed" in done.stderr, done.stdout + done.stderr
    assert not scene.with_suffix(".adumbra").exists()
    assert any("my city.glb" in path.read_text() for path in logs.glob("adumbra-tile-*.log"))
