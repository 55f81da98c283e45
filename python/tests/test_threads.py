"""Threads and signals: the interpreter's lock, Ctrl-C, progress, and forked processes."""

from __future__ import annotations

import builtins
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import SUN, Mesh, points_of, town

import adumbra


@pytest.fixture(scope="module")
def large() -> adumbra.Scene:
    """Return a scene that takes seconds to bake."""
    return adumbra.Scene.from_arrays(*town(60), up="y")


def signals_handled_during(work: Callable[[], object], most: int) -> int:
    """Run ``work`` and return how many signals Python handled meanwhile. The last of ``most`` is like Ctrl-C.

    Each is sent by another thread once the one before has been handled. Both happen only if the other thread runs during the
    work, and if the work lets Python look for signals.
    """
    handled, ended = threading.Semaphore(0), threading.Event()
    count = 0

    def handle(*_: object) -> None:
        nonlocal count
        count += not ended.is_set()
        handled.release()
        if count == most:
            raise KeyboardInterrupt

    def send() -> None:
        for _ in range(most):
            if ended.wait(0.05):
                return
            os.kill(os.getpid(), signal.SIGINT)
            handled.acquire()

    sender = threading.Thread(target=send)
    before = signal.signal(signal.SIGINT, handle)
    try:
        sender.start()
        with pytest.raises(KeyboardInterrupt):
            work()
    finally:
        ended.set()
        sender.join()
        signal.signal(signal.SIGINT, before)
    return count


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent as POSIX does")
def test_other_threads_run_during_long_work_and_ctrl_c_stops_it(
    mesh: Mesh, scene: adumbra.Scene, large: adumbra.Scene, tmp_path: Path
) -> None:
    output = tmp_path / "town.adumbra"
    output.write_bytes(b"earlier")
    points, _ = points_of(mesh, 1_000_000)
    suns = adumbra.sun_direction(np.arange(0.0, 360.0, 3), 30, up="y")
    shadows = adumbra.bake(large, resolution=1024)
    many = np.resize(points.astype(np.float32), (20_000_000, 3))
    works: list[Callable[[], object]] = [
        lambda: adumbra.bake(large, resolution=131072, output=output),
        lambda: scene.sunlit(points, None, suns),
        lambda: scene.visibility(points, None, suns),
        lambda: shadows.visibility(many, filter=17),
        lambda: shadows.verify(large, samples=100_000_000),
    ]
    for work in works:
        assert signals_handled_during(work, 3) == 3
    assert output.read_bytes() == b"earlier"
    assert os.listdir(tmp_path) == ["town.adumbra"]


def test_progress_is_reported_on_the_calling_thread(large: adumbra.Scene) -> None:
    reports: list[tuple[int, int]] = []
    threads = set()

    def report(done: int, total: int) -> None:
        reports.append((done, total))
        threads.add(threading.get_ident())

    adumbra.bake(large, resolution=2048, progress=report)
    assert threads == {threading.get_ident()}
    assert reports == sorted(reports) and len({total for _, total in reports}) == 1
    assert reports[-1][0] == reports[-1][1] > 1


def test_progress_bars_are_shown_only_when_wanted(
    scene: adumbra.Scene, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("tqdm")

    def shown(progress: Any) -> bool:
        adumbra.bake(scene, resolution=64, progress=progress)
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
        adumbra.bake(scene, resolution=64, progress=True)


def test_threads_can_share_a_file_and_a_scene(mesh: Mesh, scene: adumbra.Scene, shadows: adumbra.ShadowFile) -> None:
    points, normals = points_of(mesh, 50_000)
    baked, lit = shadows.visibility(points, normals), scene.sunlit(points, normals, SUN)
    # Rays through this scene have to be prepared first.
    fresh = adumbra.Scene.from_arrays(*mesh, up="y")
    found: list[bool] = []

    def ask() -> None:
        found.append(np.array_equal(fresh.sunlit(points, normals, SUN), lit))
        found.append(np.array_equal(shadows.visibility(points, normals), baked))

    threads = [threading.Thread(target=ask) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [True] * 16


def _answer(connection: Any, scene: adumbra.Scene, shadows: adumbra.ShadowFile, points: Any) -> None:
    connection.send(float(shadows.visibility(points).sum()))
    connection.send(int(scene.sunlit(points, None, SUN).sum()))
    connection.send(_village().bytes)


def _village() -> adumbra.ShadowFile:
    return adumbra.bake(adumbra.Scene.from_arrays(*town(2), up="y"), resolution=64)


@pytest.mark.parametrize("how", multiprocessing.get_all_start_methods())
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_processes_start_their_own_threads(
    how: str, mesh: Mesh, scene: adumbra.Scene, shadows: adumbra.ShadowFile
) -> None:
    points, _ = points_of(mesh, 50_000)
    expected = [float(shadows.visibility(points).sum()), int(scene.sunlit(points, None, SUN).sum()), _village().bytes]
    context = multiprocessing.get_context(how)
    ours, theirs = context.Pipe()
    child: Any = context.Process(target=_answer, args=(theirs, scene, shadows, points))  # type: ignore[attr-defined]
    child.start()
    for value in expected:
        assert ours.poll(60), "the process does not answer"
        assert ours.recv() == value
    child.join(60)
    assert child.exitcode == 0
