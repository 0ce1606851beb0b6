"""The part of the findings on other orders: it is there as soon as there are such runs."""

from collections.abc import Callable
from pathlib import Path

import pytest
from jinja2 import Template

from gym_extensions import results
from gym_extensions.catalog.protocol import task_order
from gym_extensions.scoring.pipeline import make_scorer, valid_scorecards
from tools.findings import findings, orders

from ..conftest import MANIFEST


def by_position(level: float, run: int, position: int, episode: int, protocol: str) -> float:
    place = task_order(protocol, run, 5).index(position - 1)
    return level + 20 * place + (run + 1) * (episode - 9.5) / 100


def section() -> Template:
    text = (Path(findings.__file__).parent / "page.md.jinja").read_text(encoding="utf-8")
    return findings.jinja().from_string(
        text[text.index("### Other orders") : text.index("### The same additions")]
    )


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
    frames = results.metrics(everything), results.order_effects(everything)
    assert orders.orders(*frames, "descending") == []
    (found,) = orders.orders(*frames, "balanced")
    assert (found.group, found.agreement) == ("hopper-gravity", -1.0)
    places = [[found.place(name, at) for at in (0, 1)] for name in "abc"]
    assert places == [["3. ", "1. "], ["2. ", "2. "], ["1. ", "3. "]]
    alone = orders.Orders("hopper-gravity", {"a": found.ends["a"]}, None, {}, {})
    assert alone.place("a", 0) == ""
    assert list(found.shares) == ["a"]
    assert found.shares["a"][0][0].mean == pytest.approx(1)
    page = section()
    assert "wait to be trained" in page.render(balanced=[])
    lines = page.render(balanced=[found]).splitlines()
    first, second = (at for at, line in enumerate(lines) if line.startswith("|---"))
    assert [line.count("|") for line in lines[first : first + 5]] == [5, 5, 5, 5, 0]
    assert [line.count("|") for line in lines[second : second + 2]] == [8, 8]


@pytest.mark.usefixtures("known")
def test_methods_are_placed_among_those_with_runs_in_the_same_order(
    make_submission: Callable[..., Path],
) -> None:
    """Descending runs are of another edition than balanced ones, as the ascending runs beside them."""
    for name, other in (("a", "descending"), ("b", "balanced"), ("c", "balanced")):
        protocols, manifest = ("sequential", other), MANIFEST.replace("smoke", "300k")
        folder = make_submission(name=f"all/{name}", runs=(0, 1), protocols=protocols, manifest=manifest)
    frames = results.metrics(folder.parent), results.order_effects(folder.parent)
    found = {other: orders.orders(*frames, other) for other in ("descending", "balanced")}
    assert {other: list(each.ends) for other, (each,) in found.items()} == {
        "descending": ["a"],
        "balanced": ["b", "c"],
    }


@pytest.mark.usefixtures("known")
def test_what_the_descending_order_changes_is_told_by_task(make_submission: Callable[..., Path]) -> None:
    folder = make_submission(
        name="all/a",
        runs=(0, 1),
        protocols=("sequential", "descending"),
        value=lambda protocol, run, stage, at, episode: by_position(0, run, at, episode, protocol),
    )
    make_submission(name="all/b", runs=(0, 1))
    cards = list(valid_scorecards(folder.parent, make_scorer()).values())
    (found,) = orders.turned(cards)
    assert (found.group, found.method) == ("hopper-gravity", "a")
    ascending, descending = ([value.mean for value in ends] for ends in found.ends)
    # The score rises with the position, so the first task of the group gains what the last one loses.
    assert descending[0] - ascending[0] == pytest.approx(ascending[-1] - descending[-1])
    assert descending[0] > ascending[0]
    assert found.changes[1].mean == pytest.approx(0)
    page = findings.jinja().get_template("first-edition.md.jinja")
    facts = {"fine_tuning": "trpo", "transfer_titles": [], "transfers": [], "practice": []}
    lines = page.render(descending=[], turned=[found], **facts).partition("## Whether")[0].splitlines()
    assert [line.count("|") for line in lines if line.startswith("|")] == [5] * 2 + [9] * 4 + [6] * 3
