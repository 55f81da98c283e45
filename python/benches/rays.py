"""Times rays in Python against the same rays by the Rust crate.

    cargo build --release --example rays
    python benches/rays.py SCENE target/release/examples/rays

It draws a million points on the scene's surfaces, and has both trace one ray from each to the sun, in turns. The least time and the most memory of each counts.
Preparing the scene for rays is not in the times.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import adumbra

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from conftest import points_of  # noqa: E402
from memory import bytes_of  # noqa: E402

LIFT = 1e-3


def seconds(scene: adumbra.Scene, points: NDArray[Any], normals: NDArray[Any]) -> float:
    """Return the seconds of one call."""
    start = time.perf_counter()
    scene.sunlit(points, normals, scene.to_sun, lift=LIFT)
    return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path, help="a GLB file, in which Y points up")
    parser.add_argument("program", type=Path)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    scene = adumbra.Scene(options.scene)
    points, normals = points_of(scene.mesh(), options.points)
    narrow = points.astype(np.float32), normals.astype(np.float32)
    lit = int(scene.sunlit(points, normals, scene.to_sun, lift=LIFT).sum())
    rust: list[float] = []
    most = 0
    double: list[float] = []
    single: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        places, upright = (Path(folder) / part for part in ("points", "normals"))
        points.tofile(places)
        normals.tofile(upright)
        sun = ",".join(map(repr, scene.to_sun))
        for _ in range(options.repeats):
            words = [options.program, options.scene, places, upright, sun, str(LIFT), "3"]
            done = subprocess.run(words, capture_output=True, text=True, check=True)
            for line in done.stdout.splitlines():
                taken, answers, held = line.split()
                assert int(answers) == lit, f"Rust has {answers} lit points, Python {lit}"
                rust.append(float(taken))
                most = max(most, int(held))
            double.extend(seconds(scene, points, normals) for _ in range(3))
            single.extend(seconds(scene, *narrow) for _ in range(3))
    memory = [
        bytes_of(partial(seconds, scene, *arrays)) for arrays in ((points, normals), narrow)
    ]
    print(
        f"memory: Rust {most:,} bytes, Python float64 {memory[0]:,} ({memory[0] / most:.3f}), float32 {memory[1]:,} "
        f"({memory[1] / most:.3f})"
    )
    print(
        f"{options.points:,} points, {lit:,} lit: Rust {min(rust):.3f} s, Python float64 {min(double):.3f} s "
        f"({min(double) / min(rust):.3f}), float32 {min(single):.3f} s ({min(single) / min(rust):.3f})"
    )


if __name__ == "__main__":
    main()
