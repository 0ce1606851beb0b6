"""One measured comparison as the page shows it: contestants, their speeds, how ours compares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

WIDTH, HEIGHT = 220, 12
ABOUT = ("lanes", "threads", "episodes", "batch", "limit_gb")


@dataclass(frozen=True)
class Contestant:
    """One of a race: its median speed, how many times as fast ours is, and the bar that was set for that."""

    name: str
    speed: float
    share: float
    ratio: float | None = None
    bar: float | None = None

    @property
    def reached(self) -> bool | None:
        """Whether ours reaches its bar; None where none was set."""
        return None if self.bar is None or self.ratio is None else self.ratio >= self.bar

    @property
    def drawing(self) -> Markup:
        """The speed as a bar, on the scale of the fastest of its race."""
        kind = "own" if self.ratio is None else "other"
        return Markup(
            f'<svg class="speed" viewBox="0 0 {WIDTH} {HEIGHT}" aria-hidden="true">'
            f'<rect class="{kind}" width="{self.share * WIDTH:.1f}" height="{HEIGHT}"/></svg>'
        )


@dataclass(frozen=True)
class Race:
    """Contestants that took turns in one run; the first is ours."""

    measure: str
    task: str
    about: str
    contestants: tuple[Contestant, ...]


def race(row: Mapping[str, Any]) -> Race:
    """A row of the ratios' file."""
    speeds: Mapping[str, float] = row["per_second"]
    fastest = max(speeds.values())
    about = ", ".join(f"{row[name]} {name}" for name in ABOUT if name in row)
    found = [
        Contestant(name, speed, speed / fastest, row["ratios"].get(name), row["bars"].get(name))
        for name, speed in speeds.items()
    ]
    return Race(row["measure"], row.get("task", ""), about, tuple(found))
