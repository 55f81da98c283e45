"""Counts wrong shadows of boxes on a plain, whose exact shadows are known, and times them beside solweig's.

    pip install solweig
    python benches/hundred_boxes.py

A plain of 400 x 400 m with 100 boxes, whose walls are on borders between cells, is a raster of heights. The ground is asked at the centres
of its cells, for 64 suns. A point is wrong if it is farther than 1 mm from the edge of a shadow and its answer is not that of the boxes.
solweig, a package of the Python index, answers for the same raster and the same suns, on the processor. Both use all cores. Making the
scene is in the time.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import adumbra

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from test_closed_forms import NEAR_EDGE, centres_of_ground, is_shadowed, plain_with_boxes, suns  # noqa: E402

Lit = NDArray[np.bool_]


def by_rays(heights: NDArray[np.float64], cell: float, directions: NDArray[np.float64]) -> Lit:
    """Return which cells of the ground are lit, by rays from their centres."""
    scene = adumbra.Scene.from_heights(heights, cell=cell, walls=True)
    points, up = centres_of_ground(heights, cell)
    return scene.sunlit(points, up, directions, lift=1e-4)


def by_solweig(heights: NDArray[np.float64], cell: float, directions: NDArray[np.float64]) -> Lit:
    """Return which cells of the ground are lit, by solweig on the processor."""
    shadowing = importlib.import_module("solweig.rustalgos").shadowing
    shadowing.disable_gpu()
    single, highest = heights.astype(np.float32), float(heights.max())
    answers = []
    for x, y, z in directions:
        azimuth, elevation = np.degrees([np.arctan2(x, y), np.arcsin(z)])
        shown: Any = shadowing.calculate_shadows_wall_ht_25(azimuth % 360, elevation, cell, highest, single).bldg_sh
        answers.append(shown[heights == 0.0] > 0.5)
    return np.stack(answers, axis=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=1, help="cells per metre (1)")
    parser.add_argument("--repeats", type=int, default=3, help="the least time of these counts (3)")
    options = parser.parse_args()
    metres, boxes = plain_with_boxes(side=400, count=100)
    heights: NDArray[np.float64] = np.kron(metres, np.ones((options.cells, options.cells))).astype(np.float64)
    cell = 1.0 / options.cells
    directions = suns(64)
    points, _ = centres_of_ground(heights, cell)
    surely, maybe = (
        np.stack([is_shadowed(points, sun, boxes, grown) for sun in directions], axis=1) for grown in (-NEAR_EDGE, NEAR_EDGE)
    )
    compared = int((surely | ~maybe).sum())
    print(f"{len(points):,} points of the ground, {len(directions)} suns, {compared:,} answers compared")
    methods: list[tuple[str, Callable[..., Lit]]] = [("adumbra", by_rays), ("solweig", by_solweig)]
    for name, method in methods:
        seconds = []
        for _ in range(options.repeats):
            start = time.perf_counter()
            lit = method(heights, cell, directions)
            seconds.append(time.perf_counter() - start)
        too_lit, too_dark = int((lit & surely).sum()), int((~lit & ~maybe).sum())
        share = 100.0 * (too_lit + too_dark) / compared
        print(f"{name}: {min(seconds):.2f} s, {too_lit:,} wrongly lit, {too_dark:,} wrongly dark, {share:.3f} %")


if __name__ == "__main__":
    main()
