"""How fast it is: the ratios that `make bench` measured, with the machine that they were measured on."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

from gym_extensions.site.page import Leaderboard, Page, Render
from gym_extensions.site.views.benchmarks import Race, race
from gym_extensions.site.views.memory import MEASURE, footprint

PATH = "speed.html"
MEASURED = Path(__file__).parent.parent / "measured" / "ratios.json"


def publish(site: Leaderboard, render: Render) -> Iterator[tuple[str, str]]:
    """One page, a section for each measure; memory has its own words."""
    measured = json.loads(MEASURED.read_text(encoding="utf-8"))
    races = [race(row) for row in measured["rows"] if row["measure"] != MEASURE]
    footprints = [footprint(row) for row in measured["rows"] if row["measure"] == MEASURE]
    chapters: list[tuple[str, list[Race]]] = [
        (measure, list(found)) for measure, found in groupby(races, key=lambda one: one.measure)
    ]
    found = {"chapters": chapters, "footprints": footprints}
    yield PATH, render("speed.html", PATH, machine=measured["machine"], **found)


PAGE = Page(title="Speed", order=25, path=PATH, publish=publish)
