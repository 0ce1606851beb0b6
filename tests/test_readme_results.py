"""The results on the README's first screen are those of docs/findings.md, cell by cell."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
README = " ".join((ROOT / "README.md").read_text("utf-8").split())
FINDINGS = (ROOT / "docs" / "findings.md").read_text("utf-8")
FORGETTING, TRANSFER, LEARNERS = (
    "Where fine-tuning forgets",
    "Whether earlier tasks help fine-tuning",
    "Other learners",
)
HOPPER, HALFCHEETAH = "hopper-gravity", "halfcheetah-gravity"

Cell = tuple[str, str, str]
"""A heading, the first cells of a row, and a column."""

SENTENCES: tuple[tuple[str, tuple[Cell, ...]], ...] = (
    (
        "The scores of earlier tasks fall by {} on Hopper's gravity tasks, by {} on HalfCheetah's and by {} "
        "on Walker2d's wall tasks.",
        tuple((FORGETTING, name, "forgetting") for name in (HOPPER, HALFCHEETAH, "walker2d-wall")),
    ),
    (
        "On Hopper's gravity tasks, behavioral cloning of 1,000 stored states per task ends at {mean}, "
        "fine-tuning at {mean} and fresh networks for every task at {mean}.",
        tuple((HOPPER, name, "at the end") for name in ("cloning", "trpo", "reset")),
    ),
    (
        "Right after its training, a gravity task of Hopper scores {} more than one that is learned alone. "
        "Walker2d's body tasks end at {}, twice the score of the reference agent, and Humanoid's at {}: "
        "after fourteen tasks it stays upright longer.",
        (
            (TRANSFER, HOPPER, "Asymptotic transfer"),
            (FORGETTING, "walker2d-body", "at the end"),
            (FORGETTING, "humanoid-body", "at the end"),
        ),
    ),
    (
        "Training on all gravity tasks at once ends {} above fine-tuning on HalfCheetah. On Hopper the "
        "difference is {}; its interval contains 0.",
        tuple((TRANSFER, name, "Joint gap") for name in (HALFCHEETAH, HOPPER)),
    ),
    (
        "On Hopper's gravity tasks, SAC that keeps its replay buffer across tasks has a forgetting of {}: "
        "earlier tasks improved. SAC whose buffer is emptied for each task has {}.",
        tuple((LEARNERS, f"{HOPPER}, {name}", "forgetting") for name in ("sac", "sac-fresh-buffer")),
    ),
)
END = "at the end, minus fine-tuning"


def rows(heading: str) -> dict[str, dict[str, str]]:
    """The first table below a heading: its cells by row and column. A row of a learner is named by two."""
    section = re.split(rf"^##+ {re.escape(heading)}$", FINDINGS, flags=re.MULTILINE)[1]
    lines = re.findall(r"(?:^\|.*\n)+", section.replace("`", ""), flags=re.MULTILINE)[0].splitlines()
    columns, _, *cells = ([cell.strip() for cell in line.strip("|").split("|")] for line in lines)
    keys = 2 if "learner" in columns else 1
    return {", ".join(row[:keys]): dict(zip(columns, row, strict=True)) for row in cells}


def shown(cell: str) -> str:
    """A cell as the README prints it, without zeros before the point."""
    return re.sub(r"(?<!\d)0(?=\.\d)", "", cell)


def test_a_cell_is_shown_without_zeros_before_the_point() -> None:
    assert shown("0.70 (−0.29 to 10.05)") == ".70 (−.29 to 10.05)"


@pytest.mark.parametrize(("sentence", "cells"), SENTENCES)
def test_the_numbers_of_a_sentence_are_those_of_the_findings(sentence: str, cells: tuple[Cell, ...]) -> None:
    for heading, row, column in cells:
        text = shown(rows(heading)[row][column])
        place = re.search(r"\{(?:mean)?\}", sentence)
        assert place is not None
        number = text.partition(" ")[0] if place[0] == "{mean}" else text
        sentence = sentence[: place.start()] + number + sentence[place.end() :]
    assert sentence in README


def test_every_number_on_the_first_screen_is_in_one_of_these_sentences() -> None:
    (results,) = re.findall(r"\* \*\*Forgetting\.\*\* .*?\* \*\*The paper's claim\.\*\*", README)
    numbers = len(re.findall(r"(?<![\w.])\d*\.\d\d\b", results))
    intervals = sum(sentence.count("{}") for sentence, _ in SENTENCES)
    assert numbers == 3 * intervals + sum(sentence.count("{mean}") for sentence, _ in SENTENCES)


def test_what_is_separated_is_separated_in_the_findings() -> None:
    assert "Both differences from fine-tuning are separated." in README
    assert all("**separated**" in rows(HOPPER)[name][END] for name in ("cloning", "reset"))
    assert "The two are separated in forgetting, but not in what they score at the end." in README
    replay = rows("A replay buffer kept or emptied")[HOPPER]
    assert "separated" in replay["forgetting"]
    assert "tie" in replay["at the end"]


def test_what_is_tied_is_tied_in_the_findings() -> None:
    assert "On HalfCheetah no method is separated in final performance." in README
    for group in (HALFCHEETAH, "halfcheetah-wall"):
        assert all(name == "trpo" or "tie" in row[END] for name, row in rows(group).items())


def test_what_differs_from_zero_does_so_in_the_findings() -> None:
    sentence = (
        "These intervals exclude 0. With a correction for all 24 groups that it learns, the first is "
        "separated from 0."
    )
    assert sentence in README
    table = rows(FORGETTING)
    assert len(table) == 24
    named = (HOPPER, HALFCHEETAH, "walker2d-wall")
    assert all(table[name]["interval excludes 0"] == "yes" for name in named)
    assert [name for name, row in table.items() if row["separated from 0"] == "yes"] == [HOPPER]


def test_navigation_is_not_learned_in_the_findings() -> None:
    assert "In navigation, 1 is an oracle that knows the map, and `trpo` ends below an agent" in README
    for group in ("nav-state", "nav-range"):
        scores = rf"does not learn {group}: its score is −\S+ \([^)]*\) right after training and −"
        assert re.search(scores, FINDINGS)


def test_an_interval_that_contains_0_does_so_in_the_findings() -> None:
    low, high = re.findall(r"[−\d.]+", rows(TRANSFER)[HOPPER]["Joint gap"])[1:]
    assert low.startswith("−")
    assert not high.startswith("−")
