"""Bakes of plans: tasks of parts on a Dask cluster, and one link at the end."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import adumbra
from adumbra._arrays import whole
from adumbra._plan import planned
from adumbra._progress import Progress, reporting
from adumbra._arrays import threads_of
from distributed import Client, LocalCluster, as_completed

from ._tasks import Settings, bake_parts, plan_path

if TYPE_CHECKING:
    from typing_extensions import Unpack

TASKS_PER_THREAD = 8
"""More tasks balance the workers' loads better; fewer tasks cost less."""

RETRIES = 2
"""How often Dask repeats a failed task. Dask repeats the tasks of lost workers in any case."""

WORKER_SECONDS = 60
"""How long a bake waits for a cluster's first worker."""

LOCAL_WORKERS = 4
"""Default number of worker processes on this machine, if it has as many cores."""


@dataclass(frozen=True)
class Farmed:
    """The result of a bake."""

    shadows: adumbra.ShadowFile
    """The file."""
    parts: tuple[adumbra.BakedPart, ...]
    """The result of each part, in the order in which tasks ended."""
    tasks: int
    """Number of tasks."""
    workers: int
    """Number of worker processes at the start."""
    bake_seconds: float
    """Time from the first task to the end of the last."""
    link_seconds: float
    """Time of the link."""


def bake(
    scene: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    client: Client | None = None,
    workers: int | None = None,
    cache: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    progress: Progress = None,
    **options: Unpack[adumbra.BakeOptions],
) -> adumbra.ShadowFile:
    """Bake the sun's shadows of a scene on many processes.

    The file has the bytes of :func:`adumbra.bake`. If a process ends early, finished parts stay in the cache,
    and the same call bakes only what is missing.

    Args:
        scene: The path of a scene.
        output: The shadow file to write. An earlier file is replaced as a whole, once the bake has succeeded.
        client: A client of the cluster to bake on. By default, worker processes on this machine that end with
            the bake.
        workers: Number of these processes: 4 unless it is given, or as many as there are cores.
        cache: Folder for the entries of the parts, which all machines share. By default, the path of
            ``output`` with the extension ``.cache``. It is created if it does not exist, and is kept.
        threads: Number of threads of each of these processes; by default the cores are divided among them.
        progress: As for :func:`adumbra.bake`, but in parts.
        **options: The options of :func:`adumbra.bake` and of the loader. ``max_memory`` applies to each
            process.

    Returns:
        The shadow file, in memory.

    Raises:
        The errors of :func:`adumbra.bake`, and ``distributed.KilledWorker`` if a task was lost with its worker several times.
    """
    plan = plan_of(scene, output, dict(options))
    folder = os.path.splitext(os.fspath(output))[0] + ".cache" if cache is None else cache
    with cluster_of(client, workers, threads) as cluster:
        return bake_plan(
            plan, output, cluster, folder, max_memory=options.get("max_memory"), progress=progress
        ).shadows


def plan_of(scene: str | os.PathLike[str], output: str | os.PathLike[str], options: dict[str, Any]) -> adumbra.Plan:
    """Plan a bake. Raise an error if its output cannot be written."""
    return adumbra.Plan._of(planned(scene, output, None, options))


@contextmanager
def cluster_of(client: Client | None, workers: int | None, threads: int | None) -> Iterator[Client]:
    """Provide the given client, or the client of new worker processes that end with it."""
    if client is not None:
        if workers is not None or threads is not None:
            raise TypeError("workers, threads: the client's cluster has its own; give them or a client")
        yield client
        return
    cores = os.cpu_count() or 1
    count = min(LOCAL_WORKERS, cores) if workers is None else whole("workers", workers, 1, 1024)
    each = threads_of(threads) or max(1, cores // count)
    with (
        LocalCluster(
            n_workers=count,
            threads_per_worker=each,
            processes=True,
            # The bake has its own memory limit.
            memory_limit=None,
            dashboard_address="127.0.0.1:0",
            preload=bake_parts.__module__,
            silence_logs=logging.CRITICAL,
        ) as cluster,
        Client(cluster) as own,
    ):
        yield own


def bake_plan(
    plan: adumbra.Plan,
    output: str | os.PathLike[str],
    client: Client,
    cache: str | os.PathLike[str],
    *,
    max_memory: int | None = None,
    progress: Progress = None,
) -> Farmed:
    """Bake the parts of a plan on a cluster, and link them.

    Args:
        plan: The plan.
        output: The shadow file to write.
        client: A client of the cluster.
        cache: The folder that all machines share. The plan is written there too, for the workers and for a later call.
        max_memory: Largest number of bytes that each process may hold.
        progress: As for :func:`adumbra.bake`, but in parts.

    Returns:
        The file, and the result of each part.

    Raises:
        The errors of :meth:`adumbra.Plan.bake` and :meth:`adumbra.Plan.link`, and ``distributed.KilledWorker`` if a task was lost
        with its worker several times.
    """
    plan._native.check_path(os.fspath(output))
    folder = os.path.abspath(cache)
    os.makedirs(folder, exist_ok=True)
    plan.write(plan_path(folder, plan.digest))
    settings = Settings(folder, plan.digest, 1, max_memory)
    client.wait_for_workers(1, timeout=WORKER_SECONDS)
    threads = client.nthreads()
    groups = groups_of(plan, TASKS_PER_THREAD * max(1, sum(threads.values())))
    start = time.perf_counter()
    parts = _baked(client, groups, settings, progress)
    end = time.perf_counter()
    sums = {part.id: part.blake3 for part in parts}
    shadows = plan.link(folder, output, sums=sums, max_memory=max_memory)
    return Farmed(shadows, tuple(parts), len(groups), len(threads), end - start, time.perf_counter() - end)


def groups_of(plan: adumbra.Plan, count: int) -> list[tuple[int, ...]]:
    """Group the parts into about ``count`` tasks of about equal cost, those with the most costly parts first."""
    parts = plan.parts
    wanted = sum(part.cost for part in parts) / count
    groups: list[tuple[int, ...]] = []
    ids: list[int] = []
    cost = 0
    for part in parts:
        ids.append(part.id)
        cost += part.cost
        if cost >= wanted:
            groups.append(tuple(ids))
            ids, cost = [], 0
    return [*groups, tuple(ids)] if ids else groups


def _baked(
    client: Client, groups: Sequence[tuple[int, ...]], settings: Settings, progress: Progress
) -> list[adumbra.BakedPart]:
    """Run all tasks. If this ends early for any reason, cancel the unfinished ones."""
    name = f"adumbra-{settings.digest[:8]}-{uuid4().hex[:8]}"
    keys = [f"{name}-{number}" for number in range(len(groups))]
    futures = client.map(bake_parts, groups, settings=settings, key=keys, retries=RETRIES, pure=False)
    ids_of = dict(zip(keys, groups, strict=True))
    total = sum(map(len, groups))
    parts: list[adumbra.BakedPart] = []
    try:
        with reporting(progress, "part") as report:
            for future, result in as_completed(futures, with_results=True):
                if isinstance(result, Exception):
                    raise result
                if [part.id for part in result] != list(ids_of[future.key]):
                    raise adumbra.AdumbraError(f"the task {future.key} has not answered for the parts that it was given")
                parts.extend(result)
                if report is not None:
                    report(len(parts), total)
    finally:
        client.cancel(futures)
    return parts
