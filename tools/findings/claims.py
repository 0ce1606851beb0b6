"""What docs/findings.md says beyond the boards: gains by group, positions, the task label, and chance.

Differences are Welch's, with 95 % intervals for the one comparison, over the runs of the last look of each.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import NormalDist, fmean

import numpy as np
from scipy.integrate import quad

from gym_extensions.catalog.groups import CORE, CORES, SUITES
from gym_extensions.metrics.formulas import METRICS
from gym_extensions.metrics.statistics import mean_of_groups, subtract, summary, to_interval
from gym_extensions.scoring.ranking.boards import CoreBoard
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.core_score import core_logs, last_look, verified_runs
from tools.findings.tables import FINAL, FINE_TUNING, LEARNED, LOST, NONE, Value

ALONE = METRICS["single"][0].name
SNAPSHOTS = "snapshots"
VARIANTS = (10, 100)
"""Equal variants that are tried on the public seeds."""
GroupRuns = Mapping[str, Sequence[float]]
"""The values of the runs of the last look, by group id of the core."""


def core_runs(card: Scorecard, metric: str, protocol: str = "sequential") -> GroupRuns:
    """A metric of a submission on the groups of the core; empty if it lacks one of them."""
    logs = core_logs(card, protocol)
    look = last_look(min(map(verified_runs, logs.values()), default=0))
    if not look or len(logs) < len(CORES[CORE]):
        return {}
    return {name: log.metrics[metric].runs[:look] for name, log in logs.items()}


def minus(first: GroupRuns, second: GroupRuns, groups: Sequence[str] = CORES[CORE]) -> Value:
    """The mean over groups of first − second; NaN if one of both lacks runs."""
    if not all(first.get(name) and second.get(name) for name in groups):
        return NONE
    parts = [subtract(summary(first[name]), summary(second[name])) for name in groups]
    return Value.of(to_interval(mean_of_groups(parts)))


def correlation(first: Sequence[float], second: Sequence[float]) -> Value:
    """Pearson's correlation with Fisher's 95 % interval."""
    r = float(np.corrcoef(first, second)[0, 1])
    half = NormalDist().inv_cdf(0.975) / math.sqrt(len(first) - 3)
    return Value(r, *(math.tanh(math.atanh(r) + sign * half) for sign in (-1, 1)))


@dataclass(frozen=True)
class Gain:
    """What cloning adds to fine-tuning at the end of a group, and what fine-tuning forgets there."""

    group: str
    gain: Value
    lost: float


def gains(cards: Mapping[str, Scorecard], cloning: str) -> tuple[list[Gain], Value]:
    """The gains of cloning by group, and their correlation with what fine-tuning forgets, over groups; none
    without runs.

    In the correlation the gains are over the first half of fine-tuning's runs, and what is forgotten is of
    the second half: errors of the same runs would be in both.
    """
    cloned, tuned = (core_runs(cards[name], FINAL) for name in (cloning, FINE_TUNING))
    lost = core_runs(cards[FINE_TUNING], LOST)
    if not (cloned and tuned):
        return [], NONE
    rows, pairs = [], []
    for name in CORES[CORE]:
        rows.append(Gain(name.rpartition("-v")[0], minus(cloned, tuned, (name,)), fmean(lost[name])))
        half = len(tuned[name]) // 2
        pairs.append((fmean(cloned[name]) - fmean(tuned[name][:half]), fmean(lost[name][half:])))
    first, second = zip(*pairs, strict=True)
    return rows, correlation(first, second)


def best_of(number: int) -> float:
    """The mean of the highest of so many standard normal values."""
    normal = NormalDist()
    return quad(lambda x: x * number * normal.pdf(x) * normal.cdf(x) ** (number - 1), -10, 10)[0]


@dataclass(frozen=True)
class Selection:
    """What the choice among equal variants adds to a core score: number of variants, mean, over methods."""

    number: int
    low: float
    middle: float
    high: float


def selections(board: CoreBoard, cards: Mapping[str, Scorecard]) -> list[Selection]:
    """The mean gain of the best of equal variants of ten runs, from the lowest, median and highest standard
    error over runs of the ranked methods.
    """
    errors = []
    for row in board.rows:
        if row.ranked:
            mean = mean_of_groups([summary(runs[:10]) for runs in core_runs(cards[row.name], FINAL).values()])
            errors.append(math.sqrt(mean.squared_error * mean.runs / 10))
    ends = (min(errors), float(np.median(errors)), max(errors))
    return [Selection(number, *(best_of(number) * error for error in ends)) for number in VARIANTS]


def differences(cards: Mapping[str, Scorecard], cloning: str, packnet: str) -> dict[str, Value]:
    """The differences that the page states in sentences, by name."""
    alone = core_runs(cards[FINE_TUNING], ALONE, "single")
    final = {name: core_runs(cards[name], FINAL) for name in (cloning, packnet, SNAPSHOTS, FINE_TUNING)}
    without_walls = [name for name in CORES[CORE] if name not in SUITES["wall"]]
    return {
        "snapshots": minus(final[SNAPSHOTS], final[cloning]),
        "alone": minus(alone, final[packnet]),
        "packnet": minus(final[packnet], final[FINE_TUNING]),
        "packnet_without_walls": minus(final[packnet], final[FINE_TUNING], without_walls),
    }


def less_than_alone(board: CoreBoard, cards: Mapping[str, Scorecard]) -> dict[str, Value]:
    """By ranked method, what it learned minus what each task alone has."""
    alone = core_runs(cards[FINE_TUNING], ALONE, "single")
    return {row.name: minus(core_runs(cards[row.name], LEARNED), alone) for row in board.rows if row.ranked}


def is_learned_score(cards: Mapping[str, Scorecard]) -> bool:
    """Whether the snapshots end, in every run, to the last bit where fine-tuning was after each training."""
    ends, learned = core_runs(cards[SNAPSHOTS], FINAL), core_runs(cards[FINE_TUNING], LEARNED)
    return bool(ends) and all(values == learned[name][: len(values)] for name, values in ends.items())
