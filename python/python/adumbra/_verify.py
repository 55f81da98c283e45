"""Results of a comparison of a shadow file with rays."""

from __future__ import annotations

import json
from dataclasses import dataclass

from ._show import table


@dataclass(frozen=True)
class ClassResult:
    """The comparison in one class of points. Classes depend on rays alone."""

    name: str
    """``interior``, ``grazing``, ``ground``, ``edge``, ``narrow``, ``thin`` or ``edge-on``."""
    points: int
    """Number of points."""
    agreement: float
    """One minus the mean difference from the rays, 0 to 1; without a filter, the share of correct answers."""
    acne: int
    """Number of answers that are darker than the rays' by more than half."""
    leak: int
    """Number of answers that are lighter than the rays' by more than half."""
    misplaced: int
    """Number of wrong answers that the point's texel does not explain."""
    promised_agreement: float | None
    """The least agreement that is promised, if any."""
    promised_misplaced: float | None
    """The largest share of misplaced points that is promised, if any."""
    checked: bool
    """Whether something is promised, and there are enough points to check it."""
    passed: bool
    """Whether the promises are kept; true if the class is not checked."""


@dataclass(frozen=True)
class Verification:
    """The comparison of a file with rays, with the figures of ``adumbra verify --json``. Shares are 0 to 1."""

    samples: int
    """Number of points that were compared."""
    facing_away: int
    """Number of points that face away from the sun; not compared."""
    inside_solids: int
    """Number of points inside solids; not compared."""
    outside_bounds: int
    """Number of points outside the bounds that were given to the bake; not compared."""
    shadowed_share: float
    """Share of the samples that are shadowed according to rays."""
    agreement: float
    """One minus the mean difference from the rays; without a filter, the share of correct answers."""
    interior_agreement: float
    """Agreement of points whose neighbours all agree with them."""
    interior_share: float
    """Share of the samples that are interior points."""
    acne: float
    """Share of the samples whose answer is darker than the rays' by more than half."""
    leak: float
    """Share of the samples whose answer is lighter than the rays' by more than half."""
    classes: tuple[ClassResult, ...]
    """The results of all classes."""
    checked: bool
    """Whether there are enough points to check the file."""
    passed: bool
    """Whether the file is checked, and every class keeps its promises."""

    @classmethod
    def _of(cls, text: str, checked: bool, passed: bool) -> Verification:
        fields = json.loads(text)
        classes = tuple(
            ClassResult(name=row.pop("class"), passed=row.pop("holds"), **row) for row in fields.pop("classes")
        )
        return cls(**fields, classes=classes, checked=checked, passed=passed)

    def _repr_html_(self) -> str:
        rows = [
            ("passed", "yes" if self.passed else "no" if self.checked else "too few points to check"),
            ("points", f"{self.samples:,}"),
            ("agreement", f"{100 * self.agreement:.4f} %"),
            ("agreement inside and outside shadows", f"{100 * self.interior_agreement:.4f} %"),
        ]
        classes = [(f"{c.name}, {c.points:,} points", f"{100 * c.agreement:.4f} %") for c in self.classes if c.points]
        return table("adumbra.Verification", rows + classes)
