"""Rays through rasters of heights, compared with shadows of boxes that are known exactly."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import adumbra

Array = NDArray[np.float64]
NEAR_EDGE = 1e-3
"""Points that are nearer than this to the edge of a shadow are not compared, metres."""


def plain_with_boxes(side: int, count: int) -> tuple[Array, list[Array]]:
    """Return heights of a plain at 0 with boxes between borders of cells of 1 m, and the boxes: two corners each."""
    random = np.random.default_rng(5)
    heights, boxes = np.zeros((side, side)), []
    step = int(np.sqrt(count))
    for box in range(count):
        row, column = (int(place * side / step + random.integers(2, side // step // 2)) for place in divmod(box, step))
        rows, columns = random.integers(3, side // step // 2, 2)
        height = float(random.integers(3, 40))
        heights[row : row + rows, column : column + columns] = height
        low = np.array([column, -row - rows, 0.0])
        boxes.append(np.stack([low, low + [columns, rows, height]]))
    return heights, boxes


def is_shadowed(points: Array, to_sun: Array, boxes: list[Array], grown: float) -> NDArray[np.bool_]:
    """Return which points are shadowed by boxes that are larger on every side by ``grown``."""
    found = np.zeros(len(points), bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        for low, high in boxes:
            ends = np.stack([low - grown - points, high + grown - points]) / to_sun
            enter, leave = np.nanmax(ends.min(axis=0), axis=1), np.nanmin(ends.max(axis=0), axis=1)
            found |= np.maximum(enter, 0.0) < leave
    return found


def suns(count: int) -> Array:
    """Return directions towards suns from 8 degrees up, all around."""
    steps = np.arange(count)
    elevations = 8.0 + 72.0 * ((steps * 0.618034) % 1.0)
    return adumbra.sun_direction(steps * 360.0 / count + 1.7, elevations, up="z")


def centres_of_ground(heights: Array, cell: float) -> tuple[Array, Array]:
    """Return the centres of the cells of a raster that are at 0, and their normals."""
    rows, columns = np.nonzero(heights == 0.0)
    points = np.column_stack([(columns + 0.5) * cell, (-rows - 0.5) * cell, np.zeros(len(rows))])
    return points, np.tile([0.0, 0.0, 1.0], (len(points), 1))


def wrong_points(side: int, boxes: int, sun_count: int) -> tuple[int, int]:
    """Return how many answers of rays are wrong, and how many were compared."""
    heights, corners = plain_with_boxes(side, boxes)
    scene = adumbra.Scene.from_heights(heights, cell=1.0, walls=True)
    points, up = centres_of_ground(heights, 1.0)
    directions = suns(sun_count)
    lit: Any = scene.sunlit(points, up, directions, lift=1e-4)
    wrong = compared = 0
    for sun, answers in zip(directions, lit.T, strict=True):
        surely, maybe = (is_shadowed(points, sun, corners, grown) for grown in (-NEAR_EDGE, NEAR_EDGE))
        wrong += int((answers & surely).sum() + (~answers & ~maybe).sum())
        compared += int((surely | ~maybe).sum())
    return wrong, compared


def test_boxes_on_a_plain_cast_their_exact_shadows() -> None:
    wrong, compared = wrong_points(side=80, boxes=9, sun_count=8)
    assert wrong == 0 and compared > 0.99 * 8 * 80 * 80 * 0.7


@pytest.mark.slow
def test_a_hundred_boxes_on_a_plain_cast_their_exact_shadows() -> None:
    wrong, compared = wrong_points(side=400, boxes=100, sun_count=64)
    assert wrong == 0 and compared > 0.99 * 64 * 160_000 * 0.7
