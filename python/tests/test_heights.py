"""Scenes of rasters of heights: every form of array, axes, cells without data, and errors."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import adumbra

TOWER = np.array([[1, 1, 1, 1], [1, 6, 1, 1], [1, 1, 1, 1]], np.float64)
"""A tower of 6 m on a plain at 1 m, three rows of four cells."""


def test_rows_go_south_and_walls_are_between_cells() -> None:
    z = adumbra.Scene.from_heights(TOWER, cell=2, walls=True, corner=(100, 50))
    y = adumbra.Scene.from_heights(TOWER, cell=2, walls=True, corner=(100, -50), up="y")
    assert (z.up, z.bounds) == ("z", ((100, 44, 1), (108, 50, 6)))
    assert (y.up, y.bounds) == ("y", ((100, 1, -50), (108, 6, -44)))
    # The shadow of a sun in the west, 45 degrees up, is 5 m long, from the wall on the border between cells at x = 104.
    points = np.array([[x, 47, 1] for x in (101.9, 104.1, 108.9, 109.1)])
    assert z.sunlit(points, None, [-1, 0, 1]).tolist() == [True, False, False, True]
    turned = np.column_stack([points[:, 0], points[:, 2], -points[:, 1]])
    assert y.sunlit(turned, None, [-1, 1, 0]).tolist() == [True, False, False, True]


def test_terrain_passes_through_the_centres_of_cells() -> None:
    slope = np.tile(np.arange(4.0), (3, 1))
    scene = adumbra.Scene.from_heights(slope, cell=2, walls=False)
    assert scene.bounds == ((1, -5, 0), (7, -1, 3)) and scene.triangles == 2 * 3 * 2
    away, normals = scene.nearest(np.array([[2, -2, 10], [6.5, -4.5, 10]]), (0, 0, -1))
    assert away == pytest.approx([9.5, 7.25]) and normals == pytest.approx(np.tile([-1, 0, 2], (2, 1)) / np.sqrt(5))


@pytest.mark.parametrize("up", ["y", "z"])
def test_every_form_of_array_gives_the_same_scene(up: Any) -> None:
    expected = adumbra.Scene.from_heights(TOWER, 1, walls=True, up=up).mesh()
    forms: list[Any] = [TOWER.tolist(), TOWER.astype(np.float32), TOWER.astype(np.int16), TOWER.astype(">f4")]
    forms += [np.asfortranarray(TOWER), np.repeat(TOWER, 2, axis=1)[:, ::2], TOWER[::-1][::-1]]
    read_only = TOWER.copy()
    read_only.flags.writeable = False
    for heights in [*forms, read_only]:
        found = adumbra.Scene.from_heights(heights, 1, walls=True, up=up).mesh()
        assert np.array_equal(found[0], expected[0]) and np.array_equal(found[1], expected[1])
    again = pickle.loads(pickle.dumps(adumbra.Scene.from_heights(TOWER, 1, walls=True, up=up)))
    assert np.array_equal(again.mesh()[0][again.mesh()[1]], expected[0][expected[1]]) and again.up == up


def test_cells_without_data_are_empty_however_they_are_marked() -> None:
    hole = TOWER.copy()
    hole[1, 1] = np.nan
    expected = adumbra.Scene.from_heights(hole, 1, walls=True)
    assert expected.bounds[1][2] == 1 and expected.triangles == 2 * 11
    away, _ = expected.nearest([[1.5, -1.5, 9], [0.5, -1.5, 9]], (0, 0, -1))
    assert away.tolist() == [np.inf, 8]
    numbered = np.where(np.isnan(hole), -9999.0, hole)
    marked: list[tuple[Any, Any]] = [
        (numbered, -9999),
        (numbered.astype(np.int16), -9999),
        (np.ma.masked_equal(numbered, -9999), None),
        (np.ma.masked_equal(numbered.astype(np.int32), -9999), None),
        (np.ma.masked_invalid(hole), None),
        (np.where(numbered == -9999, np.float32(-3.4e38), numbered).astype(np.float32), np.float32(-3.4e38)),
        (np.where(numbered == -9999, np.float32(-3.4e38), numbered).astype(np.float32), np.float64(-3.4e38)),
        (np.where(numbered == -9999, -9999.9, numbered).astype(np.float32), -9999.9),
    ]
    for heights, nodata in marked:
        found = adumbra.Scene.from_heights(heights, 1, walls=True, nodata=nodata)
        assert found.bounds == expected.bounds and found.triangles == expected.triangles


def test_faulty_rasters_are_refused() -> None:
    infinite, empty = TOWER.copy(), np.full((2, 2), np.nan)
    infinite[2, 3] = np.inf
    wrong: list[tuple[Any, dict[str, Any], type[Exception], str]] = [
        (TOWER, {"cell": 0}, ValueError, "cells with a side of 0; give a length above 0"),
        (TOWER, {"cell": -1}, ValueError, "give a length above 0"),
        (TOWER, {"cell": np.nan}, ValueError, "give a length above 0"),
        (TOWER, {"corner": (0, np.nan)}, ValueError, "a corner at .*NaN"),
        (TOWER, {"corner": 3}, ValueError, "corner: 2 numbers"),
        (TOWER, {"up": "x"}, ValueError, "up: 'x' is not an axis"),
        (infinite, {}, ValueError, "an infinite height in row 2, column 3"),
        (empty, {}, ValueError, "no cell with data"),
        (np.zeros((0, 4)), {}, ValueError, "no cell with data"),
        (TOWER[:1], {"walls": False}, ValueError, "4 columns and 1 rows, too few"),
        (TOWER[0], {}, ValueError, r"shape \(rows, columns\) is needed, not \(4,\)"),
        (TOWER.astype(complex), {}, TypeError, "real numbers are needed, not an array of complex128"),
        (TOWER.astype(str), {}, TypeError, "real numbers"),
    ]
    for heights, options, kind, message in wrong:
        with pytest.raises(kind, match=message):
            adumbra.Scene.from_heights(heights, **{"cell": 1.0, "walls": True, **options})


def test_arrays_in_degrees_are_a_warning() -> None:
    degrees = [[11.57, 48.13, 500.0], [11.58, 48.13, 500.0], [11.58, 48.14, 530.0]]
    raster = 500 + 40 * np.random.default_rng(1).random((30, 30))
    made: list[Callable[[], adumbra.Scene]] = [
        lambda: adumbra.Scene.from_arrays(degrees, [[0, 1, 2]], up="z"),
        lambda: adumbra.Scene.from_heights(raster, 1 / 3600, walls=True, corner=(11.57, 48.13)),
        lambda: adumbra.Scene.from_heights(raster, 1 / 3600, walls=False, corner=(-71.1, -33.4)),
        lambda: adumbra.Scene.from_trimesh(SimpleNamespace(vertices=degrees, faces=[[0, 1, 2]]), up="z"),
    ]
    for make in made:
        with pytest.warns(adumbra.SceneWarning, match="look like degrees with heights in metres") as caught:
            scene = make()
        assert [Path(warning.filename).name for warning in caught] == ["test_heights.py"]
        # Warnings are errors in these tests.
        assert pickle.loads(pickle.dumps(scene)).bounds == scene.bounds
    pole = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 12.0]]
    adumbra.Scene.from_arrays(pole, [[0, 1, 2]], up="z")
    adumbra.Scene.from_heights(raster / 1000, 0.001, walls=True, corner=(11.5, 48.1))
    adumbra.Scene.from_heights(raster / 100, 0.005, walls=True, corner=(-0.05, 0.05))
    with pytest.raises(ValueError, match="vertices: some values are masked"):
        adumbra.Scene.from_arrays(np.ma.masked_equal(degrees, 530.0), [[0, 1, 2]], up="z")
