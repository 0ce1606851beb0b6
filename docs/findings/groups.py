"""The groups on which fine-tuning was trained, and the entries that are compared with it on each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from comparison import METRICS, Row, with_verdicts

from gym_extensions.baselines.algorithms import names
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS, STANDARD_BUDGET
from gym_extensions.scoring.references import load_references
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.statistics import Interval

FINE_TUNING = "trpo"
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
    def is_learned(self) -> bool:
        """Whether the score of fine-tuning right after training is above the floor, by its interval."""
        return (self.rows[0].learned.low or 0.0) > 0

    @property
    def missing(self) -> list[str]:
        """Reference agents without five runs."""
        return sorted(COMPARED - {row.name for row in self.all_rows})


def group_rows(cards: Sequence[Scorecard], group: str) -> list[Row]:
    """The entries with at least five runs at the budget and a value of every metric in each."""
    rows = []
    for card in cards:
        score = card.groups.get(group, {}).get("sequential")
        if score is None or score.budget != STANDARD_BUDGET or card.name not in COMPARED or not card.manifest:
            continue
        values = tuple(tuple(score.metrics[name].runs) for name in METRICS)
        if min(map(len, values)) >= FULL_ENTRY_RUNS:
            shown = [score.metrics[name] for name in METRICS]
            intervals = tuple(Interval(each.mean or 0.0, each.low, each.high) for each in shown)
            observes = card.manifest.observes.task_in_evaluation
            rows.append(Row(card.name, card.title, observes, values, intervals=intervals))
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


def groups_without_score(cards: Sequence[Scorecard]) -> list[str]:
    """The groups on which fine-tuning was trained at the budget and has no score."""
    (tables,) = [card.groups for card in cards if card.name == FINE_TUNING] or [{}]
    scores = {group.name: tables.get(group.id, {}).get("sequential") for group in GROUPS.values()}
    return [
        name
        for name, score in scores.items()
        if score and score.budget == STANDARD_BUDGET and score.metrics["final_performance"].mean is None
    ]


def open_tasks() -> dict[str, list[str]]:
    """The tasks without an expert, by group."""
    references = load_references().tasks
    tasks = {
        group.name: [task.name for task in group.tasks if task.id in references and references[task.id].open]
        for group in GROUPS.values()
    }
    return {name: each for name, each in tasks.items() if each}
