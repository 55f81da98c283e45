"""Options of loading a scene from a file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, TypedDict

from ._axes import Up, axis_of


class LoadOptions(TypedDict, total=False):
    """Options of everything that loads a scene from a file."""

    only: Sequence[str]
    """Load only triangles of nodes, meshes or materials whose name matches one of these patterns."""
    exclude: Sequence[str]
    """Skip triangles of nodes, meshes or materials whose name matches one of these patterns."""
    ignore_alpha: bool
    """Treat masked and blended materials as opaque."""
    include_animated: bool
    """Load animated instances as static ones, in their first pose. Without it they are skipped."""
    up: Up | None
    """The axis that points up in an OBJ or PLY file. ``None`` takes Y, and warns if the scene looks otherwise. In glTF, Y points
    up by definition."""
    allow_outside: bool
    """Also read files outside the scene's folder. Only for scenes that you trust."""
    strict: bool
    """Reject a scene if the loader would leave anything out."""


def as_baked(scene: Any, options: dict[str, Any], up: str) -> dict[str, Any]:
    """Return loading options, with a shadow file's up axis if the scene is a path of a format without one."""
    is_open = options.get("up") is None and isinstance(scene, (str, os.PathLike))
    has_none = is_open and not os.fsdecode(scene).lower().endswith((".glb", ".gltf"))
    return {**options, "up": up} if has_none else options


def loading_of(options: dict[str, Any]) -> dict[str, Any]:
    """Return the options of the loader as the native part takes them."""
    unknown = sorted(options.keys() - LoadOptions.__annotations__.keys())
    if unknown:
        raise TypeError(f"{unknown[0]!r} is not an option; those of loading are {', '.join(LoadOptions.__annotations__)}")
    up = options.get("up")
    return {
        "only": _patterns("only", options.get("only", ())),
        "exclude": _patterns("exclude", options.get("exclude", ())),
        "ignore_alpha": bool(options.get("ignore_alpha", False)),
        "include_animated": bool(options.get("include_animated", False)),
        "up": None if up is None else axis_of(up),
        "allow_outside": bool(options.get("allow_outside", False)),
        "strict": bool(options.get("strict", False)),
    }


def _patterns(name: str, patterns: Sequence[str]) -> list[str]:
    if isinstance(patterns, str):
        raise TypeError(f"{name}: give a list of patterns, such as [{patterns!r}]")
    return list(patterns)
