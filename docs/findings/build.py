"""Writes docs/findings.md and its figures from the committed submissions: ``make findings``.

Every number and verdict is computed from the submissions; the text is in ``page.md.jinja``.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from comparison import METRICS, Row, Verdict, count, separated_from_zero, with_verdicts
from costs import MAX_MEGABYTES, hours, stored_megabytes
from figures import draw_learned_and_final, draw_retention
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from numbers_as_text import mean
from retention import as_scores, most_forgotten
from suites import Suite, suites_of
from transfer import TITLES, Transfer, shown, transfer

from gym_extensions.atomic import write_text
from gym_extensions.baselines.algorithms import names
from gym_extensions.catalog.budgets import STANDARD_BUDGET
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.results.evaluations import evaluations
from gym_extensions.scoring.pipeline.score import make_scorer
from gym_extensions.scoring.references import load_references
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.scoring.statistics.intervals import Interval

ROOT = Path(__file__).resolve().parents[2]
FOLDER, PAGE = ROOT / "docs" / "findings", ROOT / "docs" / "findings.md"
FINE_TUNING = "trpo"
GROUP_NAMES = [group.name for group in GROUPS.values()]
COMPARED = set(names()) - {"random", "zero", "trpo-2017"}
"""Reference agents that are compared with fine-tuning: those that learn, with settings of today."""
REPLAY = ("sac", "sac-fresh-buffer")
"""The same learner with its replay buffer kept across tasks, and emptied."""
OTHER_LEARNERS = {"ppo", *REPLAY}
"""Reference agents that fine-tune with another learner than TRPO."""


@dataclass(frozen=True)
class Group:
    """The entries of one group, each family by final performance.

    Attributes:
        name: name of the group.
        rows: fine-tuning, then the methods against it.
        learners: the other learners against fine-tuning.
        replay: SAC with its replay buffer, against SAC without; None if one of the two is not trained.
    """

    name: str
    rows: tuple[Row, ...]
    learners: tuple[Row, ...] = ()
    replay: Row | None = None

    @property
    def all_rows(self) -> tuple[Row, ...]:
        """Fine-tuning, the methods and the other learners."""
        return self.rows + self.learners

    @property
    def is_compared(self) -> bool:
        """Whether the group has a method beside fine-tuning."""
        return len(self.rows) > 1

    @property
    def missing(self) -> list[str]:
        """Reference agents without five runs."""
        return sorted(COMPARED - {row.name for row in self.all_rows})


@dataclass(frozen=True)
class Space:
    """Size of audit samples and policies in MB.

    Attributes:
        limit: the most that all entries may take.
        used: what they take.
        smallest: the group on which five sequential runs of fine-tuning take least, with their size.
        largest: that on which they take most.
    """

    limit: int
    used: float
    smallest: tuple[str, float]
    largest: tuple[str, float]

    @classmethod
    def of(cls, submissions: Path, groups: Iterable[str]) -> Space | None:
        """The space of the entries in a folder; None if fine-tuning was trained on none of the groups."""
        sizes = [(name, stored_megabytes(submissions, FINE_TUNING, name, "sequential")) for name in groups]
        if not sizes:
            return None
        smallest, largest = (choose(sizes, key=lambda item: item[1]) for choose in (min, max))
        return cls(MAX_MEGABYTES, stored_megabytes(submissions), smallest, largest)


def group_rows(cards: Sequence[Scorecard], group: str) -> list[Row]:
    """The entries with at least five runs at the budget and a value of every metric in each."""
    rows = []
    for card in cards:
        score = card.groups.get(group, {}).get("sequential")
        if score is None or score.budget != STANDARD_BUDGET or card.name not in COMPARED or not card.manifest:
            continue
        values = tuple(tuple(score.metrics[name].runs) for name in METRICS)
        if min(map(len, values)) >= FULL_ENTRY_RUNS:
            rows.append(Row(card.name, card.title, card.manifest.observes.task_in_evaluation, values))
    return sorted(rows, key=lambda row: (row.name != FINE_TUNING, -row.final.mean))


def group_of(name: str, rows: Sequence[Row]) -> Group:
    """The entries of a group with their verdicts; methods and other learners are two families of tests."""
    fine_tuning, *others = rows
    by_name = {row.name: row for row in others}
    kept, emptied = (by_name.get(each) for each in REPLAY)
    return Group(
        name,
        (fine_tuning, *with_verdicts(fine_tuning, [row for row in others if row.name not in OTHER_LEARNERS])),
        with_verdicts(fine_tuning, [row for row in others if row.name in OTHER_LEARNERS]),
        with_verdicts(emptied, [kept])[0] if kept and emptied else None,
    )


def excludes_zero(each: Interval) -> str:
    """``yes`` if the interval excludes 0, else ``no``."""
    return "no" if (each.low or 0.0) <= 0 <= (each.high or 0.0) else "yes"


def verdict(each: Verdict | None) -> str:
    """A difference with its interval and verdict; empty for fine-tuning itself."""
    return "" if each is None else f"{mean(each.gap)}, {'**separated**' if each.is_separated else 'tie'}"


def page(
    groups: Sequence[Group],
    without_score: Sequence[str] = (),
    transfers: Sequence[Transfer] = (),
    unsolved: Mapping[str, Sequence[str]] = MappingProxyType({}),
    space: Space | None = None,
    *,
    suites: Sequence[Suite] = (),
) -> str:
    """The text of the page.

    Args:
        groups: the groups on which fine-tuning has a score.
        without_score: names of the groups on which it was trained without a score: every task is unsolved.
        transfers: the transfers of fine-tuning on each group.
        unsolved: the unsolved tasks of groups that have any.
        space: what the entries take in the repository.
        suites: the suites on which fine-tuning has a score.
    """
    templates = Environment(
        loader=FileSystemLoader(FOLDER), undefined=StrictUndefined, trim_blocks=True, autoescape=False
    )
    templates.filters.update(mean=mean, excludes_zero=excludes_zero, verdict=verdict, hours=hours)
    rows = [row for group in groups for row in group.rows]
    trained = {group.name for group in groups} | set(without_score)
    return (
        templates.get_template("page.md.jinja").render(
            budget=STANDARD_BUDGET,
            fine_tuning=FINE_TUNING,
            groups=groups,
            with_learners=[group for group in groups if group.learners],
            without_score=without_score,
            space=space,
            suites=suites,
            unsolved={group.name: unsolved[group.name] for group in groups if group.name in unsolved},
            transfer_titles=TITLES,
            transfers=shown(transfers),
            without_fine_tuning=[name for name in GROUP_NAMES if name not in trained],
            by_forgetting=sorted(groups, key=lambda group: -group.rows[0].forgetting.mean),
            forgotten=separated_from_zero({group.name: group.rows[0].values[2] for group in groups}),
            counts=[
                count("final performance", [row.final_verdict for row in rows]),
                count("forgetting", [row.forgetting_verdict for row in rows]),
            ],
        )
        + "\n"
    )


def main(submissions: Path = ROOT / "submissions") -> None:
    """Writes the page and its figures."""
    if not submissions.is_dir():
        raise SystemExit(f"{submissions}: no such folder. Give the folder with the submissions.")
    scorer = make_scorer()
    folders = [path.parent for path in sorted(submissions.glob("*/submission.toml"))]
    cards = [card for card in map(scorer, folders) if not card.problems]
    groups = [
        group_of(group.name, rows)
        for group in GROUPS.values()
        if (rows := group_rows(cards, group.id)) and rows[0].name == FINE_TUNING
    ]
    for group in groups:
        if group.is_compared:
            points = [(row.title, row.learned, row.final) for row in group.all_rows]
            draw_learned_and_final(points, FOLDER / f"{group.name}.svg")
    if forgotten := most_forgotten({group.name: group.rows[0].forgetting for group in groups}):
        scores = as_scores(evaluations(submissions / FINE_TUNING), load_references().tasks)
        draw_retention(scores, forgotten, FOLDER / "retention.svg")
    compared = {group.name for group in groups}
    transfers = [
        transfer(card, group.id, group.name)
        for card in cards
        for group in GROUPS.values()
        if card.name == FINE_TUNING and group.name in compared
    ]
    without_score = groups_without_score(cards)
    space = Space.of(submissions, [*compared, *without_score])
    suites = [
        suite for card in cards if card.name == FINE_TUNING for suite in suites_of(card, STANDARD_BUDGET)
    ]
    write_text(PAGE, page(groups, without_score, transfers, unsolved_tasks(), space, suites=suites))


def unsolved_tasks() -> dict[str, list[str]]:
    """The tasks that the reference agent did not learn, by group."""
    references = load_references().tasks
    tasks = {
        group.name: [
            task.name for task in group.tasks if task.id in references and references[task.id].unsolved
        ]
        for group in GROUPS.values()
    }
    return {name: each for name, each in tasks.items() if each}


def groups_without_score(cards: Sequence[Scorecard]) -> list[str]:
    """The groups on which fine-tuning was trained at the budget and has no score."""
    (tables,) = [card.groups for card in cards if card.name == FINE_TUNING] or [{}]
    scores = {group.name: tables.get(group.id, {}).get("sequential") for group in GROUPS.values()}
    return [
        name
        for name, score in scores.items()
        if score and score.budget == STANDARD_BUDGET and score.metrics["final_performance"].mean is None
    ]


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
