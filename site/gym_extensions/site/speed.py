"""Measured speed: the ratios that ``make bench`` writes, as comparisons and peak memory.

``ratios.json`` keeps the keys with which the benchmarks write it; the tables below give them labels.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

from markupsafe import Markup

MEASURED = Path(__file__).parent / "measured" / "ratios.json"
MEMORY = "memory"
"""The measure whose rows compare peak memory with a limit."""
TITLES = {
    "navigation": "Navigation",
    "stepping, raw": "Stepping compared with raw physics",
    "stepping, peers": "Stepping compared with other libraries",
    "lanes": "Stepping by number of environments",
    "wall and sensor": "Wall and sensor",
    "training": "Training",
}
"""The title of each measure; others are shown as they are written."""
SETTINGS = {
    "lanes": ("environment", "environments"),
    "threads": ("thread", "threads"),
    "episodes": ("episode", "episodes"),
    "batch": ("step per batch", "steps per batch"),
}
"""The settings of a comparison that are shown, with their names in singular and plural."""
VARIANTS = {"make_batch": "make_vec"}
"""Variants whose name in the committed measurements is older than the public one."""


class Measurement(TypedDict, total=False):
    """A row of ``ratios.json``: median speeds, ratios of the first speed to the others, and targets."""

    measure: str
    task: str
    lanes: int
    threads: int
    episodes: int
    batch: int
    rounds: int
    per_second: dict[str, float]
    ratios: dict[str, float]
    bars: dict[str, float]


class Machine(TypedDict):
    """The machine of the measurements."""

    processor: str
    cores: int
    system: str
    python: str
    packages: dict[str, str]


class Measurements(TypedDict):
    """The content of ``ratios.json``."""

    format: int
    machine: Machine
    rows: list[Measurement]


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
    ratio: float | None = None
    target: float | None = None

    @property
    def reached(self) -> bool | None:
        """Whether the ratio reaches its target; None without a target."""
        return None if self.target is None or self.ratio is None else self.ratio >= self.target


@dataclass(frozen=True)
class Comparison:
    """Variants that were measured in turns in one run; the first is this project's."""

    measure: str
    task: str
    settings: str
    variants: tuple[Variant, ...]

    @property
    def title(self) -> str:
        """The title of what was measured."""
        return TITLES.get(self.measure, self.measure.capitalize())


@dataclass(frozen=True)
class PeakMemory:
    """The peak memory of a whole process, and its limit, in GB."""

    name: str
    limit: float
    ratio: float

    @property
    def peak(self) -> float:
        """Peak memory in GB."""
        return self.limit / self.ratio

    @property
    def within_limit(self) -> bool:
        """Whether the peak stays within the limit."""
        return self.ratio >= 1


def comparison(row: Measurement) -> Comparison:
    """The comparison in a row of ``ratios.json``."""
    speeds = row["per_second"]
    fastest = max(speeds.values())
    variants = [
        Variant(label(name), speed, speed / fastest, row["ratios"].get(name), row["bars"].get(name))
        for name, speed in speeds.items()
    ]
    return Comparison(row["measure"], row.get("task", ""), _settings(row), tuple(variants))


def peak_memory(row: Measurement) -> PeakMemory:
    """The peak memory in a row of ``ratios.json``, whose only ratio is named by the limit, as ``1.5 GB``."""
    name, *_ = row["per_second"]
    ((limit, ratio),) = row["ratios"].items()
    return PeakMemory(label(name), float(limit.removesuffix(" GB")), ratio)


def label(name: str) -> str:
    """The public name of a variant: lanes are environments."""
    renamed = re.sub(r"^(\d+)( \w+)? lanes$", r"\1\2 environments", VARIANTS.get(name, name))
    return re.sub(r"^1 environments$", "1 environment", renamed)


def _settings(row: Mapping[str, object]) -> str:
    values = [(row[key], *names) for key, names in SETTINGS.items() if key in row]
    return ", ".join(f"{value} {one if value == 1 else many}" for value, one, many in values)


BAR_WIDTH, BAR_HEIGHT = 220, 12


def speed_bar(variant: Variant) -> Markup:
    """The speed as a bar, on the scale of the fastest variant of the comparison."""
    kind = "own" if variant.ratio is None else "other"
    return Markup(
        f'<svg class="speed" viewBox="0 0 {BAR_WIDTH} {BAR_HEIGHT}" aria-hidden="true">'
        f'<rect class="{kind}" width="{variant.share * BAR_WIDTH:.1f}" height="{BAR_HEIGHT}"/></svg>'
    )
