"""Bakes: the bytes of the program, options, outputs, and scenes of arrays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import SUN, Mesh, Program, write_ply

import adumbra

# Options in Python, and the same options of the program.
OPTIONS: list[tuple[dict[str, Any], str]] = [
    ({}, ""),
    ({"resolution": 2048, "azimuth": 140, "elevation": 35}, "--resolution 2048 --azimuth 140 --elevation 35"),
    ({"resolution": 2048, "elevation": 50.5, "frame": "light"}, "--resolution 2048 --elevation 50.5 --frame light"),
    (
        {"resolution": 2048, "to_sun": np.array(SUN, np.float32).astype(float), "frame": "oblique", "yaw": 30},
        "--resolution 2048 --frame oblique --yaw 30",
    ),
    ({"voxel_size": 0.3, "levels": 1}, "--voxel-size 0.3 --levels 1"),
    ({"resolution": 2048, "encoding": "raw"}, "--resolution 2048 --encoding raw"),
    ({"resolution": 2048, "receivers": "static", "thickness": 0.25}, "--resolution 2048 --receivers static --thickness 0.25"),
    ({"resolution": 2048, "switch_within": 8}, "--resolution 2048 --switch-within 8"),
    (
        {"resolution": 2048, "assume_ground": False, "closed_regions": False},
        "--resolution 2048 --assume-ground no --no-closed-regions",
    ),
    (
        {"resolution": 2048, "bounds": (-50, -1, -50, 50, 40, 50), "exclude": ["ground*"]},
        "--resolution 2048 --bounds=-50,-1,-50,50,40,50 --exclude ground*",
    ),
]


@pytest.mark.parametrize(("options", "words"), OPTIONS)
def test_bake_gives_the_bytes_of_the_program(
    options: dict[str, Any], words: str, program: Program, solids: Path, tmp_path: Path
) -> None:
    expected = tmp_path / "program.adumbra"
    sun = [f"--sun={','.join(repr(float(c)) for c in options['to_sun'])}"] if "to_sun" in options else []
    program("bake", solids, *words.split(), *sun, "-o", expected)
    output = tmp_path / "python.adumbra"
    baked = adumbra.bake(solids, output=output, **options)
    assert output.read_bytes() == expected.read_bytes()
    assert baked.to_bytes() == expected.read_bytes()
    assert baked.bytes == expected.stat().st_size


@pytest.mark.parametrize("up", ["y", "z"])
def test_arrays_bake_like_a_file_of_the_same_triangles(up: Any, mesh: Mesh, program: Program, tmp_path: Path) -> None:
    vertices, faces = mesh[0] + (5e6, 0, 0), mesh[1]
    path = tmp_path / "town.ply"
    write_ply(path, (vertices, faces))
    program("bake", path, "--up", up, "--resolution", 1024, "-o", tmp_path / "town.adumbra")
    expected = (tmp_path / "town.adumbra").read_bytes()
    assert adumbra.bake(adumbra.Scene.from_arrays(vertices, faces, up=up), resolution=1024).to_bytes() == expected
    assert adumbra.bake(path, resolution=1024, up=up).to_bytes() == expected


def test_bake_does_not_depend_on_threads(scene: adumbra.Scene, shadows: adumbra.ShadowFile) -> None:
    for threads in (1, 2, 3):
        assert adumbra.bake(scene, to_sun=SUN, resolution=1024, threads=threads) == shadows


def test_integer_vertices_are_accepted(mesh: Mesh) -> None:
    whole = mesh[0].astype(int)
    forms: list[Any] = [whole, whole.astype(float), whole.astype(np.float16)]
    first, *others = (
        adumbra.bake(adumbra.Scene.from_arrays(vertices, mesh[1], up="y"), resolution=256) for vertices in forms
    )
    assert others == [first, first]


PROPERTIES = (
    "to_sun",
    "up",
    "resolution",
    "size",
    "voxel_size",
    "levels",
    "bytes",
    "encoding",
    "frame",
    "yaw",
    "bounds",
    "bias",
    "triangles",
)


def test_properties_describe_the_bake(mesh: Mesh, scene: adumbra.Scene) -> None:
    bounds = (5.0, 0.0, 5.0, 35.0, 20.0, 35.0)
    baked = adumbra.bake(scene, to_sun=(0, 2, 0), resolution=512, bounds=bounds, frame="oblique", yaw=15, thickness=0.5)
    assert (baked.to_sun, baked.resolution, baked.levels) == ((0.0, 1.0, 0.0), 512, 1)
    assert (baked.frame, baked.up) == ("oblique", "y")
    assert baked.yaw == pytest.approx(15)
    assert baked.bounds == (bounds[:3], bounds[3:])
    assert baked.voxel_size == pytest.approx(40 / 512, rel=0.5)
    assert baked.triangles == len(mesh[1])
    assert baked.bias == (1.0, 0.5, 0.0)
    assert baked.info == {
        **{name: getattr(baked, name) for name in PROPERTIES},
        "thickness": 0.5,
        "switch_within": 0,
        "assume_ground": True,
        "closed_regions": True,
        "receivers": "all",
        "ignore_alpha": False,
    }
    assert baked == adumbra.bake(
        scene, to_sun=(0, 1, 0), resolution=512, bounds=[bounds[:3], bounds[3:]], frame="oblique", yaw=15, thickness=0.5
    )
    assert "512 texels" in repr(baked)


def test_a_cache_gives_the_same_bytes(scene: adumbra.Scene, shadows: adumbra.ShadowFile, tmp_path: Path) -> None:
    for _ in range(2):
        assert adumbra.bake(scene, to_sun=SUN, resolution=1024, cache=tmp_path / "cache") == shadows
    assert any((tmp_path / "cache").rglob("*"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"resolution": 1000}, "1000 is not a power of two from 8 to 262144; try 1024"),
        ({"resolution": -1}, "resolution: -1 is out of range"),
        ({"voxel_size": 0.0}, "the voxel size: 0 is out of range"),
        ({"voxel_size": float("nan")}, "the voxel size: NaN is out of range"),
        ({"voxel_size": 1.0, "resolution": 512}, "give it or a resolution"),
        ({"to_sun": (0, -1, 0)}, "above the horizon"),
        ({"to_sun": (0, 0, 0)}, "is not a direction"),
        ({"to_sun": (1, 2)}, "to_sun: 3 numbers are needed"),
        ({"to_sun": (0, 1, 0), "elevation": 3}, "to_sun: give a direction or angles"),
        ({"azimuth": 3}, "give an elevation too"),
        ({"azimuth": float("nan"), "elevation": 3}, "azimuth: an angle is not finite"),
        ({"elevation": 91}, "elevation: an angle is out of range; it must be from -90 to 90"),
        ({"elevation": float("inf")}, "elevation: an angle is out of range"),
        ({"elevation": -3}, "above the horizon"),
        ({"thickness": -1}, "the thickness: -1 is out of range"),
        ({"switch_within": 65536}, "switch_within: 65536 is out of range; it must be from 0 to 65535"),
        ({"levels": 0}, "levels: 0 is out of range; it must be from 1 to 8"),
        ({"bounds": (0, 0, 0, 0, 1, 1)}, "bounds: the box from (0.0, 0.0, 0.0"),
        ({"bounds": (0, 0, 0, 1, np.inf, 1)}, "bounds: the box from"),
        ({"bounds": (0, 0, 0)}, "bounds: 6 numbers"),
        ({"frame": "upright"}, 'frame: "upright" must be'),
        ({"yaw": 10}, "yaw does not apply"),
        ({"frame": "oblique", "yaw": 181}, "the yaw"),
        ({"receivers": "some"}, 'receivers: "some" must be'),
        ({"encoding": "zipped"}, 'encoding: "zipped" must be'),
        ({"threads": 0}, "threads: 0 is out of range"),
        ({"max_memory": -1}, "max_memory: -1 is out of range"),
    ],
)
def test_errors_name_values_out_of_range(options: dict[str, Any], message: str, scene: adumbra.Scene) -> None:
    with pytest.raises(ValueError, match=message.replace("(", r"\(")) as caught:
        adumbra.bake(scene, **{"resolution": 64, **options} if "voxel_size" not in options else options)
    assert type(caught.value) is ValueError


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"levels": 1.5}, "levels: a whole number is needed, not 1.5"),
        ({"to_sun": "up"}, "to_sun: 3 numbers are needed"),
        ({"only": ["a"]}, "only: this is an option of loading"),
        ({"colour": 1}, "colour"),
    ],
)
def test_errors_name_wrong_types(options: dict[str, Any], message: str, scene: adumbra.Scene) -> None:
    with pytest.raises(TypeError, match=message):
        adumbra.bake(scene, resolution=64, **options)


def test_rejects_arrays_that_are_not_a_mesh(mesh: Mesh, scene: adumbra.Scene) -> None:
    vertices, faces = mesh
    wrong = faces.copy()
    wrong[3, 1] = len(vertices)
    negative = faces.copy()
    negative[5, 2] = -1
    infinite = vertices.copy()
    infinite[faces[0, 0], 1] = np.inf
    huge = vertices * 1e300
    for values, corners, error, message in [
        (vertices, wrong, ValueError, rf"faces\[3, 1\] is {len(vertices)}, .* from 0 to {len(vertices) - 1}"),
        (vertices, negative, ValueError, r"faces\[5, 2\] is -1"),
        (vertices, faces.astype(np.uint64) + 2**63, ValueError, r"faces\[0, 0\] is 9223372036854775"),
        (infinite, faces, ValueError, rf"vertices\[{faces[0, 0]}\] is"),
        (huge, faces, ValueError, "is NaN or infinite"),
        (vertices[:, :2], faces, ValueError, r"vertices: an array of shape \(N, 3\) is needed, not \(132, 2\)"),
        (vertices, faces[:, :2], ValueError, r"faces: an array of shape \(M, 3\) is needed"),
        (vertices, faces[0], ValueError, r"faces: an array of shape \(M, 3\) is needed"),
        (vertices, faces.astype(float), TypeError, "faces: integers are needed, not an array of float64"),
        (vertices.astype(complex), faces, TypeError, "vertices: real numbers are needed, not an array of complex128"),
        (vertices > 1, faces, TypeError, "vertices: real numbers are needed, not an array of bool"),
        (vertices, faces[:0], ValueError, "contains no triangles"),
        (vertices[:0], faces[:0], ValueError, "contains no triangles"),
        (vertices, [], TypeError, "faces: integers are needed"),
        (vertices, np.ma.masked_equal(faces, 1), ValueError, "faces: some values are masked"),
        (vertices * 0, faces, ValueError, "zero extent"),
        (vertices * (1, 0, 0), faces, ValueError, "zero area"),
    ]:
        with pytest.raises(error, match=message) as caught:
            adumbra.Scene.from_arrays(values, corners, up="y")
        assert type(caught.value) is error
    unused = adumbra.Scene.from_arrays(np.concatenate([vertices, [[np.nan] * 3]]), faces, up="y")
    assert adumbra.bake(unused, resolution=64) == adumbra.bake(scene, resolution=64)


@pytest.mark.parametrize(
    ("options", "refused"),
    [
        ({"voxel_size": 5e-324}, True),
        ({"voxel_size": 1e300}, False),
        ({"bounds": (1e300, 0, 0, 2e300, 1, 1)}, False),
        ({"bounds": (-1e308, -1e308, -1e308, 1e308, 1e308, 1e308)}, True),
        ({"bounds": (1e9, 0, 0, 1e9 + 1, 1, 1)}, False),
        ({"thickness": 1e308}, False),
        ({"elevation": 1e-9, "azimuth": 1e300}, False),
        ({"elevation": 1e-6, "frame": "oblique"}, True),
        ({"to_sun": (5e-324, 5e-324, 0)}, False),
        ({"to_sun": (1e308, 1e308, 1e308)}, False),
        ({"max_memory": 0}, True),
    ],
)
def test_extreme_values_are_baked_or_refused(
    options: dict[str, Any], refused: bool, mesh: Mesh, scene: adumbra.Scene
) -> None:
    if "voxel_size" not in options:
        options = {"resolution": 64, **options}
    if refused:
        with pytest.raises((ValueError, adumbra.AdumbraError)):
            adumbra.bake(scene, **options)
    else:
        found = adumbra.bake(scene, **options).visibility(mesh[0])
        assert ((found >= 0) & (found <= 1)).all()


def test_an_output_is_never_half_written(scene: adumbra.Scene, city: Path, tmp_path: Path) -> None:
    output = tmp_path / "out.adumbra"
    output.write_bytes(b"earlier")

    def stop(done: int, total: int) -> None:
        raise RuntimeError(f"stopped after {done} of {total}")

    with pytest.raises(RuntimeError, match="stopped after"):
        adumbra.bake(city, resolution=16384, output=output, progress=stop)
    assert output.read_bytes() == b"earlier"
    assert [path.name for path in tmp_path.iterdir()] == ["out.adumbra"]
    with pytest.raises(ValueError, match="part of the scene"):
        adumbra.bake(city, resolution=64, output=city)
    with pytest.raises(FileNotFoundError):
        adumbra.bake(scene, resolution=64, output=tmp_path / "none" / "out.adumbra")
    with pytest.raises(IsADirectoryError):
        adumbra.bake(scene, resolution=64, output=tmp_path)


def test_a_memory_limit_that_is_too_low_is_an_error(city: Path) -> None:
    with pytest.raises(adumbra.AdumbraError, match="MiB are allowed") as caught:
        adumbra.bake(city, resolution=16384, max_memory=1 << 20)
    assert type(caught.value) is adumbra.MemoryLimitError
