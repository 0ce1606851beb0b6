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
PACKNET, MULTI_HEAD = "packnet (observes the task)", "multi-head (observes the task)"

Cell = tuple[str, str, str]
"""A heading, the first cells of a row, and a column."""

SENTENCES: tuple[tuple[str, tuple[Cell, ...]], ...] = (
    (
        "On the mean over Hopper, Walker2d, HalfCheetah and Humanoid, forgetting is {} on gravity tasks and "
        "{} on wall tasks.",
        tuple(("Suites", name, "forgetting") for name in ("gravity", "wall")),
    ),
    (
        "The scores of earlier tasks fall by {} on Hopper's gravity tasks and by {} on HalfCheetah's, "
        "and by {} on Hopper's wall tasks and {} on Walker2d's.",
        tuple(
            (FORGETTING, name, "forgetting") for name in (HOPPER, HALFCHEETAH, "hopper-wall", "walker2d-wall")
        ),
    ),
    (
        "On Hopper's gravity tasks, behavioral cloning of 1,000 stored states per task ends at {mean}, "
        "fine-tuning at {mean} and fresh networks for every task at {mean}.",
        tuple((HOPPER, name, "at the end") for name in ("cloning", "trpo", "reset")),
    ),
    (
        "On Hopper's wall tasks, cloning ends at {mean}, PackNet, which observes the task, at {mean}, "
        "and fine-tuning at {mean}.",
        tuple(("hopper-wall", name, "at the end") for name in ("cloning", PACKNET, "trpo")),
    ),
    (
        "a gravity task of Hopper scores {} more than one that is learned alone, one of HalfCheetah {} "
        "more and one of Walker2d {} more. A body task of Hopper scores {} more, one of Walker2d {} more and "
        "one of HalfCheetah {} more.",
        tuple(
            (TRANSFER, name, "Asymptotic transfer")
            for name in (
                *(HOPPER, HALFCHEETAH, "walker2d-gravity"),
                *("hopper-body", "walker2d-body", "halfcheetah-body"),
            )
        ),
    ),
    (
        "There the earlier tasks add {}, {} and {} to the next one before its own training. Walker2d's body "
        "tasks end at {}, twice the score of the reference agent. Earlier gravity tasks of Humanoid add {} "
        "to the next one.",
        (
            (TRANSFER, "hopper-body", "Zero-shot transfer"),
            (TRANSFER, "walker2d-body", "Zero-shot transfer"),
            (TRANSFER, "halfcheetah-body", "Zero-shot transfer"),
            (FORGETTING, "walker2d-body", "at the end"),
            (TRANSFER, "humanoid-gravity", "Zero-shot transfer"),
        ),
    ),
    (
        "Training on all gravity tasks at once ends {} above fine-tuning on HalfCheetah, {} on Walker2d "
        "and {} on Hopper. On Hopper's wall tasks it ends {} above, on HalfCheetah's body tasks {}. On the "
        "body tasks of Hopper and Walker2d the difference is {} and {}; both intervals contain 0.",
        tuple(
            (TRANSFER, name, "Joint gap")
            for name in (
                HALFCHEETAH,
                "walker2d-gravity",
                HOPPER,
                "hopper-wall",
                "halfcheetah-body",
                "hopper-body",
                "walker2d-body",
            )
        ),
    ),
    (
        "SAC that keeps its replay buffer across tasks has a forgetting of {} on Hopper's gravity tasks "
        "and {} on HalfCheetah's; below 0, earlier tasks improved. SAC whose buffer is emptied for each "
        "task has {} and {}, and PPO {} and {}.",
        tuple(
            (LEARNERS, f"{group}, {name}", "forgetting")
            for name in ("sac", "sac-fresh-buffer", "ppo")
            for group in (HOPPER, HALFCHEETAH)
        ),
    ),
    (
        "In forgetting, cloning ({mean}), PackNet ({mean}) and one output layer per task ({mean}) are "
        "separated from fine-tuning on Hopper's gravity tasks, and PackNet on HalfCheetah's.",
        tuple((HOPPER, name, "forgetting") for name in ("cloning", PACKNET, MULTI_HEAD)),
    ),
)
SEPARATED = (
    (HOPPER, "cloning"),
    (HOPPER, "reset"),
    ("hopper-wall", "cloning"),
    ("hopper-wall", PACKNET),
)
SEPARATED_IN_FORGETTING = {
    (HOPPER, "cloning"),
    (HOPPER, PACKNET),
    (HOPPER, MULTI_HEAD),
    (HALFCHEETAH, PACKNET),
}
END, LOST = "at the end, minus fine-tuning", "forgetting, minus fine-tuning"


def rows(heading: str) -> dict[str, dict[str, str]]:
    """The first table below a heading: its cells by row and column. A row of a learner is named by two."""
    section = re.split(rf"^##+ {re.escape(heading)}$", FINDINGS, flags=re.MULTILINE)[1]
    lines = re.findall(r"(?:^\|.*\n)+", section.replace("`", ""), flags=re.MULTILINE)[0].splitlines()
    columns, _, *cells = ([cell.strip() for cell in line.strip("|").split("|")] for line in lines)
    keys = 2 if "learner" in columns else 1
    return {", ".join(row[:keys]): dict(zip(columns, row, strict=True)) for row in cells}


def methods() -> dict[str, dict[str, dict[str, str]]]:
    """The tables of methods, by group."""
    groups = re.findall(r"^### ((?:hopper|walker2d|halfcheetah)-\w+)$", FINDINGS, flags=re.MULTILINE)
    return {group: rows(group) for group in groups}


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
    (results,) = re.findall(r"\* \*\*Forgetting\.\*\* .*?\[docs/findings\.md\]", README)
    numbers = len(re.findall(r"(?<![\w.])\d*\.\d\d\b", results))
    intervals = sum(sentence.count("{}") for sentence, _ in SENTENCES)
    assert numbers == 3 * intervals + sum(sentence.count("{mean}") for sentence, _ in SENTENCES)


def test_what_is_separated_is_separated_in_the_findings() -> None:
    assert "All four differences from fine-tuning are separated." in README
    assert all("**separated**" in rows(group)[name][END] for group, name in SEPARATED)
    tables = methods()
    assert {
        (group, name) for group in tables for name, row in tables[group].items() if "separated" in row[LOST]
    } == SEPARATED_IN_FORGETTING
    assert (
        "The two kinds of SAC are separated in forgetting, but not in what they score at the end." in README
    )
    replay = rows("A replay buffer kept or emptied").values()
    assert all("separated" in row["forgetting"] and "tie" in row["at the end"] for row in replay)


def test_what_is_tied_is_tied_in_the_findings() -> None:
    assert "On HalfCheetah no method is separated in final performance." in README
    halfcheetah = {group: table for group, table in methods().items() if group.startswith("halfcheetah")}
    assert set(halfcheetah) == {"halfcheetah-gravity", "halfcheetah-wall"}
    for table in halfcheetah.values():
        assert all(name == "trpo" or "tie" in row[END] for name, row in table.items())


def test_what_differs_from_zero_does_so_in_the_findings() -> None:
    assert "The intervals of the eight other groups contain 0." in README
    assert (
        "With a correction for all twelve groups, Walker2d's wall tasks and both of these gravity groups are "
        "separated from 0." in README
    )
    table = rows(FORGETTING)
    assert len(table) == 12
    assert {name for name, row in table.items() if row["interval excludes 0"] == "no"} == set(table) - {
        HOPPER, HALFCHEETAH, "hopper-wall", "walker2d-wall"
    }  # fmt: skip
    separated = {name for name, row in table.items() if row["separated from 0"] == "yes"}
    assert separated == {"walker2d-wall", HOPPER, HALFCHEETAH}
