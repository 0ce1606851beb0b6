"""The page Speed: the ratios that ``make bench`` writes, as comparisons and peak memory."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any, NamedTuple

from markupsafe import Markup

from gym_extensions.site import FOLDER
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.pages.page import File, Render

MEASURED = FOLDER / "measured" / "ratios.json"
MEMORY = "memory"
"""The measure whose rows compare peak memory with a limit."""
TITLES = {
    "navigation": "Navigation",
    "stepping, raw": "Stepping compared with raw physics",
    "stepping, peers": "Stepping compared with other libraries",
    "number of environments": "Stepping by number of environments",
    "wall and sensor": "Wall and sensor",
    "training": "Training",
}
"""The title of each measure."""
SETTINGS = {
    "environments": ("environment", "environments"),
    "threads": ("thread", "threads"),
    "episodes": ("episode", "episodes"),
    "batch": ("step per batch", "steps per batch"),
}
"""The settings of a comparison that are shown, with their names in singular and plural."""
Row = Mapping[str, Any]


def publish(_site: Leaderboard, render: Render) -> Iterator[File]:
    """Measured speed, a section per measure, the last one for memory."""
    yield "speed.html", render("speed.html", "speed.html", speed_bar=speed_bar, **measured())


@dataclass(frozen=True)
class Variant:
    """One variant of a comparison.

    Args:
        name: its name.
        speed: median speed per second.
        share: the speed relative to the fastest variant.
        ratio: the first variant's speed relative to this one's; None for the first.
        target: the ratio that was aimed at, if any.
    """

    name: str
    speed: float
    share: float
    ratio: float | None
    target: float | None


class Comparison(NamedTuple):
    """Variants that were measured in turns in one run; the first is this project's."""

    task: str
    settings: str
    variants: list[Variant]


def measured() -> dict[str, Any]:
    """The machine, the comparisons by title, and peak memory as (process, GB, limit in GB)."""
    document = json.loads(MEASURED.read_text(encoding="utf-8"))
    rows = [row for row in document["rows"] if row["measure"] != MEMORY]
    return {
        "machine": document["machine"],
        "chapters": [
            (TITLES[measure], [comparison(row) for row in part])
            for measure, part in groupby(rows, key=lambda row: row["measure"])
        ],
        "memory": [peak_memory(row) for row in document["rows"] if row["measure"] == MEMORY],
    }


def comparison(row: Row) -> Comparison:
    """The comparison in a row of ``ratios.json``."""
    speeds = row["per_second"]
    variants = [
        Variant(name, speed, speed / max(speeds.values()), row["ratios"].get(name), row["bars"].get(name))
        for name, speed in speeds.items()
    ]
    values = [(row[key], *names) for key, names in SETTINGS.items() if key in row]
    settings = ", ".join(f"{value} {one if value == 1 else many}" for value, one, many in values)
    return Comparison(row["task"], settings, variants)


def peak_memory(row: Row) -> tuple[str, float, float]:
    """Process, peak and limit in GB of a row whose only ratio is named by the limit, as ``1.5 GB``."""
    name, *_ = row["per_second"]
    ((limit, ratio),) = row["ratios"].items()
    return name, float(limit.removesuffix(" GB")) / ratio, float(limit.removesuffix(" GB"))


BAR_WIDTH, BAR_HEIGHT = 220, 12


def speed_bar(variant: Variant) -> Markup:
    """The speed as a bar, on the scale of the fastest variant of the comparison."""
    kind = "own" if variant.ratio is None else "other"
    return Markup(
        f'<svg class="speed" viewBox="0 0 {BAR_WIDTH} {BAR_HEIGHT}" aria-hidden="true">'
        f'<rect class="{kind}" width="{variant.share * BAR_WIDTH:.1f}" height="{BAR_HEIGHT}"/></svg>'
    )
