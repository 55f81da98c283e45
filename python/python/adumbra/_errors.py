"""The package's own exceptions and warnings."""

from __future__ import annotations

import sys
import warnings


class AdumbraError(Exception):
    """Any error without a suitable built-in exception, such as a bake that does not fit its memory limit."""


class FormatError(AdumbraError, ValueError):
    """A shadow file or a scene is broken, or is of another kind. The message says where, and what to do."""


class MemoryLimitError(AdumbraError):
    """A scene or a bake does not fit its memory limit, or has more than a file can hold."""


class MissingPartsError(AdumbraError):
    """Parts of a plan have not been baked yet, or their entries are damaged. Bake them, then link again."""


class SceneWarning(UserWarning):
    """A scene was loaded or made, but parts were left out or changed, or it looks wrong. The message says which."""


def warn(text: str) -> None:
    """Warn of a scene, at the line that called the package."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("adumbra."):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, SceneWarning, stacklevel=level)


for _class in (AdumbraError, FormatError, MemoryLimitError, MissingPartsError, SceneWarning):
    _class.__module__ = "adumbra"
