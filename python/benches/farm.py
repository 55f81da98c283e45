"""Times bakes on worker processes of this machine: what a task costs, and what a second worker gains.

    adumbra generate city -o city.glb
    python benches/farm.py city.glb SCENE --resolution 32768

Workers have one thread each. Each bake has a cache of its own, so that it makes everything. The first row of a cluster begins with
workers that have loaded nothing; for the second they keep what they have loaded. The cost of a task is that of a bake with a task
for each part less that of one with a single task, on one worker, divided by the tasks. It is measured on the first scene, at 4096.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import adumbra
from adumbra_farm import bake_plan
from adumbra_farm._farm import _baked, cluster_of
from adumbra_farm._tasks import Settings, plan_path
from distributed import Client


def seconds(client: Client, plan: adumbra.Plan, groups: list[tuple[int, ...]]) -> float:
    """Return the time of a bake in these tasks, with a separate cache."""
    with tempfile.TemporaryDirectory() as cache:
        plan.write(plan_path(cache, plan.digest))
        start = time.perf_counter()
        _baked(client, groups, Settings(cache, plan.digest, 1, None), progress=False)
        return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("small", type=Path)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--resolution", type=int, default=32768)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    options = parser.parse_args()
    small = adumbra.Plan(options.small, resolution=4096)
    with cluster_of(None, 1, 1) as client:
        ids = [part.id for part in small.parts]
        seconds(client, small, [tuple(ids)])
        one = min(seconds(client, small, [tuple(ids)]) for _ in range(5))
        many = min(seconds(client, small, [(id,) for id in ids]) for _ in range(5))
    print(f"a task: {1000 * (many - one) / (len(ids) - 1):.1f} ms ({len(ids)} tasks {many:.2f} s, one {one:.2f} s)", flush=True)
    plan = adumbra.Plan(options.scene, resolution=options.resolution)
    first: list[float] = []
    for workers in options.workers:
        with cluster_of(None, workers, 1) as client, tempfile.TemporaryDirectory() as folder:
            times = []
            for name in ("cold", "warm"):
                done = bake_plan(plan, Path(folder) / "out", client, Path(folder) / name, progress=False)
                times.append(done.bake_seconds)
        first = first or times
        print(
            f"{workers} workers, {len(plan.parts)} parts, {done.tasks} tasks: {times[0]:.1f} s ({first[0] / times[0]:.2f} x), "
            f"warm {times[1]:.1f} s ({first[1] / times[1]:.2f} x), link {done.link_seconds:.1f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
