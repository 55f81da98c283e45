"""Times look-ups in Python against the same look-ups by the Rust crate.

    cargo build --release --example look_ups
    python benches/look_ups.py SCENE target/release/examples/look_ups

It bakes the scene, draws 10 million points on its surfaces, and has both look all of them up with normals, over 5 x 5 texels, in
turns. The least time and the most memory of each counts. Points are in the order in which they were drawn, and then sorted along the scene.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import adumbra

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from conftest import points_of  # noqa: E402
from memory import bytes_of  # noqa: E402


def least(shadows: adumbra.ShadowFile, points: NDArray[Any], normals: NDArray[Any]) -> float:
    """Return the seconds of one call."""
    start = time.perf_counter()
    shadows.visibility(points, normals)
    return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("program", type=Path)
    parser.add_argument("--points", type=int, default=10_000_000)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    scene = adumbra.Scene(options.scene)
    shadows = adumbra.bake(scene, progress=False)
    points, normals = points_of(scene.mesh(), options.points)
    orders: list[tuple[Any, str]] = [(slice(None), "as drawn"), (np.lexsort(np.floor(points.T[[0, 2]])), "sorted")]
    for order, name in orders:
        points, normals = points[order], normals[order]
        with tempfile.TemporaryDirectory() as folder:
            file, places, upright = (Path(folder) / part for part in ("file", "points", "normals"))
            shadows.save(file)
            points.tofile(places)
            normals.tofile(upright)
            rust: list[float] = []
            double: list[float] = []
            single: list[float] = []
            narrow = points.astype(np.float32), normals.astype(np.float32)
            for _ in range(options.repeats):
                words = [options.program, file, places, upright, "3"]
                done = subprocess.run(words, capture_output=True, text=True, check=True)
                taken, held = zip(*(line.split() for line in done.stdout.splitlines()), strict=True)
                rust.extend(map(float, taken))
                double.extend(least(shadows, points, normals) for _ in range(3))
                single.extend(least(shadows, *narrow) for _ in range(3))
        memory = bytes_of(lambda: shadows.visibility(points, normals)), bytes_of(lambda: shadows.visibility(*narrow))
        most = max(map(int, held))
        print(
            f"memory: Rust {most:,} bytes, Python float64 {memory[0]:,} ({memory[0] / most:.3f}), float32 {memory[1]:,} "
            f"({memory[1] / most:.3f})"
        )
        print(
            f"{options.points:,} points {name}: Rust {min(rust):.3f} s, Python float64 {min(double):.3f} s "
            f"({min(double) / min(rust):.3f}), float32 {min(single):.3f} s ({min(single) / min(rust):.3f})"
        )


if __name__ == "__main__":
    main()
