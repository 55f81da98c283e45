"""Measures what bakes need beside the program's, and how soon Ctrl-C ends long calls.

    python benches/bakes.py SCENE ADUMBRA

ADUMBRA is the program. The memory is the peak of a process that bakes the scene: the program, and a Python that does nothing
else. Each long call is interrupted once, half a second after it began.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import adumbra

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from conftest import DAY, points_of  # noqa: E402

BAKE = "import sys, adumbra; adumbra.bake(sys.argv[1], resolution=int(sys.argv[2]), progress=False).save(sys.argv[3])"


PEAK = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
print(1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


def peak_bytes(*words: str | Path) -> int:
    """Return the peak memory of a process."""
    # Linux counts the memory of the process that starts another as the other's, so a small one does.
    done = subprocess.run([sys.executable, "-S", "-c", PEAK, *words], capture_output=True, text=True, check=True)
    return int(done.stdout)


def seconds_to_end(call: Callable[[], object]) -> float:
    """Return the seconds from Ctrl-C to the end of ``call``."""
    sent = 0.0

    def interrupt() -> None:
        nonlocal sent
        sent = time.perf_counter()
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, interrupt)
    timer.start()
    try:
        call()
    except KeyboardInterrupt:
        return time.perf_counter() - sent
    timer.cancel()
    raise AssertionError("the call ended by itself")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("program", type=Path)
    parser.add_argument("--resolution", type=int, default=32768)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "baked.adumbra"
        resolution = str(options.resolution)
        program = peak_bytes(options.program, "bake", options.scene, "-o", output, "--resolution", resolution)
        python = peak_bytes(sys.executable, "-c", BAKE, options.scene, resolution, output)
        bare = peak_bytes(sys.executable, "-c", "import adumbra")
        print(f"bake: the program {program:,} bytes, Python {python:,}, of which a Python that imports adumbra has {bare:,}")

        scene = adumbra.Scene(options.scene)
        shadows = adumbra.bake(scene, progress=False)
        points, normals = points_of(scene.mesh(), 10_000_000)
        many = np.tile(points, (4, 1))
        heights = np.random.default_rng(1).random((6000, 6000))
        times = np.arange(0, 20_000_000).astype("datetime64[s]")
        cache = Path(folder) / "cache"
        calls: list[tuple[str, Callable[[], object]]] = [
            ("bake", lambda: adumbra.bake(scene, resolution=131072, progress=False)),
            ("bake with a cache", lambda: adumbra.bake(scene, resolution=131072, cache=cache, progress=False)),
            ("sunlit", lambda: scene.sunlit(many, None, scene.to_sun)),
            ("visibility", lambda: scene.visibility(points, normals, scene.to_sun)),
            ("sun_hours", lambda: adumbra.sun_hours(scene, points, normals, **DAY)),
            ("sky", lambda: adumbra.sky(scene, points, normals)),
            ("look-ups", lambda: shadows.visibility(many)),
            ("from_heights", lambda: adumbra.Scene.from_heights(heights, 1.0, walls=True)),
            ("SunPath", lambda: adumbra.SunPath(lat=48.0, lon=11.0, times=times, tz="UTC")),
            ("bake_path", lambda: adumbra.bake_path(scene, **DAY, resolution=32768)),
        ]
        for name, call in calls:
            print(f"{name}: ended {seconds_to_end(call):.3f} s after Ctrl-C", flush=True)


if __name__ == "__main__":
    main()
