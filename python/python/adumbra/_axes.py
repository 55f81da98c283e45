"""The axis that points up."""

from __future__ import annotations

from typing import Any, Literal

Up = Literal["y", "z"]
Vector = tuple[float, float, float]


def axis_of(up: Any) -> Up:
    """Return an axis that points up."""
    if up == "y":
        return "y"
    if up == "z":
        return "z"
    raise ValueError(f"up: {up!r} is not an axis; it must be 'y' or 'z'")
