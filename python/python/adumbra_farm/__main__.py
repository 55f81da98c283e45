"""The program ``adumbra-farm``: bakes on many processes or machines, with Dask."""

from __future__ import annotations

import argparse
import asyncio
import errno
import json
import os
import re
import signal
import sys
import time
import warnings
from collections.abc import Sequence
from concurrent.futures import CancelledError
from typing import Any, TextIO

import adumbra
from distributed import Client, KilledWorker
from distributed.comm.core import CommClosedError

from ._farm import bake_plan, cluster_of, plan_of

FINE, USAGE, BAD_INPUT, OUT_OF_ROOM, TRY_AGAIN, INTERRUPTED = 0, 2, 3, 4, 75, 130
"""Exit codes, the same as those of the program ``adumbra``."""

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.ENOMEM}
_AWAY = {errno.ESTALE, errno.EBUSY, errno.EHOSTUNREACH, errno.ENETUNREACH, errno.ENETDOWN}


def code_of(error: BaseException) -> int:
    """Return the exit code of an error."""
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED
    lost = (adumbra.MissingPartsError, KilledWorker, CommClosedError, ConnectionError, CancelledError, TimeoutError)
    if isinstance(error, (*lost, asyncio.TimeoutError)):
        return TRY_AGAIN
    if isinstance(error, adumbra.MemoryLimitError):
        return OUT_OF_ROOM
    if isinstance(error, OSError):
        if error.errno in _NO_ROOM:
            return OUT_OF_ROOM
        # Dask sets no errno if the scheduler does not answer.
        return TRY_AGAIN if error.errno is None or error.errno in _AWAY else BAD_INPUT
    if isinstance(error, adumbra.AdumbraError):
        return BAD_INPUT
    return USAGE


def _numbers(count: int) -> Any:
    def parse(text: str) -> tuple[float, ...]:
        values = tuple(float(part) for part in text.split(","))
        if len(values) != count:
            raise argparse.ArgumentTypeError(f"{count} numbers with commas between them are needed, not {text!r}")
        return values

    return parse


def _bytes(text: str) -> int:
    found = re.fullmatch(r"(\d+)\s*(?:([KMGT])iB|B)?", text)
    if not found:
        raise argparse.ArgumentTypeError(f"a size such as 800MiB or 2GiB is needed, not {text!r}")
    return int(found[1]) << {None: 0, "K": 10, "M": 20, "G": 30, "T": 40}[found[2]]


def _count(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 100_000:
        raise argparse.ArgumentTypeError(f"a number from 1 to 100000 is needed, not {text!r}")
    return int(text)


def _add_run(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("-o", "--output", required=True, metavar="FILE", help="the shadow file to write")
    verb.add_argument("--scheduler", metavar="ADDRESS", help="bake on the Dask cluster of this scheduler, such as tcp://host:8786")
    verb.add_argument("--workers", type=_count, metavar="N", help="without a scheduler: worker processes [default: 4, or one per core]")
    verb.add_argument("--threads", type=_count, metavar="N", help="without a scheduler: threads of each [default: cores / N]")
    verb.add_argument(
        "--cache", metavar="DIR", help="folder for what parts become, which all machines share; it stays [default: beside FILE]"
    )
    verb.add_argument(
        "--max-memory", type=_bytes, metavar="SIZE", default=argparse.SUPPRESS, help="memory that each process may hold"
    )
    verb.add_argument("--json", action="store_true", help="print one JSON object")


def _assume_ground(text: str) -> bool | None:
    """Return the value of ``auto``, ``yes`` or ``no``."""
    known = {"auto": None, "yes": True, "no": False}
    if text not in known:
        raise argparse.ArgumentTypeError(f"{text!r} must be auto, yes or no")
    return known[text]


def _add_options(verb: argparse.ArgumentParser) -> None:
    unset: Any = {"default": argparse.SUPPRESS}
    number: Any = {"type": float, **unset}
    group = verb.add_argument_group("the bake", "The options of `adumbra bake`; `adumbra bake --help` describes them.")
    group.add_argument("--sun", dest="to_sun", type=_numbers(3), metavar="X,Y,Z", **unset)
    group.add_argument("--azimuth", metavar="DEGREES", **number)
    group.add_argument("--elevation", metavar="DEGREES", **number)
    group.add_argument("--resolution", type=int, metavar="N", **unset)
    group.add_argument("--voxel-size", metavar="LENGTH", **number)
    group.add_argument("--thickness", metavar="LENGTH", **number)
    group.add_argument("--switch-within", type=int, metavar="VOXELS", **unset)
    group.add_argument("--encoding", choices=["coded", "raw"], **unset)
    group.add_argument("--levels", type=int, metavar="N", **unset)
    group.add_argument("--assume-ground", type=_assume_ground, metavar="WHEN", **unset)
    group.add_argument("--no-closed-regions", dest="closed_regions", action="store_false", **unset)
    group.add_argument("--receivers", choices=["all", "static"], **unset)
    group.add_argument("--bounds", type=_numbers(6), metavar="X0,Y0,Z0,X1,Y1,Z1", **unset)
    group.add_argument("--frame", choices=["auto", "light", "oblique"], **unset)
    group.add_argument("--yaw", metavar="DEGREES", **number)
    group.add_argument("--only", action="append", metavar="GLOB", **unset)
    group.add_argument("--exclude", action="append", metavar="GLOB", **unset)
    group.add_argument("--up", choices=["y", "z"], **unset)
    for name in ("ignore-alpha", "include-animated", "allow-outside", "strict"):
        group.add_argument(f"--{name}", action="store_true", **unset)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    reader = argparse.ArgumentParser(
        prog="adumbra-farm",
        allow_abbrev=False,
        description="Bakes on many processes or machines, with Dask. The file has the bytes of `adumbra bake`. A run that was ended "
        "continues when it is run again.",
        epilog="Exit codes: 0 done; 2 wrong arguments; 3 a file cannot be read, or is not what it should be; 4 no room; 75 something is not "
        "there yet or was lost, run it again; 130 interrupted.",
    )
    verbs = reader.add_subparsers(dest="verb", required=True, metavar="VERB")
    baking = verbs.add_parser("bake", help="bake a scene", allow_abbrev=False)
    baking.add_argument("scene", metavar="SCENE", help=".glb, .gltf, .obj or .ply; every machine must see it under this path")
    _add_run(baking)
    _add_options(baking)
    resuming = verbs.add_parser("resume", help="bake what is missing of a plan, and link it", allow_abbrev=False)
    resuming.add_argument("plan", metavar="PLAN", help="the plan, of `adumbra plan` or of an earlier run (in its cache folder)")
    _add_run(resuming)
    return reader


def _run(given: dict[str, Any]) -> None:
    start = time.perf_counter()
    verb, output, scheduler, cache = (given.pop(name) for name in ("verb", "output", "scheduler", "cache"))
    workers, threads, as_json = (given.pop(name) for name in ("workers", "threads", "json"))
    if scheduler is not None and (workers, threads) != (None, None):
        raise ValueError("--workers, --threads: a scheduler has its own workers; remove them or --scheduler")
    if verb == "bake":
        name = given.pop("scene")
        plan = plan_of(name, output, _in_file_axes(given))
        folder = os.path.splitext(output)[0] + ".cache"
    else:
        name = given.pop("plan")
        plan = adumbra.Plan.read(name)
        if os.path.exists(output) and os.path.samefile(name, output):
            raise ValueError("--output would overwrite the plan; give another path")
        folder = os.path.splitext(name)[0] + ".cache"
    client = None if scheduler is None else Client(scheduler)
    try:
        with cluster_of(client, workers, threads) as cluster:
            done = bake_plan(plan, output, cluster, cache or folder, max_memory=given.get("max_memory"))
    finally:
        if client is not None:
            client.close()
    baked = sum(part.baked for part in done.parts)
    seconds = time.perf_counter() - start
    if as_json:
        fields = {
            "file": output,
            "file_bytes": done.shadows.bytes,
            "baked": baked,
            "reused": len(done.parts) - baked,
            "tasks": done.tasks,
            "workers": done.workers,
            "bake_seconds": done.bake_seconds,
            "link_seconds": done.link_seconds,
            "seconds": seconds,
        }
        print(json.dumps(fields))
    else:
        print(
            f"{name} -> {output} ({done.shadows.bytes / 1e6:.1f} MB): {baked} parts baked, {len(done.parts) - baked} were there, "
            f"{done.tasks} tasks on {done.workers} workers, in {seconds:.1f} s"
        )


def _in_file_axes(given: dict[str, Any]) -> dict[str, Any]:
    """Return the options with directions and corners as the package takes them. The command line gives them in the world, in which
    Y points up, as that of ``adumbra`` does."""
    if given.get("up") != "z":
        return given
    turned = dict(given)
    if "to_sun" in given:
        x, y, z = given["to_sun"]
        turned["to_sun"] = (x, -z, y)
    if "bounds" in given:
        x0, y0, z0, x1, y1, z1 = given["bounds"]
        turned["bounds"] = (x0, -z1, y0, x1, -z0, y1)
    return turned


def _warn(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Print a warning as the program ``adumbra`` does, without a source line."""
    print(f"warning: {message}", file=sys.stderr)


def _terminate(_number: int, _frame: object) -> None:
    raise KeyboardInterrupt


def main(words: Sequence[str] | None = None) -> int:
    """Run the program, and return its exit code."""
    given = vars(parser().parse_args(words))
    try:
        signal.signal(signal.SIGTERM, _terminate)
        with warnings.catch_warnings():
            warnings.showwarning = _warn
            _run(given)
    except KeyboardInterrupt:
        print("adumbra-farm: interrupted; the parts that are done stay in the cache, and the same command continues", file=sys.stderr)
        return INTERRUPTED
    except (OSError, ValueError, TypeError, adumbra.AdumbraError, KilledWorker, CancelledError, asyncio.TimeoutError) as error:
        code = code_of(error)
        again = " (run it again: it bakes what is missing)" if code == TRY_AGAIN else ""
        print(f"adumbra-farm: {error}{again}", file=sys.stderr)
        return code
    return FINE


if __name__ == "__main__":
    sys.exit(main())
