"""Shadow files."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal
from urllib.request import Request, urlopen

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import places_of, threads_of, whole
from ._axes import Up, Vector
from ._errors import warn
from ._loading import LoadOptions, as_baked
from ._scene import SceneLike, scene_of
from ._show import table
from ._verify import Verification

if TYPE_CHECKING:
    from typing_extensions import Unpack

Stored = Literal["coded", "raw"]


class ShadowFile:
    """A baked sun's shadows: which points see the sun.

    :func:`bake` and :meth:`open` return one. All coordinates are those of the scene's file or arrays, in which :attr:`up` points
    up. It never changes, may be used from any number of threads, and can be pickled.
    """

    def __init__(self, native: _native.File) -> None:
        self._native = native

    @classmethod
    def open(cls, source: str | os.PathLike[str] | bytes | bytearray | memoryview, *, timeout: float = 60.0) -> ShadowFile:
        """Read a shadow file.

        Args:
            source: The file's path, an address that begins with ``http://`` or ``https://``, or the file's bytes.
            timeout: Seconds to wait for an answer of the server.

        Raises:
            OSError: The file cannot be read; ``FileNotFoundError`` if there is none, ``urllib.error.URLError`` for an address.
            FormatError: The data is not exactly one valid shadow file.
        """
        if isinstance(source, (bytes, bytearray, memoryview)):
            return cls(_native.File.from_bytes(bytes(source)))
        if isinstance(source, str) and source.lower().startswith(("http://", "https://")):
            with urlopen(Request(source, headers={"User-Agent": "adumbra"}), timeout=timeout) as answer:
                return cls(_native.File.from_bytes(answer.read()))
        return cls(_native.File.read(os.fspath(source)))

    def to_bytes(self, encoding: Stored | None = None) -> bytes:
        """Return the bytes that :meth:`save` writes."""
        return self._native.to_bytes(self.encoding if encoding is None else encoding)

    def save(self, path: str | os.PathLike[str], encoding: Stored | None = None) -> int:
        """Write the file, and return its length in bytes. An earlier file is replaced as a whole.

        Args:
            path: The file.
            encoding: ``"coded"``, which takes about a third of the bytes, or ``"raw"``, as in memory. By
                default, the encoding in which the file was baked or read.

        Raises:
            OSError: The file cannot be written.
            ValueError: The encoding is unknown.
        """
        return self._native.write(os.fspath(path), self.encoding if encoding is None else encoding)

    def level(self, level: int) -> ShadowFile:
        """Return a level of detail with all coarser ones. It shares the voxels, so this is cheap.

        Args:
            level: 0 is the finest. Each has voxels four times as large as the one before.

        Raises:
            IndexError: There is no such level.
        """
        found = self._native.level(level) if 0 <= level < self.levels else None
        if found is None:
            raise IndexError(f"level {level} is out of range; it must be from 0 to {self.levels - 1}")
        return ShadowFile(found)

    def visibility(
        self,
        points: ArrayLike,
        normals: ArrayLike | None = None,
        filter: int = 5,
        *,
        bias_constant: float | None = None,
        bias_slope: float | None = None,
        bias_normal: float | None = None,
        threads: int | None = None,
    ) -> NDArray[np.float32]:
        """Look up which points see the sun.

        Runs on all cores; other Python threads run meanwhile. Contiguous arrays of float32 or float64 are read in place, and
        must not be changed meanwhile; others are copied first. Points that are sorted by position take less
        time.

        Args:
            points: Positions, shape (N, 3), of any real type. Far from the origin, float32 rounds them to whole voxels. A point
                that is not finite is lit.
            normals: Unit normals of the surfaces that the points are on, shape (N, 3). They determine the
                slope bias and the plane that the filter follows. A normal that is not finite is ignored.
                Leave them out for points in free space.
            filter: Texels along the side of the square whose mean is returned: 1, 3, 5, 9 or 17.
            bias_constant: Distance towards the sun by which points are moved first, 0 to 16 texels. By
                default, the value of the file.
            bias_slope: Distance towards the sun per unit of slope, 0 to 16 texels. By default, the value of
                the file.
            bias_normal: Distance along the normal, 0 to 16 texels. By default, the value of the file.
            threads: Number of threads, 1 to 1024. All cores unless it is given.

        Returns:
            Visibilities, shape (N,), float32: 1 sees the sun, 0 does not.

        Raises:
            ValueError: A shape, the filter or a bias is out of range.
            TypeError: An array does not hold real numbers.
        """
        look_up = _look_up(filter, bias_constant, bias_slope, bias_normal)
        return self._native.visibility(places_of(points, normals), look_up, threads_of(threads))

    def verify(
        self,
        scene: SceneLike,
        *,
        samples: int = 1_000_000,
        seed: int = 1,
        volume: bool = False,
        filter: int = 1,
        bias_constant: float | None = None,
        bias_slope: float | None = None,
        bias_normal: float | None = None,
        min_interior: float | None = None,
        threads: int | None = None,
        **loading: Unpack[LoadOptions],
    ) -> Verification:
        """Compare the file with rays at random points, as ``adumbra verify`` does.

        Other Python threads run meanwhile. Ctrl-C stops it.

        Args:
            scene: The scene that the file was baked from, loaded with the same options.
            samples: Number of points, 1 to 10**9.
            seed: Seed of the points, 0 to 2**64 - 1.
            volume: Take points in free space instead of points on surfaces, for files baked with ``assume_ground=False``.
            filter: Filter of the look-ups, see :meth:`visibility`.
            bias_constant: See :meth:`visibility`.
            bias_slope: See :meth:`visibility`.
            bias_normal: See :meth:`visibility`.
            min_interior: Agreement of interior points, 0 to 1, below which :attr:`Verification.passed` is false. 0.999, or 0.995
                with a filter, unless it is given.
            threads: Number of threads, 1 to 1024. All cores unless it is given.
            **loading: Options for a scene that is given by its path, see :class:`LoadOptions`.

        Warns:
            SceneWarning: The scene does not have as many triangles as the file was baked from.

        Raises:
            ValueError: A value is out of range, or ``volume`` is given for a file that was baked with assumed
                ground.
            OSError: The scene cannot be read.
            FormatError: The scene is broken.
        """
        if volume and self._native.assume_ground:
            raise ValueError(
                "volume: the file was baked with ground assumed, so it promises nothing about points in free space; "
                "bake it with assume_ground=False"
            )
        if min_interior is not None and not 0.0 <= min_interior <= 1.0:
            raise ValueError(f"min_interior: {min_interior} is out of range; it must be from 0 to 1")
        options = {
            "samples": whole("samples", samples, 1, 10**9),
            "seed": whole("seed", seed, 0, 2**64 - 1),
            "volume": bool(volume),
            "min_interior": None if min_interior is None else float(min_interior),
            "threads": threads_of(threads),
        }
        look_up = _look_up(filter, bias_constant, bias_slope, bias_normal)
        loaded = scene_of(scene, as_baked(scene, dict(loading), self._native.up))
        if loaded._native.casting_triangles != self.triangles:
            said = f"the file was baked from {self.triangles} triangles, and the scene has {loaded._native.casting_triangles}"
            warn(said)
        json, checked, passed = _native.verify(self._native, loaded._native, look_up, options)
        return Verification._of(json, checked, passed)

    @property
    def to_sun(self) -> Vector:
        """The unit vector towards the sun."""
        x, y, z = self._native.to_sun
        return x, y, z

    @property
    def up(self) -> Up:
        """The axis that points up: ``"y"`` or ``"z"``."""
        return self._native.up

    @property
    def resolution(self) -> int:
        """Texels on the longest side of the scene as the sun sees it."""
        return self._native.resolution

    @property
    def size(self) -> tuple[int, int, int]:
        """Number of voxels along x, y and z of the grid; z is along the light."""
        x, y, z = self._native.size
        return x, y, z

    @property
    def voxel_size(self) -> float:
        """Edge of a voxel, in world units."""
        return self._native.voxel_size

    @property
    def levels(self) -> int:
        """Number of levels of detail, at least 1."""
        return self._native.levels

    @property
    def bytes(self) -> int:
        """Length of the file in bytes, stored as :attr:`encoding` says."""
        return self._native.stored_bytes

    @property
    def encoding(self) -> Stored:
        """How the file was baked or read, and how :meth:`save` writes it by default: ``"coded"`` or ``"raw"``."""
        return self._native.encoding

    @property
    def frame(self) -> Literal["light", "oblique"]:
        """Orientation of the grid: across the light, or over level ground."""
        return self._native.frame

    @property
    def yaw(self) -> float | None:
        """Turn of an oblique grid in degrees, from +X to its x axis, clockwise as seen from above."""
        return self._native.yaw

    @property
    def bounds(self) -> tuple[Vector, Vector] | None:
        """The two corners of the box that was given to the bake, in world units, if one was."""
        found = self._native.bounds
        if found is None:
            return None
        low, high = found
        return (low[0], low[1], low[2]), (high[0], high[1], high[2])

    @property
    def bias(self) -> Vector:
        """The look-up bias that the file was baked for, in texels: constant, per unit of slope, along the normal."""
        return self._native.bias

    @property
    def triangles(self) -> int:
        """Number of triangles that were baked, counting every instance."""
        return self._native.triangles

    @property
    def info(self) -> dict[str, Any]:
        """All that the file says about itself: the properties of this class, and the other settings of the bake."""
        names = ("to_sun", "up", "resolution", "size", "voxel_size", "levels", "bytes", "encoding", "frame", "yaw", "bounds")
        settings = ("thickness", "switch_within", "assume_ground", "closed_regions", "receivers", "ignore_alpha")
        return {
            **{name: getattr(self, name) for name in names},
            "bias": self.bias,
            "triangles": self.triangles,
            **{name: getattr(self._native, name) for name in settings},
        }

    def __eq__(self, other: object) -> bool:
        return self._native == other._native if isinstance(other, ShadowFile) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return ShadowFile.open, (self.to_bytes(),)

    def __repr__(self) -> str:
        sun = ", ".join(f"{c:.4g}" for c in self.to_sun)
        return f"<adumbra.ShadowFile of {self.resolution} texels for the sun ({sun}), voxels of {self.voxel_size:.4g}>"

    def _repr_html_(self) -> str:
        def text(value: Any) -> str:
            if isinstance(value, tuple):
                return ", ".join(map(text, value))
            return f"{value:.6g}" if isinstance(value, float) else str(value)

        return table("adumbra.ShadowFile", [(name.replace("_", " "), text(value)) for name, value in self.info.items()])


def _look_up(
    filter: int, constant: float | None, slope: float | None, normal: float | None
) -> tuple[int, tuple[float | None, float | None, float | None]]:
    terms = [None if term is None else float(term) for term in (constant, slope, normal)]
    return whole("filter", filter, 0, 2**32 - 1), (terms[0], terms[1], terms[2])
