"""Bakes in steps that many processes or machines can share."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _native
from ._arrays import threads_of, whole
from ._bake import BakeOptions, memory_of, options_of
from ._file import ShadowFile
from ._loading import LoadOptions, loading_of
from ._progress import Progress, reporting
from ._scene import Scene

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Part(NamedTuple):
    """A part of a plan."""

    id: int
    """Its number. Part 0 is the most costly one."""
    level: int
    """The level of detail that it belongs to; 0 is the finest."""
    cost: int
    """An estimate of the work. Costs can be compared only within one plan."""


class BakedPart(NamedTuple):
    """The result of baking a part."""

    id: int
    """The part."""
    blake3: str
    """The BLAKE3 of its entry's bytes, as hexadecimal digits."""
    baked: bool
    """Whether it was baked; false if its entry was there already."""


class Plan:
    """A planned bake. Its parts can be baked in any order, by any number of processes, and are then linked.

    Each part becomes an entry in a folder, the *cache*, which all processes share. An entry is complete or
    absent, so every step can be ended at any moment and run again: it then does only what is missing.
    :meth:`link` makes the file from the entries. The file has the bytes of :func:`bake`::

        plan = adumbra.Plan("city.glb", azimuth=140, elevation=35)
        for share in range(4):
            plan.bake(plan.shard(share, 4), cache="city.cache")
        shadows = plan.link("city.cache", "city.adumbra")

    A plan may be used from any number of threads, and can be pickled. Its file equals that of ``adumbra
    plan``.
    """

    def __init__(
        self, scene: str | os.PathLike[str], *, threads: int | None = None, **options: Unpack[BakeOptions]
    ) -> None:
        """Plan the bake of a scene.

        Args:
            scene: The path of a ``.glb``, ``.gltf``, ``.obj`` or ``.ply`` file. It must be the same for every process that bakes
                parts.
            threads: Number of threads, 1 to 1024. All cores unless it is given.
            **options: The options of :func:`bake` that decide what is baked, and those of :class:`LoadOptions`.

        Raises:
            ValueError: A value is out of its range.
            TypeError: The scene is not a path, or there is no such option.
            FormatError: The scene's file is broken, or holds nothing that casts a shadow.
            OSError: A file cannot be read.
            MemoryLimitError: The bake does not fit its memory limit.
        """
        self._prepare(planned(scene, None, threads, dict(options)))

    def _prepare(self, native: _native.Plan) -> None:
        self._native = native
        self._lock = threading.Lock()
        self._baker: tuple[object, _native.Baker] | None = None

    @classmethod
    def _of(cls, native: _native.Plan) -> Plan:
        plan = cls.__new__(cls)
        plan._prepare(native)
        return plan

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Plan:
        """Read the file of a plan, which :meth:`write` or ``adumbra plan`` wrote.

        Raises:
            OSError: The file cannot be read.
            FormatError: The file is not a plan, or was changed after it was written.
        """
        return cls._of(_native.Plan.read(os.fspath(path)))

    def write(self, path: str | os.PathLike[str]) -> int:
        """Write its file, and return the length in bytes. An earlier file is replaced as a whole.

        Raises:
            OSError: The file cannot be written.
        """
        return self._native.write(os.fspath(path))

    @property
    def digest(self) -> str:
        """The BLAKE3 of the plan, with the path of its scene and the options of the loader, as hexadecimal digits."""
        return self._native.digest

    @property
    def scene(self) -> str:
        """The path of the scene."""
        return os.fspath(self._native.scene)

    @property
    def parts(self) -> tuple[Part, ...]:
        """The parts, the most costly first."""
        return tuple(Part(id, level, cost) for id, (level, cost) in enumerate(self._native.parts))

    def shard(self, index: int, count: int) -> list[int]:
        """Return the ids of one of ``count`` shares of the parts with about the same cost each.

        Raises:
            ValueError: ``count`` is below 1, or ``index`` is not from 0 to ``count`` - 1.
        """
        shares = whole("count", count, 1, 2**32)
        return self._native.shard(whole("index", index, 0, shares - 1), shares)

    def bake(
        self,
        ids: Iterable[int] | None,
        cache: str | os.PathLike[str],
        *,
        scene: str | os.PathLike[str] | None = None,
        max_memory: int | None = None,
        threads: int | None = None,
        progress: Progress = False,
    ) -> list[BakedPart]:
        """Bake the parts whose entries are not in the cache yet.

        The first call loads the scene and prepares it, and later calls use that. Other Python threads run meanwhile. Ctrl-C
        stops the bake, and the parts that are done stay in the cache.

        Args:
            ids: The parts; ``None`` means all.
            cache: The folder of the cache. It is created if it does not exist.
            scene: The scene that was planned, if it has another path here.
            max_memory: Largest number of bytes that the bake may hold. Data that does not fit is kept in
                temporary files in ``cache``.
            threads: Number of threads, 1 to 1024. All cores unless it is given.
            progress: As for :func:`bake`.

        Returns:
            The result of each part, in the order of ``ids``.

        Raises:
            IndexError: The plan has no such part.
            ValueError: A value is out of its range.
            OSError: A file cannot be read or written.
            MemoryLimitError: The bake does not fit its memory limit.
            AdumbraError: The scene is not the one that was planned.
        """
        chosen = range(len(self._native.parts)) if ids is None else ids
        # Each part once, in the order of the ids.
        numbers = list(dict.fromkeys(whole("ids", id, 0, 2**32) for id in chosen))
        count = threads_of(threads)
        baker = self._baker_of(
            None if scene is None else os.fspath(scene), os.fspath(cache), (memory_of(max_memory), count)
        )
        with reporting(progress) as report:
            done, _ = baker.bake(numbers, os.fspath(cache), count, report)
        return [BakedPart(*part) for part in done]

    def _baker_of(self, scene: str | None, spill: str, limits: tuple[int | None, int | None]) -> _native.Baker:
        """Return the baker of the last call, or a new one if the scene, folder or memory limit differs."""
        wanted = (scene, spill, limits[0])
        with self._lock:
            if self._baker is None or self._baker[0] != wanted:
                self._baker = None
                self._baker = (wanted, self._native.baker(scene, spill, limits))
            return self._baker[1]

    def link(
        self,
        cache: str | os.PathLike[str],
        output: str | os.PathLike[str],
        *,
        sums: Mapping[int, str] | None = None,
        max_memory: int | None = None,
        threads: int | None = None,
        progress: Progress = False,
    ) -> ShadowFile:
        """Make the file from the entries of its parts. The scene is not needed.

        Args:
            cache: The folder of the cache.
            output: The shadow file to write. An earlier file is replaced as a whole, once the link has
                succeeded.
            sums: The BLAKE3 of the entries of parts, from :class:`BakedPart`. An entry with other bytes counts as missing.
            max_memory: Largest number of bytes that the link may hold.
            threads: Number of threads, 1 to 1024. All cores unless it is given.
            progress: As for :func:`bake`.

        Returns:
            The shadow file, in memory.

        Raises:
            MissingPartsError: Parts have not been baked. The message names one.
            MemoryLimitError: The link does not fit its memory limit.
            OSError: A file cannot be read or written.
            ValueError: A value is out of its range, or ``output`` is the scene.
        """
        limits = (memory_of(max_memory), threads_of(threads))
        with reporting(progress) as report:
            return ShadowFile(
                self._native.link(os.fspath(cache), os.fspath(output), dict(sums or {}), limits, report)
            )

    def __reduce__(self) -> tuple[Any, ...]:
        return _from_bytes, (self._native.to_bytes(),)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plan) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def __repr__(self) -> str:
        return f"<adumbra.Plan of {len(self._native.parts)} parts, of {self.scene}>"


def planned(
    scene: str | os.PathLike[str],
    output: str | os.PathLike[str] | None,
    threads: int | None,
    options: dict[str, Any],
) -> _native.Plan:
    """Plan a bake. First reject an output that cannot be written or is part of the scene."""
    if not isinstance(scene, (str, os.PathLike)):
        raise TypeError("scene: a plan needs the path of a file that every process can read")
    loading: Any = {name: options.pop(name) for name in LoadOptions.__annotations__ if name in options}
    loaded = Scene(scene, **loading)
    if output is not None:
        _native.check_path(loaded._native, os.fspath(output))
    return _native.Plan.new(
        loaded._native,
        os.fspath(scene),
        {**loading_of(loading), "edit": None},
        options_of(loaded, **options),
        threads_of(threads),
    )


def _from_bytes(data: bytes) -> Plan:
    return Plan._of(_native.Plan.from_bytes(data))
