"""Scorecards of submissions on the core, made from the scores of their runs, and what boards say of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest

from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.metrics.formulas import METRICS
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.group_score import GroupScore
from gym_extensions.scoring.ranking import core_board as core_boards
from gym_extensions.scoring.ranking.boards import CoreBoard, CorePair, CoreRow
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.core_score import core_score

from ..made_submissions import Enter, at_level

GROUPS = CORES[CORE]
FINAL, LEARNED = "final_performance", "learning_performance"
Values = Mapping[str, Sequence[float]]
"""One value per run, by group."""
OnCore = Callable[..., Scorecard]


def normal(seed: int, mean: float, runs: int = 5, deviation: float = 0.1) -> dict[str, tuple[float, ...]]:
    """Runs of every group of the core around a mean."""
    rng = np.random.default_rng(seed)
    return {group: tuple(rng.normal(mean, deviation, runs).tolist()) for group in GROUPS}


@pytest.fixture
def on_core(enter: Enter) -> OnCore:
    """Makes the scorecard of a submission with these final performances of runs 0, 1, … in each group."""
    card = enter("a", 300)
    log = card.groups["hopper-gravity-v0"]["sequential"]

    def scores(values: Sequence[float], numbers: Sequence[int] | None, starts: int) -> GroupScore:
        runs = tuple(range(len(values)) if numbers is None else numbers)
        metrics = {
            metric.name: MetricValue(mean=1.0, runs=(1.0,) * len(runs)) for metric in METRICS["sequential"]
        }
        for name in (FINAL, "learning_performance"):
            metrics[name] = MetricValue(mean=1.0, low=0.9, high=1.1, runs=tuple(values))
        matrix = tuple(((float(starts),) * 2, (float(starts + run),) * 2, (0.0, 0.0)) for run in runs)
        provenance = tuple(replace(log.provenance[0], run=run) for run in runs)
        return replace(
            log,
            budget="300k",
            runs=runs,
            tasks=log.tasks[:2],
            metrics=metrics,
            return_matrix=matrix,
            provenance=provenance,
            episode_sketches=(),
        )

    def make(
        name: str,
        values: Values,
        *,
        parent: str = "",
        starts: int = 0,
        runs: Mapping[str, Sequence[int]] | None = None,
    ) -> Scorecard:
        assert card.manifest is not None
        protocol = msgspec.structs.replace(card.manifest.protocol, parent=parent)
        groups = {
            group: {"sequential": scores(part, (runs or {}).get(group), starts)}
            for group, part in values.items()
        }
        made = replace(card, name=name, manifest=replace(card.manifest, protocol=protocol), groups=groups)
        return at_level(made, "verified")

    return make


def board_of(cards: Sequence[Scorecard]) -> CoreBoard:
    made = core_boards.core_board([replace(card, core=core_score(card)) for card in cards])
    assert made is not None
    return made


def with_logs(card: Scorecard, **changes: Any) -> Scorecard:
    """The scorecard with these fields of every log."""
    groups = {
        name: {"sequential": replace(log["sequential"], **changes)} for name, log in card.groups.items()
    }
    return replace(card, groups=groups)


def unverified(card: Scorecard, *runs: int) -> Scorecard:
    return with_logs(card, level="claimed", unverified=runs)


def with_episodes(card: Scorecard) -> Scorecard:
    """The scorecard with the same episodes as every other that this function returns."""
    sketches = tuple(tuple(f"{run} {part}" for part in range(16)) for run in range(5))
    return with_logs(card, episode_sketches=sketches)


def row(board: CoreBoard, name: str) -> CoreRow:
    return next(submission for submission in board.rows if submission.name == name)


def ranked(board: CoreBoard) -> int:
    """The number of ranked submissions of both lists."""
    return sum(each.ranked for each in board.lists)


def pair_of(board: CoreBoard, first: str, second: str, metric: str = FINAL) -> CorePair:
    found = board.pair(metric, first, second)
    assert found is not None
    return found


def trained(card: Scorecard, values: Values) -> Scorecard:
    """The submission with these runs that were trained here."""
    log = next(iter(card.groups.values()))["sequential"]
    made = {}
    for name, part in values.items():
        metrics = log.metrics | {each: MetricValue(mean=1.0, runs=tuple(part)) for each in (FINAL, LEARNED)}
        runs = tuple(range(len(part)))
        made[name] = replace(log, level="trained here", runs=runs, metrics=metrics)
    own = {name: card.groups[name]["sequential"] for name in made}
    groups = {name: card.groups[name] | {"sequential": log} for name, log in made.items()}
    return replace(card, groups=card.groups | groups, own=own)
