"""Arrays of every kind, for scenes, rays, hours and skies: taken without a copy where they can be, or refused, never a crash."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from conftest import DAY, SUN, Mesh, points_of
from numpy.typing import NDArray

import adumbra

Ask = Callable[[Any, Any], Any]


@pytest.fixture(scope="module")
def asked(scene: adumbra.Scene, shadows: adumbra.ShadowFile) -> dict[str, Ask]:
    """Return everything that takes points and normals, by name."""
    return {
        "sunlit": lambda points, normals: scene.sunlit(points, normals, [SUN, (-1, 1, 0)]),
        "visibility": lambda points, normals: scene.visibility(points, normals, SUN, sun_degrees=3),
        "nearest": lambda points, _: np.column_stack(scene.nearest(points, (0.1, 1, 0.2))),
        "sun_hours": lambda points, normals: adumbra.sun_hours(scene, points, normals, **DAY).hours,
        "sky": lambda points, normals: adumbra.sky(scene, points, normals).patches,
        "file": lambda points, normals: shadows.visibility(points, normals),
    }


NAMES = ["sunlit", "visibility", "nearest", "sun_hours", "sky", "file"]


def forms_of(values: NDArray[np.float32]) -> list[Any]:
    """Return the same numbers in every form that NumPy has for them."""
    frozen = values.copy()
    frozen.flags.writeable = False
    padded = np.zeros((len(values), 4), np.float32)
    padded[:, :3] = values
    shifted = np.frombuffer(b"\0" + values.tobytes(), np.uint8)[1:].view(np.float32).reshape(-1, 3)
    forms: list[Any] = [values.astype(kind) for kind in (np.float64, np.longdouble, ">f4", ">f8")]
    return [*forms, np.asfortranarray(values), frozen, padded[:, :3], values[::-1].copy()[::-1], shifted, values.tolist()]


@pytest.mark.parametrize("name", NAMES)
def test_every_form_gives_the_same_answers(name: str, asked: dict[str, Ask], mesh: Mesh) -> None:
    ask = asked[name]
    points, normals = (values.astype(np.float32) for values in points_of(mesh, 60))
    expected = ask(points, normals)
    assert len(np.unique(expected)) > 1
    for form, upright in zip(forms_of(points), forms_of(normals), strict=True):
        assert np.array_equal(ask(form, normals), expected)
        assert np.array_equal(ask(points, upright), expected)
    whole = np.array([[20, 3, 20], [21, 30, 5]])
    assert np.array_equal(ask(whole.astype(np.int16), None), ask(whole.astype(np.float64), None))
    for nothing in (np.empty((0, 3)), np.empty((0, 3), np.float32)):
        assert len(ask(nothing, nothing)) == 0 and len(ask(nothing, None)) == 0


@pytest.mark.parametrize("name", NAMES)
def test_wrong_arrays_are_refused_by_name(name: str, asked: dict[str, Ask]) -> None:
    ask = asked[name]
    good = np.zeros((2, 3))
    wrong: list[tuple[Any, type[Exception], str]] = [
        (np.zeros((2, 2)), ValueError, r"an array of shape \(N, 3\) is needed, not \(2, 2\)"),
        (np.zeros(3), ValueError, r"an array of shape \(N, 3\)"),
        (np.zeros((1, 2, 3)), ValueError, r"an array of shape \(N, 3\)"),
        (np.float64(1), ValueError, r"an array of shape \(N, 3\)"),
        (good.astype(complex), TypeError, "real numbers are needed, not an array of complex128"),
        (good.astype(bool), TypeError, "real numbers are needed"),
        (good.astype("M8[s]"), TypeError, "real numbers are needed"),
        (np.array([["a", "b", "c"]]), TypeError, "real numbers are needed"),
        (np.array([[None] * 3]), TypeError, "real numbers are needed"),
        (np.ma.masked_equal(good, 0.0), ValueError, "some values are masked; leave those rows out"),
    ]
    for values, kind, message in wrong:
        with pytest.raises(kind, match=f"points: {message}"):
            ask(values, None)
        if name != "nearest":
            with pytest.raises(kind, match=f"normals: {message}"):
                ask(good, values)


@pytest.mark.parametrize("name", NAMES)
def test_points_that_are_no_places_are_answered(name: str, asked: dict[str, Ask]) -> None:
    points = np.array([[np.nan, 0, 0], [0, np.inf, 0], [0, -np.inf, 0], [1e300, -1e300, 1e300], [1e30, 1e30, 1e30]])
    found = asked[name](points, np.tile([0.0, 1.0, 0.0], (5, 1)))
    assert len(found) == 5 and not np.isnan(found.astype(float)).any()
    if name in ("sunlit", "visibility", "file"):
        assert (found[:3] == 1).all()


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_numpy_does_not_copy_contiguous_arrays(
    kind: Any, scene: adumbra.Scene, shadows: adumbra.ShadowFile, mesh: Mesh
) -> None:
    points, normals = (np.resize(values.astype(kind), (200_000, 3)) for values in points_of(mesh, 1000))
    for ask in (lambda: shadows.visibility(points, normals), lambda: scene.sunlit(points, normals, SUN)):
        ask()
        tracemalloc.start()
        found = ask()
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < found.nbytes + 50_000 < points.nbytes / 2


def test_every_form_of_a_mesh_gives_the_same_scene(mesh: Mesh) -> None:
    vertices, faces = mesh[0].astype(np.float32), mesh[1]
    expected = adumbra.Scene.from_arrays(vertices, faces, up="y").mesh()
    kinds: list[Any] = [faces.astype(kind) for kind in (np.int16, np.uint8, np.uint32, np.uint64, ">i4")]
    for form in [*kinds, np.asfortranarray(faces), np.hstack([faces, faces])[:, :3], faces.tolist()]:
        found = adumbra.Scene.from_arrays(vertices, form, up="y").mesh()
        assert np.array_equal(found[0], expected[0]) and np.array_equal(found[1], expected[1])
    for form in forms_of(vertices):
        assert np.array_equal(adumbra.Scene.from_arrays(form, faces, up="y").mesh()[0], expected[0])


def test_numpy_does_not_copy_a_mesh_of_its_own_types() -> None:
    random = np.random.default_rng(2)
    vertices, faces = random.random((100_000, 3)), random.integers(0, 100_000, (200_000, 3)).astype(np.uint32)
    adumbra.Scene.from_arrays(vertices[:9], [[0, 1, 2]], up="z")
    tracemalloc.start()
    adumbra.Scene.from_arrays(vertices, faces, up="z")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 0.2 * (vertices.nbytes + faces.nbytes)


@pytest.mark.slow
def test_a_hundred_million_faces_are_answered() -> None:
    triangle = np.array([[0.0, 0, 3], [1, 0, 3], [0, 1, 3], [0, 0, 0], [1, 0, 0], [0, 1, 0]])
    faces = np.broadcast_to(np.array([[0, 1, 2]], np.uint32), (100_000_000, 3))
    scene = adumbra.Scene.from_arrays(triangle, faces, up="z")
    assert scene.triangles == 100_000_000 and scene.bounds == ((0, 0, 3), (1, 1, 3))
