"""Bakes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._arrays import numbers, threads_of, whole
from ._file import ShadowFile
from ._loading import LoadOptions
from ._progress import Progress, reporting
from ._scene import Scene, SceneLike, scene_of
from ._sun import SunPath, sun_direction

if TYPE_CHECKING:
    from typing_extensions import Unpack

DEFAULT_RESOLUTION = 8192


class BakeOptions(LoadOptions, total=False):
    """Options of a bake of a scene that is given by its path: those of :func:`bake`, and those of the loader."""

    to_sun: ArrayLike | None
    azimuth: float | None
    elevation: float | None
    resolution: int
    voxel_size: float | None
    thickness: float
    switch_within: int
    levels: int
    assume_ground: bool | None
    closed_regions: bool
    receivers: Literal["all", "static"]
    bounds: ArrayLike | None
    frame: Literal["auto", "light", "oblique"]
    yaw: float | None
    encoding: Literal["coded", "raw"]
    max_memory: int | None


def bake(
    scene: SceneLike,
    *,
    to_sun: ArrayLike | None = None,
    azimuth: float | None = None,
    elevation: float | None = None,
    resolution: int = DEFAULT_RESOLUTION,
    voxel_size: float | None = None,
    thickness: float = 0.0,
    switch_within: int = 0,
    levels: int = 3,
    assume_ground: bool | None = None,
    closed_regions: bool = True,
    receivers: Literal["all", "static"] = "all",
    bounds: ArrayLike | None = None,
    frame: Literal["auto", "light", "oblique"] = "auto",
    yaw: float | None = None,
    encoding: Literal["coded", "raw"] = "coded",
    output: str | os.PathLike[str] | None = None,
    cache: str | os.PathLike[str] | None = None,
    max_memory: int | None = None,
    threads: int | None = None,
    progress: Progress = None,
    **loading: Unpack[LoadOptions],
) -> ShadowFile:
    """Bake the sun's shadows of a scene.

    The same scene and options give the same bytes as ``adumbra bake``, on any number of threads. Other Python threads run
    meanwhile. Ctrl-C stops the bake, and leaves an earlier output unchanged.

    Args:
        scene: A :class:`Scene`, or the path of a ``.glb``, ``.gltf``, ``.obj`` or ``.ply`` file.
        to_sun: Direction towards the sun, three numbers, of any length, above the horizon. If neither it nor ``elevation`` is
            given, it is :attr:`Scene.to_sun`.
        azimuth: Azimuth of the sun in degrees, clockwise from the scene's north as seen from above: 90 is +X. North is -Z where Y
            points up, and +Y where Z points up. 0 unless it is given.
        elevation: Elevation of the sun in degrees above the horizon, above 0 and at most 90.
        resolution: Texels on the longest side of the scene as the sun sees it: a power of two, 8 to 262144.
        voxel_size: Edge of a voxel in world units, above 0, instead of a resolution.
        thickness: How far below an open surface its shadow may begin, in world units along the light, at
            least 0. The bias at the surface's slope applies if that is larger. Larger values give smaller
            files.
        switch_within: How far behind the first surface its shadow may begin, in voxels, up to 65535. 0 allows
            any depth that no filter around a surface reads.
        levels: Number of levels of detail, 1 to 8, each with voxels four times as large as the one before. Levels of fewer
            than 256 texels are left out.
        assume_ground: Whether shadows below the last surface of a column are left out. ``None`` leaves them out if the scene
            has its own ground. ``False`` keeps them, for a ground that only the app draws.
        closed_regions: Whether points inside closed solids may be lit or shadowed, whichever is smaller.
        receivers: ``"all"``: every point in space is answered. ``"static"``: only points on static surfaces, with normals,
            for filters up to 9.
        bounds: Cover this box instead of the scene: (x0, y0, z0, x1, y1, z1), or two corners. Casters outside it towards the
            sun still cast shadows into it.
        frame: ``"light"``: columns along the light, in a plane across it. ``"oblique"``: over level ground. ``"auto"``:
            the frame that is predicted to give the smaller file, and light if the sun is below 5 degrees.
        yaw: Oblique frame: turn of the grid in degrees, -180 to 180, from +X to the grid's x axis, clockwise as seen from above.
            Without it, along most of the scene's edges.
        encoding: How ``output`` is stored, and how :meth:`ShadowFile.save` stores it by default. ``"coded"`` is about a third
            of the bytes of ``"raw"``.
        output: The shadow file to write. An earlier file is replaced as a whole, once the bake has succeeded.
        cache: Folder with the results of earlier bakes. It is created if it does not exist. After an edit of
            the scene, only the parts that the edit touches are baked.
        max_memory: Largest number of bytes that the bake may hold. Data that does not fit is kept in
            temporary files, beside ``output`` if that is given.
        threads: Number of threads, 1 to 1024. All cores unless it is given.
        progress: ``None``: a bar if ``tqdm`` is installed and stderr is a terminal. ``True``: a bar. ``False``: nothing. A
            function is called on the calling thread with the number of finished root blocks and the total. An
            exception that it raises stops the bake.
        **loading: Options for a scene that is given by its path, see :class:`LoadOptions`.

    Returns:
        The shadow file, in memory.

    Raises:
        ValueError: A value is out of its range, or ``output`` is part of the scene.
        TypeError: A value has the wrong type, or there is no such option.
        FormatError: The scene's file is broken, or holds nothing that casts a shadow.
        OSError: A file cannot be read or written.
        MemoryLimitError: The bake does not fit its memory limit.
        KeyboardInterrupt: Ctrl-C was pressed.

    Example:
        >>> import adumbra
        >>> roof = adumbra.Scene.from_arrays([[0, 0, 3], [4, 0, 3], [0, 4, 3]], [[0, 1, 2]], up="z")
        >>> shadows = adumbra.bake(roof, to_sun=(0, 0, 1), resolution=64, assume_ground=False)
        >>> shadows.visibility([[1, 1, 0], [1, 1, 5]], filter=1)
        array([0., 1.], dtype=float32)
    """
    loaded = scene_of(scene, dict(loading))
    options = options_of(
        loaded,
        to_sun=to_sun,
        azimuth=azimuth,
        elevation=elevation,
        resolution=resolution,
        voxel_size=voxel_size,
        thickness=thickness,
        switch_within=switch_within,
        levels=levels,
        assume_ground=assume_ground,
        closed_regions=closed_regions,
        receivers=receivers,
        bounds=bounds,
        frame=frame,
        yaw=yaw,
        encoding=encoding,
        max_memory=max_memory,
    )
    with reporting(progress) as report:
        native = _native.bake(
            loaded._native,
            options,
            None if output is None else os.fspath(output),
            None if cache is None else os.fspath(cache),
            threads_of(threads),
            report,
        )
    return ShadowFile(native)


def options_of(
    scene: Scene,
    *,
    to_sun: ArrayLike | None = None,
    azimuth: float | None = None,
    elevation: float | None = None,
    resolution: int = DEFAULT_RESOLUTION,
    voxel_size: float | None = None,
    thickness: float = 0.0,
    switch_within: int = 0,
    levels: int = 3,
    assume_ground: bool | None = None,
    closed_regions: bool = True,
    receivers: str = "all",
    bounds: ArrayLike | None = None,
    frame: str = "auto",
    yaw: float | None = None,
    encoding: str = "coded",
    max_memory: int | None = None,
) -> dict[str, Any]:
    """Return the options of a bake as the native part takes them."""
    if voxel_size is not None and resolution != DEFAULT_RESOLUTION:
        raise ValueError("voxel_size: give it or a resolution, not both")
    return {
        "to_sun": _sun_of(scene, to_sun, azimuth, elevation),
        "resolution": whole("resolution", resolution, 0, 2**63),
        "voxel_size": None if voxel_size is None else float(voxel_size),
        "thickness": float(thickness),
        "switch_within": whole("switch_within", switch_within, 0, 65535),
        "levels": whole("levels", levels, 1, 8),
        "assume_ground": None if assume_ground is None else bool(assume_ground),
        "closed_regions": bool(closed_regions),
        "receivers": receivers,
        "bounds": None if bounds is None else _corners(bounds),
        "frame": frame,
        "yaw": None if yaw is None else float(yaw),
        "encoding": encoding,
        "max_memory": memory_of(max_memory),
    }


def _sun_of(
    scene: Scene, to_sun: ArrayLike | None, azimuth: float | None, elevation: float | None
) -> tuple[float, ...]:
    """Return the given direction towards the sun, or else that of the scene."""
    if to_sun is not None:
        if azimuth is not None or elevation is not None:
            raise ValueError("to_sun: give a direction or angles, not both")
        if isinstance(to_sun, SunPath):
            raise TypeError("to_sun: a file has one sun; give sun.to_sun(scene.up)[number], or bake a path with bake_path")
        direction = numbers("to_sun", to_sun, 3)
        if not np.isfinite(direction).all() or not any(direction):
            raise ValueError(f"to_sun: {direction} is not a direction; give finite numbers, not all 0")
        if not direction["xyz".index(scene.up)] > 0.0:
            raise ValueError(f"to_sun: {direction} is not above the horizon; its {scene.up} must be above 0, as {scene.up} points up")
        return direction
    if elevation is not None:
        return tuple(float(c) for c in sun_direction(0.0 if azimuth is None else azimuth, elevation, up=scene.up))
    if azimuth is not None:
        raise ValueError("azimuth: give an elevation too")
    return scene.to_sun


def memory_of(max_memory: int | None) -> int | None:
    """Return a number of bytes within its range."""
    return None if max_memory is None else whole("max_memory", max_memory, 0, 2**63)


def _corners(bounds: ArrayLike) -> tuple[tuple[float, ...], tuple[float, ...]]:
    box = np.asarray(bounds)
    six = numbers("bounds", box.reshape(-1) if box.shape == (2, 3) else box, 6)
    low, high = six[:3], six[3:]
    if not all(np.isfinite(six)) or not all(a < b for a, b in zip(low, high, strict=True)):
        raise ValueError(f"bounds: the box from {low} to {high} is out of range; it must be finite, and its minimum below its maximum")
    return low, high
