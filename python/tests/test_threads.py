"""Threads and signals: the interpreter's lock, Ctrl-C, progress, and forked processes."""

from __future__ import annotations

import builtins
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Mesh, points_of, town

import adumbra


@pytest.fixture(scope="module")
def large() -> adumbra.Scene:
    """Return a scene that takes seconds to bake."""
    return adumbra.Scene.from_mesh(*town(150))


def longest_pause(work: Callable[[], object]) -> tuple[float, float]:
    """Return how long ``work`` takes, and the longest wait of another thread meanwhile, in seconds."""
    pauses = []
    ended = threading.Event()

    def count() -> None:
        last = time.perf_counter()
        while not ended.is_set():
            time.sleep(0.001)
            now = time.perf_counter()
            pauses.append(now - last)
            last = now

    other = threading.Thread(target=count)
    other.start()
    start = time.perf_counter()
    work()
    taken = time.perf_counter() - start
    ended.set()
    other.join()
    return taken, max(pauses)


def test_other_threads_run_meanwhile(mesh: Mesh, shadows: adumbra.ShadowFile, large: adumbra.Scene) -> None:
    points, _ = points_of(mesh, 1_500_000)
    tracer = adumbra.rays(*mesh)
    works: list[Callable[[], object]] = [
        lambda: adumbra.bake(large, resolution=8192),
        lambda: shadows.visibility(points, filter=17),
        lambda: tracer.visibility(points, adumbra.sun_direction([10, 80], [30, 40])),
        lambda: shadows.verify(mesh, samples=150_000),
    ]
    for work in works:
        taken, pause = longest_pause(work)
        assert taken > 0.1
        assert pause < taken / 2


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent as POSIX does")
def test_ctrl_c_stops_long_work(mesh: Mesh, large: adumbra.Scene, tmp_path: Path) -> None:
    output = tmp_path / "town.adumbra"
    output.write_bytes(b"earlier")
    points, _ = points_of(mesh, 3_000_000)
    tracer, suns = adumbra.rays(*mesh), adumbra.sun_direction(np.arange(0.0, 360.0, 3), 30)
    shadows = adumbra.bake(large, resolution=2048)
    many = np.resize(points, (30_000_000, 3))
    works: list[Callable[[], object]] = [
        lambda: adumbra.bake(large, resolution=131072, output=output),
        lambda: tracer.visibility(points, suns),
        lambda: shadows.visibility(many, filter=17),
    ]
    for work in works:
        sent: list[float] = []

        def interrupt(sent: list[float] = sent) -> None:
            sent.append(time.perf_counter())
            os.kill(os.getpid(), signal.SIGINT)

        timer = threading.Timer(1.0, interrupt)
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            work()
        assert time.perf_counter() - sent[0] < 1.5
        timer.join()
    assert output.read_bytes() == b"earlier"
    assert os.listdir(tmp_path) == ["town.adumbra"]


def test_progress_is_reported_on_the_calling_thread(large: adumbra.Scene) -> None:
    told: list[tuple[int, int]] = []
    threads = set()

    def report(done: int, total: int) -> None:
        told.append((done, total))
        threads.add(threading.get_ident())

    adumbra.bake(large, resolution=8192, progress=report)
    assert threads == {threading.get_ident()}
    assert told == sorted(told) and len({total for _, total in told}) == 1
    assert told[-1][0] == told[-1][1] > 1


def test_progress_bars_are_shown_only_when_wanted(
    mesh: Mesh, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def shown(progress: Any) -> bool:
        adumbra.bake(*mesh, resolution=64, progress=progress)
        return "bake" in capfd.readouterr().err

    assert [shown(None), shown(False), shown(True)] == [False, False, True]
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert [shown(None), shown(False), shown(True)] == [True, False, True]
    real = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name.startswith("tqdm"):
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    assert [shown(None), shown(False)] == [False, False]
    with pytest.raises(ImportError, match="pip install tqdm"):
        adumbra.bake(*mesh, resolution=64, progress=True)


def test_threads_can_share_a_file(mesh: Mesh, shadows: adumbra.ShadowFile) -> None:
    points, normals = points_of(mesh, 50_000)
    expected = shadows.visibility(points, normals)
    found: list[bool] = []
    threads = [
        threading.Thread(target=lambda: found.append(np.array_equal(shadows.visibility(points, normals), expected)))
        for _ in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [True] * 8


def _answer(connection: Any, shadows: adumbra.ShadowFile, points: Any) -> None:
    connection.send(float(shadows.visibility(points).sum()))
    connection.send(adumbra.bake(*town(2), resolution=64).bytes)


@pytest.mark.skipif(sys.platform == "win32", reason="there is no fork")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_forked_processes_start_their_own_threads(mesh: Mesh, shadows: adumbra.ShadowFile) -> None:
    points, _ = points_of(mesh, 50_000)
    expected = float(shadows.visibility(points).sum())
    fork = multiprocessing.get_context("fork")
    ours, theirs = fork.Pipe()
    child = fork.Process(target=_answer, args=(theirs, shadows, points))
    child.start()
    assert ours.poll(60), "the forked process does not answer"
    assert ours.recv() == expected
    assert ours.poll(60) and ours.recv() == adumbra.bake(*town(2), resolution=64).bytes
    child.join(60)
    assert child.exitcode == 0
