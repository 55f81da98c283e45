"""Bakes on several processes: the bytes of one bake even if processes die; only missing parts are baked."""

from __future__ import annotations

import json
import os
import pickle
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Program, town, write_ply
from test_bake import OPTIONS

import adumbra

pytest.importorskip("distributed", reason="dask[distributed] is not installed; pip install adumbra[farm]")

import adumbra_farm
from adumbra_farm.__main__ import _in_file_axes, code_of, main, parser
from adumbra_farm._farm import groups_of, plan_of
from adumbra_farm._tasks import Settings, bake_parts, plan_path
from distributed import Client, KilledWorker, LocalCluster

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the tests stop processes with POSIX signals")

RESOLUTION = 16384
"""At this resolution a bake takes some seconds."""


@pytest.fixture(scope="module")
def plan(city: Path) -> adumbra.Plan:
    """Return the plan of a bake that takes some seconds."""
    return adumbra.Plan(city, resolution=RESOLUTION)


@pytest.fixture(scope="module")
def whole(city: Path) -> bytes:
    """Return the file of that bake, made in one go."""
    return adumbra.bake(city, resolution=RESOLUTION).to_bytes()


@pytest.fixture(scope="module")
def small(solids: Path) -> adumbra.Plan:
    """Return the plan of a short bake."""
    return adumbra.Plan(solids, resolution=1024)


def cluster(workers: int) -> LocalCluster:
    return LocalCluster(n_workers=workers, threads_per_worker=1, memory_limit=None, dashboard_address="127.0.0.1:0")


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    """Return the client of two workers, which keep what they have loaded."""
    with cluster(2) as own, Client(own) as connected:
        yield connected


def entries(cache: Path) -> dict[Path, int]:
    """Return the entries in a folder with their inodes. An entry that is written again gets a new inode."""
    return {path: path.stat().st_ino for path in cache.glob("??/*.entry")}


def wait_until(is_so: Callable[[], bool]) -> None:
    end = time.monotonic() + 60
    while not is_so():
        assert time.monotonic() < end, "nothing happens"
        time.sleep(0.01)


@pytest.mark.slow
def test_lost_and_slow_workers_do_not_change_the_file(plan: adumbra.Plan, whole: bytes, tmp_path: Path) -> None:
    cache, output = tmp_path / "cache", tmp_path / "city.adumbra"
    total = len(plan.parts)
    ended = threading.Event()
    at_kill: dict[Path, int] = {}

    def disturb(killed: int, slowed: int) -> None:
        wait_until(lambda: len(entries(cache)) > total // 8)
        # Stop the process first, so that it writes no entry after they are counted.
        os.kill(killed, signal.SIGSTOP)
        at_kill.update(entries(cache))
        os.kill(killed, signal.SIGKILL)
        while not ended.is_set():
            os.kill(slowed, signal.SIGSTOP)
            time.sleep(0.2)
            os.kill(slowed, signal.SIGCONT)
            time.sleep(0.05)

    with cluster(4) as own, Client(own) as client:
        pids = list(client.run(os.getpid).values())
        other = threading.Thread(target=disturb, args=pids[:2])
        other.start()
        try:
            done = adumbra_farm.bake_plan(plan, output, client, cache)
        finally:
            ended.set()
            other.join()
        assert pids[0] not in client.run(os.getpid).values()
    assert output.read_bytes() == whole
    assert total // 8 < len(at_kill) < total
    at_end = entries(cache)
    assert all(at_end[path] == number for path, number in at_kill.items()), "what was done has been done again"
    # Each part has one result. Parts that were missing at the kill were baked by a task that ended.
    assert sorted(part.id for part in done.parts) == list(range(total))
    assert len(at_end) - len(at_kill) <= sum(part.baked for part in done.parts) <= total


# SIGTERM ends a run as Ctrl-C does.
@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL, signal.SIGTERM])
def test_an_interrupted_run_continues(how: signal.Signals, city: Path, whole: bytes, tmp_path: Path) -> None:
    output, cache = tmp_path / "city.adumbra", tmp_path / "entries"
    output.write_bytes(b"earlier")
    (tmp_path / "beside").write_text("mine")
    words = [sys.executable, "-m", "adumbra_farm", "bake", str(city), "-o", str(output), "--cache", str(cache), "--json"]
    words += ["--resolution", str(RESOLUTION), "--workers", "2", "--threads", "1"]
    # Ctrl-C reaches every process of a terminal.
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True, start_new_session=True) as first:
        wait_until(lambda: len(entries(cache)) > 40)
        os.killpg(first.pid, how)
        said = first.communicate(timeout=60)[1]
    if how is signal.SIGKILL:
        assert first.returncode == -signal.SIGKILL
    else:
        assert first.returncode == 130, said
        assert "interrupted" in said and "Traceback" not in said, said
    assert output.read_bytes() == b"earlier"
    before = entries(cache)
    again = json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)
    after = entries(cache)
    assert again["reused"] == len(before) and again["baked"] == len(after) - len(before) > 0
    assert all(after[path] == number for path, number in before.items())
    assert output.read_bytes() == whole
    assert (tmp_path / "beside").read_text() == "mine"
    # The cache holds only the entries and the plan, which `resume` needs.
    assert sorted(path.name for path in tmp_path.iterdir()) == ["beside", "city.adumbra", "entries"]
    assert [path.suffixes for path in cache.iterdir() if path.is_file()] == [[".plan", ".json"]]
    assert list((cache / "new").iterdir()) == []


def test_a_plan_is_resumed(small: adumbra.Plan, solids: Path, client: Client, tmp_path: Path, capsys: Any) -> None:
    path, output = tmp_path / "my plan.json", tmp_path / "out file.adumbra"
    small.write(path)
    small.bake(small.shard(0, 2), tmp_path / "my plan.cache")
    there = len(small.shard(0, 2))
    address = str(client.scheduler.address)  # type: ignore[union-attr]
    assert main(["resume", str(path), "-o", str(output), "--scheduler", address, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["reused"], said["baked"]) == (there, len(small.parts) - there)
    assert output.read_bytes() == adumbra.bake(solids, resolution=1024).to_bytes()
    assert said["file_bytes"] == output.stat().st_size


def test_workers_keep_what_they_have_loaded(small: adumbra.Plan, solids: Path, client: Client, tmp_path: Path) -> None:
    def loaded() -> dict[str, dict[str, int]]:
        return dict(client.run(_loaded))

    adumbra_farm.bake_plan(small, tmp_path / "out", client, tmp_path / "cache")
    before = loaded()
    assert all(small.digest in kept for kept in before.values()) and len(before) == 2
    shutil.rmtree(tmp_path / "cache")
    done = adumbra_farm.bake_plan(small, tmp_path / "out", client, tmp_path / "cache")
    assert sum(part.baked for part in done.parts) == len(small.parts)
    assert loaded() == before
    for resolution in (64, 128):
        plan = adumbra.Plan(solids, resolution=resolution)
        adumbra_farm.bake_plan(plan, tmp_path / "out", client, tmp_path / "cache")
    assert all(len(kept) <= 2 for kept in loaded().values())


def _loaded() -> dict[str, int]:
    """Return the plans that a worker keeps, by digest, with the addresses of their prepared scenes."""
    from adumbra_farm import _tasks

    return {digest: id(plan._baker) for digest, plan in _tasks._plans.items()}


def test_rejects_an_unwritable_output_before_baking(
    small: adumbra.Plan, solids: Path, client: Client, tmp_path: Path
) -> None:
    for output, error in [(tmp_path / "no" / "out", FileNotFoundError), (tmp_path, IsADirectoryError), (solids, ValueError)]:
        with pytest.raises(error):
            adumbra_farm.bake_plan(small, output, client, tmp_path / "cache")
    with pytest.raises(TypeError, match="the client's cluster has its own"):
        adumbra_farm.bake(solids, tmp_path / "out", client=client, workers=2, resolution=64)
    assert list(tmp_path.iterdir()) == []


def test_rejects_a_changed_scene(
    solids: Path, program: Program, client: Client, tmp_path: Path, capsys: Any
) -> None:
    scene, output, cache = tmp_path / "scene.glb", tmp_path / "out.adumbra", tmp_path / "cache"
    shutil.copy(solids, scene)
    plan = adumbra.Plan(scene, resolution=512)
    program("generate", "primitives", "--seed", "9", "-o", scene)
    with pytest.raises(adumbra.AdumbraError, match=r"scene\.glb, as worker tcp://.* has it: .* not the one that was planned"):
        adumbra_farm.bake_plan(plan, output, client, cache)
    plan.write(tmp_path / "plan.json")
    assert main(["resume", str(tmp_path / "plan.json"), "-o", str(output), "--workers", "1"]) == 3
    assert "plan the bake again" in capsys.readouterr().err
    scene.unlink()
    with pytest.raises(FileNotFoundError, match=r"worker tcp://.*every machine needs the scene under this path.*scene\.glb"):
        adumbra_farm.bake_plan(plan, output, client, cache)
    assert not output.exists() and entries(cache) == {}


def test_error_names_a_folder_that_is_not_shared(small: adumbra.Plan, client: Client, tmp_path: Path) -> None:
    settings = Settings(str(tmp_path / "elsewhere"), "0" * 64, 1, None)
    error = client.submit(bake_parts, (0,), settings, pure=False).result()
    assert isinstance(error, FileNotFoundError)
    assert "elsewhere" in str(error) and "a folder that all machines share" in str(error)
    assert not (tmp_path / "elsewhere").exists()


def test_entries_with_other_bytes_count_as_missing(small: adumbra.Plan, tmp_path: Path, capsys: Any) -> None:
    cache, output = tmp_path / "cache", tmp_path / "out"
    output.write_bytes(b"earlier")
    sums = {part.id: part.blake3 for part in small.bake(None, cache)}
    with pytest.raises(adumbra.MissingPartsError, match="1 parts of level .* are not baked, such as part 2;"):
        small.link(cache, output, sums={**sums, 2: "0" * 64})
    next(iter(entries(cache))).write_bytes(b"damaged")
    with pytest.raises(adumbra.MissingPartsError, match="bake them, then link again"):
        small.link(cache, output)
    assert output.read_bytes() == b"earlier"
    assert sum(part.baked for part in small.bake(None, cache)) == 1
    assert small.link(cache, output, sums=sums).bytes == output.stat().st_size


@pytest.mark.parametrize(("options", "words"), OPTIONS)
def test_plans_equal_those_of_the_program(
    options: dict[str, Any], words: str, program: Program, solids: Path, tmp_path: Path
) -> None:
    theirs, ours = tmp_path / "program.json", tmp_path / "python.json"
    sun = [f"--sun={','.join(repr(float(c)) for c in options['to_sun'])}"] if "to_sun" in options else []
    program("plan", solids, *words.split(), *sun, "-o", theirs)
    plan = adumbra.Plan(solids, **options)
    plan.write(ours)
    assert ours.read_bytes() == theirs.read_bytes()
    assert adumbra.Plan.read(theirs) == plan == pickle.loads(pickle.dumps(plan))


def test_the_command_line_takes_directions_and_corners_as_that_of_the_program(program: Program, tmp_path: Path) -> None:
    vertices, faces = town(2)
    scene, theirs, ours = tmp_path / "town.ply", tmp_path / "program.json", tmp_path / "python.json"
    write_ply(scene, (np.column_stack([vertices[:, 0], 0.0 - vertices[:, 2], vertices[:, 1]]), faces))
    words = ["--up", "z", "--resolution", "512", "--sun=0.2,0.9,0.1", "--bounds=2,0,3,15,20,17"]
    program("plan", scene, *words, "-o", theirs)
    given = vars(parser().parse_args(["bake", str(scene), "-o", "out", *words]))
    options = {name: given[name] for name in ("up", "resolution", "to_sun", "bounds")}
    plan_of(scene, tmp_path / "out", _in_file_axes(options)).write(ours)
    assert ours.read_bytes() == theirs.read_bytes()


def test_python_and_the_program_bake_each_others_plans(program: Program, solids: Path, tmp_path: Path) -> None:
    edits = tmp_path / "edits.json"
    edits.write_text('{"removed": [3, 7]}')
    for options in [(), ("--edit", edits)]:
        path, cache = tmp_path / f"{len(options)}.plan.json", tmp_path / f"{len(options)}.plan.cache"
        program("bake", solids, "--resolution", 4096, *options, "-o", tmp_path / "whole")
        program("plan", solids, "--resolution", 4096, *options, "-o", path)
        plan = adumbra.Plan.read(path)
        again = tmp_path / "again.json"
        plan.write(again)
        assert again.read_bytes() == path.read_bytes()
        # Python and the program each bake half of the parts, and each link the file.
        plan.bake(plan.shard(0, 2), cache)
        said = json.loads(program("tile", "--plan", again, "--cache", cache, "--json"))
        assert said["reused"] == len(plan.shard(0, 2)) and said["baked"] == len(plan.shard(1, 2))
        plan.link(cache, tmp_path / "linked")
        program("link", "--plan", again, "--cache", cache, "-o", tmp_path / "theirs")
        expected = (tmp_path / "whole").read_bytes()
        assert (tmp_path / "linked").read_bytes() == (tmp_path / "theirs").read_bytes() == expected


def test_parts_are_grouped_by_cost(plan: adumbra.Plan) -> None:
    costs = [part.cost for part in plan.parts]
    assert costs == sorted(costs, reverse=True)
    for count in (1, 7, 40, 10**6):
        groups = groups_of(plan, count)
        assert [id for group in groups for id in group] == list(range(len(costs)))
        wanted = sum(costs) / count
        totals = [sum(costs[id] for id in group) for group in groups]
        assert len(groups) <= count
        assert all(wanted <= total < wanted + costs[group[-1]] + 1 for total, group in zip(totals[:-1], groups, strict=False))


def test_stopped_bake_keeps_finished_parts(plan: adumbra.Plan, tmp_path: Path) -> None:
    def stop(done: int, total: int) -> None:
        if done > total // 2:
            raise RuntimeError(f"stopped after {done} of {total}")

    with pytest.raises(RuntimeError, match="stopped after"):
        plan.bake(None, tmp_path, progress=stop)
    there = len(entries(tmp_path))
    ids = range(len(plan.parts) // 2)
    done = plan.bake(ids, tmp_path)
    assert 0 < there < len(plan.parts)
    assert [part.id for part in done] == list(ids) and 0 < sum(not part.baked for part in done) <= there


def test_errors_name_wrong_plans_and_values(small: adumbra.Plan, solids: Path, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    small.write(path)
    text = path.read_text()
    for wrong, message in [(text[:99], "plan.json: "), (text.replace('"coded"', '"raw"'), "changed after it was written")]:
        path.write_text(wrong)
        with pytest.raises(adumbra.FormatError, match=message):
            adumbra.Plan.read(path)
    last = len(small.parts) - 1
    with pytest.raises(IndexError, match=f"0 to {last}, not part {last + 1}"):
        small.bake([last + 1], tmp_path)
    unknown: Any = {"colour": 1}
    calls: list[tuple[Callable[[], object], type[Exception], str]] = [
        (lambda: small.bake([-1], tmp_path), ValueError, "ids: -1 is out of range"),
        (lambda: small.shard(2, 2), ValueError, "index: 2 is out of range; it must be from 0 to 1"),
        (lambda: small.bake(None, tmp_path, threads=0), ValueError, "threads: 0"),
        (lambda: small.link(tmp_path, solids), ValueError, "would overwrite the scene"),
        (lambda: small.link(tmp_path / "none", tmp_path / "out"), FileNotFoundError, "none"),
        (lambda: adumbra.Plan(solids, **unknown), TypeError, "colour"),
        (lambda: adumbra.Plan(([], [])), TypeError, "a plan needs the path of a file"),  # type: ignore[arg-type]
        (lambda: adumbra_farm.bake(solids, tmp_path / "out", workers=0, resolution=64), ValueError, "workers: 0"),
        (lambda: adumbra_farm.bake(solids, solids, resolution=64), ValueError, "part of the scene"),
        (lambda: adumbra_farm.bake(solids, tmp_path / "no" / "out", resolution=64), FileNotFoundError, "no"),
    ]
    for call, error, message in calls:
        with pytest.raises(error, match=message):
            call()


def test_exit_codes_match_those_of_the_program(
    city: Path, tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT", "1s")
    output = str(tmp_path / "out.adumbra")

    def run(*words: str) -> tuple[int, str]:
        try:
            code = main([*words, "-o", output])
        except SystemExit as end:
            code = int(end.code or 0)
        return code, capsys.readouterr().err

    scene = str(city)
    for words, expected, message in [
        (["bake", scene, "--resolution", "1000"], 2, "try 1024"),
        (["bake", scene, "--bounds=1,2"], 2, "6 numbers"),
        (["bake", scene, "--workers", "0"], 2, "a number from 1"),
        (["bake", scene, "--max-memory", "much"], 2, "800MiB"),
        (["bake", scene, "--workers", "2", "--scheduler", "tcp://127.0.0.1:9"], 2, "has its own workers"),
        (["bake", str(tmp_path / "none.glb")], 3, "none.glb"),
        (["resume", scene], 3, "city.glb: "),
        (["resume", str(tmp_path / "none.json")], 3, "none.json"),
        (["bake", scene, "--max-memory", "1MiB", "--resolution", "16384"], 4, "MiB are allowed"),
    ]:
        code, said = run(*words)
        assert (code, message in said) == (expected, True), said
    assert code_of(KilledWorker("task", None, 3)) == 75  # type: ignore[arg-type]
    assert code_of(adumbra.MissingPartsError("")) == 75
    assert code_of(OSError(28, "full")) == 4
    assert code_of(KeyboardInterrupt()) == 130
    assert plan_path("folder", "ab").name == "ab.plan.json"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_missing_scheduler_exits_with_advice_to_run_again(city: Path, tmp_path: Path) -> None:
    words = [sys.executable, "-m", "adumbra_farm", "bake", str(city), "--resolution", "64", "-o", str(tmp_path / "out")]
    words += ["--scheduler", "tcp://127.0.0.1:9"]
    environment = {**os.environ, "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "1s"}
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 75 and "127.0.0.1:9" in done.stderr and "run it again" in done.stderr, done.stderr
    assert "Traceback" not in done.stderr
