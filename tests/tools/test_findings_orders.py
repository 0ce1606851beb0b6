"""The part of the findings on other orders: it is there as soon as there are such runs."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from jinja2 import Environment, FileSystemLoader

from gym_extensions import results
from gym_extensions.catalog.protocol import task_order
from gym_extensions.site.text import fixed
from tools.findings import findings, orders, tables

from ..conftest import MANIFEST


def by_position(level: float, run: int, position: int, episode: int, protocol: str) -> float:
    place = task_order(protocol, run, 5).index(position - 1)
    return level + 20 * place + (run + 1) * (episode - 9.5) / 100


@pytest.mark.usefixtures("known")
def test_the_section_appears_with_runs_in_other_orders(make_submission: Callable[..., Path]) -> None:
    for name, level in (("a", 100.0), ("b", 130.0), ("c", 160.0)):
        folder = make_submission(
            name=f"all/{name}",
            runs=tuple(range(10)) if name == "a" else (0, 1),
            protocols=("sequential", "balanced"),
            manifest=MANIFEST.replace("smoke", "300k"),
            value=lambda protocol, run, stage, at, episode, level=level: by_position(
                level if protocol == "sequential" else -level, run, at, episode, protocol
            ),
        )
    everything = folder.parent
    (found,) = orders.orders(results.metrics(everything), results.order_effects(everything))
    assert (found.group, found.agreement) == ("hopper-gravity", {("sequential", "balanced"): -1.0})
    assert [[found.place(name, at) for at in (0, 1, 2)] for name in "abc"] == [
        ["3. ", "", "1. "],
        ["2. ", "", "2. "],
        ["1. ", "", "3. "],
    ]
    assert list(found.shares) == ["a"]
    assert found.shares["a"][0][0].mean == pytest.approx(1)
    assert math.isnan(found.ends["a"][1].mean)
    text = (Path(findings.__file__).parent / "page.md.jinja").read_text(encoding="utf-8")
    part = text[text.index("{% if orders %}") : text.index("### The same additions")]
    environment = Environment(loader=FileSystemLoader("."), trim_blocks=True)
    environment.globals.update(fmt=partial(fixed, digits=2), percent=tables.percent)
    page = environment.from_string(part)
    assert page.render(orders=[]).strip() == ""
    lines = page.render(orders=[found]).splitlines()
    first, second = (at for at, line in enumerate(lines) if line.startswith("|---"))
    assert [line.count("|") for line in lines[first : first + 5]] == [6, 6, 6, 6, 0]
    assert [line.count("|") for line in lines[second : second + 2]] == [8, 8]
