"""The tasks of a worker: they bake parts of a plan, which is read from the cache folder."""

from __future__ import annotations

import os
import signal
import socket
import threading
from collections import OrderedDict
from pathlib import Path
from typing import Any, NamedTuple

import adumbra
from distributed import Worker, get_worker

KEPT = 2
"""Number of plans that a worker process keeps, each with its scene."""

_lock = threading.Lock()
_plans: OrderedDict[str, adumbra.Plan] = OrderedDict()


class Settings(NamedTuple):
    """The settings that all tasks of a bake share."""

    cache: str
    """The folder of the cache, which also holds the plan."""
    digest: str
    """The digest of the plan."""
    threads: int
    """Number of threads of a task."""
    max_memory: int | None
    """Largest number of bytes that a worker may hold."""


def dask_setup(_worker: Worker) -> None:
    """Ignore Ctrl-C, which the parent process handles. Dask calls this in workers that a bake starts."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def plan_path(cache: str, digest: str) -> Path:
    """Return the path of the plan in the cache folder."""
    return Path(cache) / f"{digest}.plan.json"


def bake_parts(ids: tuple[int, ...], settings: Settings) -> list[adumbra.BakedPart] | Exception:
    """Bake parts. Return an error that every attempt would repeat, so that Dask does not retry."""
    try:
        plan = _plan(settings)
        try:
            return plan.bake(
                ids,
                settings.cache,
                max_memory=settings.max_memory,
                threads=settings.threads,
                progress=_stop_if_cancelled(),
            )
        except OSError as error:
            raise _named(error) from None
        except adumbra.AdumbraError as error:
            raise type(error)(f"{plan.scene}, as {_here()} has it: {error}") from None
    except (OSError, adumbra.AdumbraError, ValueError) as error:
        # A network or a disk may work again at the next attempt, but a missing file stays missing.
        if isinstance(error, OSError) and not isinstance(error, (FileNotFoundError, PermissionError)):
            raise
        return error


def _plan(settings: Settings) -> adumbra.Plan:
    """Return the plan, with the scene that earlier tasks have prepared."""
    with _lock:
        if settings.digest in _plans:
            _plans.move_to_end(settings.digest)
            return _plans[settings.digest]
        path = plan_path(settings.cache, settings.digest)
        try:
            plan = adumbra.Plan.read(path)
        except FileNotFoundError:
            what = f"{_here()} does not see the cache folder of this bake; give a folder that all machines share (--cache)"
            raise FileNotFoundError(2, what, str(path)) from None
        _plans[settings.digest] = plan
        while len(_plans) > KEPT:
            _plans.popitem(last=False)
        return plan


def _stop_if_cancelled() -> Any:
    """Return a report function that stops the task within a root block once its result is not needed."""
    try:
        worker = get_worker()
    except ValueError:
        return False
    key = worker.get_current_task()

    def report(_done: int, _total: int) -> None:
        task = worker.state.tasks.get(key)
        if task is None or task.state == "cancelled":
            raise InterruptedError(f"{key} was cancelled")

    return report


def _named(error: OSError) -> OSError:
    """Return an error that names the machine on which it occurred."""
    hint = "; every machine needs the scene under this path" if isinstance(error, FileNotFoundError) else ""
    return type(error)(error.errno, f"{_here()} {error.strerror}{hint}", error.filename)


def _here() -> str:
    try:
        return f"worker {get_worker().address} on {socket.gethostname()}"
    except ValueError:
        return f"process {os.getpid()}"
