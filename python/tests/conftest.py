"""Shared by the tests: the program, the folder of real scenes, a small scene and its file."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import adumbra

Mesh = tuple[NDArray[np.float64], NDArray[Any]]
Program = Callable[..., str]

SUN = (0.5, 0.8, 0.35)

DAY: Any = {"lat": 48.14, "lon": 11.58, "date": "2026-03-20", "from_": 8, "to": "18:00", "tz": "Europe/Berlin"}
"""A day for hours of sun."""


def boxes(corners: NDArray[np.float64], sizes: NDArray[np.float64]) -> Mesh:
    """Return closed boxes, with faces that are seen from outside."""
    unit = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float64)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    one = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    vertices = (corners[:, None] + unit[None] * sizes[:, None]).reshape(-1, 3)
    faces = (one[None] + 8 * np.arange(len(corners))[:, None, None]).reshape(-1, 3)
    return vertices, faces


def town(side: int) -> Mesh:
    """Return a ground of 10 m per box and ``side`` x ``side`` boxes of different heights on it."""
    random = np.random.default_rng(7)
    places = np.stack(np.meshgrid(np.arange(side), np.arange(side)), -1).reshape(-1, 2) * 10.0 + 2.0
    corners = np.column_stack([places[:, 0], np.zeros(len(places)), places[:, 1]])
    sizes = random.uniform((3, 2, 3), (6, 15, 6), (len(places), 3))
    vertices, faces = boxes(corners, sizes)
    end = 10.0 * side
    ground = np.array([[0, 0, 0], [0, 0, end], [end, 0, end], [end, 0, 0]])
    quad = len(vertices) + np.array([[0, 1, 2], [0, 2, 3]])
    return np.concatenate([vertices, ground]), np.concatenate([faces, quad])


@pytest.fixture(scope="session")
def mesh() -> Mesh:
    """Return a town of 16 boxes."""
    return town(4)


@pytest.fixture(scope="session")
def scene(mesh: Mesh) -> adumbra.Scene:
    """Return the scene of that town."""
    return adumbra.Scene.from_arrays(*mesh, up="y")


@pytest.fixture(scope="session")
def shadows(scene: adumbra.Scene) -> adumbra.ShadowFile:
    """Return the file of that town."""
    return adumbra.bake(scene, to_sun=SUN, resolution=1024)


@pytest.fixture(scope="session")
def program() -> Program:
    """Return a function that runs the program ``adumbra``."""
    path = os.environ.get("ADUMBRA_BIN")
    if not path:
        pytest.skip("ADUMBRA_BIN does not name the program adumbra; build it with: cargo build --release -p adumbra-cli")

    def run(*arguments: object) -> str:
        command = [path, *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode in (0, 1), f"{command}: {done.stderr}"
        return done.stdout

    return run


@pytest.fixture(scope="session")
def city(program: Program, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a scene that the program generates."""
    path = tmp_path_factory.mktemp("city") / "city.glb"
    program("generate", "city", "-o", path)
    return path


@pytest.fixture(scope="session")
def solids(program: Program, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a small scene that the program generates."""
    path = tmp_path_factory.mktemp("solids") / "solids.glb"
    program("generate", "primitives", "-o", path)
    return path


def write_ply(path: Path, mesh: Mesh) -> None:
    """Write a mesh as a PLY file, with all digits of its vertices."""
    vertices, faces = mesh
    header = (
        f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = [" ".join(repr(float(c)) for c in p) for p in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
    path.write_text(header + "\n".join(rows) + "\n")


def points_of(mesh: Mesh, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return random points on a mesh by area, and their normals."""
    random = np.random.default_rng(3)
    corners = mesh[0][mesh[1]]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    chosen = random.choice(len(area), count, p=area / area.sum())
    u, v = np.sqrt(random.random(count)), random.random(count)
    weights = np.stack([1 - u, u * (1 - v), u * v], 1)
    return np.einsum("nk,nkc->nc", weights, corners[chosen]), (across / area[:, None])[chosen]
