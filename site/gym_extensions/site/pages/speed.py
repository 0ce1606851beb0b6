"""Measured speed: the ratios that ``make bench`` writes, and the machine on which they were measured."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import TypedDict

from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import File, Page, Render
from gym_extensions.site.views.benchmarks import MEMORY, Measurement, comparison, peak_memory

PATH = "speed.html"
MEASURED = Path(__file__).parent.parent / "measured" / "ratios.json"


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


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """One page with a section per measure, the last one for memory."""
    measured: Measurements = json.loads(MEASURED.read_text(encoding="utf-8"))
    rows = measured["rows"]
    comparisons = [comparison(row) for row in rows if row["measure"] != MEMORY]
    chapters = [(title, list(part)) for title, part in groupby(comparisons, key=lambda item: item.title)]
    memory = [peak_memory(row) for row in rows if row["measure"] == MEMORY]
    yield PATH, render("speed.html", PATH, machine=measured["machine"], chapters=chapters, memory=memory)


PAGE = Page(title="Speed", order=80, path=PATH, publish=publish, in_footer=True)
