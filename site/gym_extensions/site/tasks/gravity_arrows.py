"""Two arrows: the gravity of a task beside that of its base body."""

from __future__ import annotations

from markupsafe import Markup

from gym_extensions.site.charts.svg import picture

LENGTH, TOP = 80.0, 20
"""Length of the base body's arrow, and where arrows begin."""


def gravity_arrows(factor: float) -> Markup:
    """A picture of both arrows; their lengths are proportional to gravity."""
    arrows = _arrow(40, 1.0, "base", "× 1") + _arrow(120, factor, "changed", f"× {factor:g}")
    return picture("gravity", "160", "160", f"gravity {factor:g} times that of the base body", arrows)


def _arrow(x: int, factor: float, kind: str, label: str) -> str:
    tip = TOP + LENGTH * factor
    head = f"M{x} {TOP}V{tip:g}M{x - 7} {tip - 9:g}L{x} {tip:g}L{x + 7} {tip - 9:g}"
    return f'<path class="{kind}" d="{head}"/><text class="tick" x="{x}" y="12">{label}</text>'
