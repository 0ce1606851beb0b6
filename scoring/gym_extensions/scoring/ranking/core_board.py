"""The core board: one row per method, and all pairs of methods compared over all groups at prescribed looks.

See docs/metrics.md, "The core". A look is at 5, 10, 20, 40 or 80 runs and uses exactly the runs 0 to n − 1 of
every group of both submissions, so that neither the number of runs nor their choice can depend on their
results.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from statistics import fmean

import numpy as np

from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.metrics import statistics, values
from gym_extensions.metrics.formulas import (
    BY_NAME,
    CORE_METRICS,
    FINAL,
    FORGETTING,
    LEARNING,
    METRICS,
    Metric,
)
from gym_extensions.metrics.statistics import ALPHA, Summary, summary
from gym_extensions.scoring.ranking import boards
from gym_extensions.scoring.ranking.boards import BoardMetric, CorePair, CoreRow
from gym_extensions.scoring.ranking.copies import copy_of, duplicates
from gym_extensions.scoring.scorecard import GroupScore, Scorecard
from gym_extensions.scoring.submission.values import suite_expert_errors
from gym_extensions.submissions.review import VERIFIED
from gym_extensions.submissions.submission import consecutive

EDITION = 1
LOOK_LEVELS = {5: 0.005, 10: 0.01, 20: 0.01, 40: 0.01, 80: 0.01}
"""The level of a family of pairs at each look: together the error is at most .05.

tools/benchmarks/measure_looks.py simulates it (docs/metrics.md). The sum for normal runs is below .05; the
rest is a reserve for the skewed and bimodal runs that submissions have, of which few show too small a
variance.
"""
LOOKS = tuple(LOOK_LEVELS)
"""Numbers of runs at which submissions are compared."""
EXPLORATORY = 20
"""Separations at looks up to this one are called exploratory in the first edition (ADR 107)."""
MARGIN = 0.05
"""Two methods are equivalent if the interval of their difference lies between ± this."""
IN_OTHER_WAYS = {
    "joint": ("joint", FINAL.name, "TRPO, all tasks at once"),
    "alone": ("single", METRICS["single"][0].name, "TRPO, each task alone"),
}
"""The rows of the reference agent without a rank: protocol, metric of the score, title."""
REFERENCE = "trpo"
"""The submission of the reference agent, with which readers compare the others."""
KEY = boards.BoardKey(CORE, "sequential", STANDARD_BUDGET, False)
GroupRuns = tuple[tuple[float, ...], ...]
"""One value per run, by group."""


@dataclass(frozen=True)
class Method:
    """A submission on every group of the core, and the algorithm that it equals until the end of the first
    stage.

    Attributes:
        values: by metric, the values of consecutive runs from 0 in each group; the same groups for all.
        starts: in each group, for each of these runs, the mean returns before and after the first stage.
    """

    name: str
    parent: str
    values: Mapping[str, GroupRuns]
    starts: tuple[tuple[object, ...], ...] = ()

    @property
    def look(self) -> int:
        """The last look for which every group has enough runs; 0 if there is none."""
        return last_look(min(map(len, self.values[FINAL.name])))


def last_look(runs: int) -> int:
    """The last look with at most this number of runs; 0 if there is none."""
    return max((look for look in LOOKS if look <= runs), default=0)


def next_look(look: int) -> int | None:
    """The look after this one; None after the last."""
    return next((each for each in LOOKS if each > look), None)


def is_paired(first: Method, second: Method, runs: int) -> bool:
    """Whether two methods are compared run by run.

    They are if both declare the same parent, and each of these runs has the same mean return on every task
    before and after the first stage, to the last bit: equal policies leave that in the logs.
    """
    pairs = zip(first.starts, second.starts, strict=True)
    return (
        first.parent == second.parent
        and bool(first.starts)
        and all(len(a) >= runs and a[:runs] == b[:runs] for a, b in pairs)
    )


def pooled_difference(first: GroupRuns, second: GroupRuns, runs: int, *, paired: bool) -> Summary:
    """The mean over groups of the difference of the means of two methods.

    The first ``runs`` runs of each group are used, at least two. The squared standard error is Σ SE_g² / G²,
    with the degrees of freedom of Welch and Satterthwaite. Unpaired, SE_g² is the sum of those of both means;
    paired, that of the mean of the runs' differences.
    """
    groups = []
    for a, b in zip(first, second, strict=True):
        if paired:
            groups.append(summary([x - y for x, y in zip(a[:runs], b[:runs], strict=True)]))
        else:
            groups.append(statistics.subtract(summary(a[:runs]), summary(b[:runs])))
    return statistics.mean_of_groups(groups)


def compared_pairs(methods: Sequence[Method], metric: str) -> list[CorePair]:
    """All pairs of methods on one metric, in the order of ``itertools.combinations``.

    Each pair is compared at the last look that both have. p values are multiplied by .05 / (level of the
    look), which makes them valid at whichever look one stops, and adjusted by Holm's procedure over all
    pairs. The intervals have the level of the look / (number of pairs): with 95 % confidence all of them
    hold, at all looks. Holm's procedure is a little less strict, so that a pair may be separated whose
    interval just touches 0. Every method has at least one complete look.
    """
    pairs, compared = list(combinations(methods, 2)), []
    for a, b in pairs:
        look = min(a.look, b.look)
        paired = is_paired(a, b, look)
        difference = pooled_difference(a.values[metric], b.values[metric], look, paired=paired)
        quantile = statistics.critical_value(LOOK_LEVELS[look] / len(pairs), difference.df)
        half_width = quantile * math.sqrt(difference.squared_error)
        compared.append(
            CorePair(
                first=a.name,
                second=b.name,
                look=look,
                paired=paired,
                mean=difference.mean,
                low=difference.mean - half_width,
                high=difference.mean + half_width,
                p_value=min(1.0, statistics.zero_mean_p(difference) * ALPHA / LOOK_LEVELS[look]),
                verdict="open",
                exploratory=look <= EXPLORATORY,
                next_look=next_look(look),
            )
        )
    adjusted = statistics.holm_adjusted(np.array([pair.p_value for pair in compared])).tolist()
    return [decided(replace(pair, p_value=each)) for pair, each in zip(compared, adjusted, strict=True)]


def decided(pair: CorePair) -> CorePair:
    """The pair with its verdict.

    It is separated by Holm's procedure, else equivalent if the interval lies inside of ± ``MARGIN``.
    """
    if pair.p_value <= ALPHA:
        return replace(pair, verdict="separated", next_look=None)
    if pair.low > -MARGIN and pair.high < MARGIN:
        return replace(pair, verdict="equivalent", next_look=None)
    return pair


def ranks(names: Sequence[str], pairs: Sequence[CorePair], better: str) -> dict[str, tuple[int, int]]:
    """The first and last possible rank of each method: 1 + (better ones), M − (worse ones), as separated."""
    above, below = dict.fromkeys(names, 0), dict.fromkeys(names, 0)
    for pair in pairs:
        if pair.verdict == "separated":
            is_first = (pair.mean > 0) == (better == "higher")
            winner, loser = (pair.first, pair.second) if is_first else (pair.second, pair.first)
            below[winner] += 1
            above[loser] += 1
    return {name: (1 + above[name], len(names) - below[name]) for name in names}


def _scores(card: Scorecard, protocol: str = "sequential") -> dict[str, GroupScore]:
    """The scores of a submission with runs on the groups of the core, by group id, in its order."""
    logs = {name: card.groups.get(name, {}).get(protocol) for name in CORES[CORE]}
    return {name: log for name, log in logs.items() if log is not None and log.runs}


def _parent(card: Scorecard) -> str:
    protocol = card.manifest.protocol if card.manifest else None
    return (protocol.parent or protocol.algorithm) if protocol else ""


def _verified(log: GroupScore) -> int:
    """The number N of runs 0 to N − 1 that are all verified."""
    return consecutive([run for run in log.runs if run not in log.unverified])


def _counted(log: GroupScore) -> int:
    """The number N of runs 0 to N − 1 that may be compared. Later ones wait until they are verified.

    A submission that has verified too few for the first look has no rank, and shows all of its runs.
    """
    verified = _verified(log)
    return verified if verified >= LOOKS[0] else consecutive(log.runs)


def method_of(card: Scorecard) -> Method | None:
    """What a submission has on the core; None if it lacks a group or a value."""
    logs = _scores(card)
    has_values = all(log.metrics[metric].runs for log in logs.values() for metric in CORE_METRICS)
    if len(logs) < len(CORES[CORE]) or not has_values:
        return None
    counted = [(log, _counted(log)) for log in logs.values()]
    values = {
        metric: tuple(log.metrics[metric].runs[:count] for log, count in counted) for metric in CORE_METRICS
    }
    starts = tuple(tuple(run[:2] for run in log.return_matrix[:count]) for log, count in counted)
    return Method(card.name, _parent(card), values, starts)


def _notes(logs: Mapping[str, GroupScore], look: int) -> tuple[str, ...]:
    """What of a submission is not compared, in words, with the name of the case."""
    counts = {name: _counted(log) for name, log in logs.items()}
    missing = [name for name in CORES[CORE] if name not in logs]
    notes = [f"partial-core: It has no sequential runs of {', '.join(missing)}."] if missing else []
    if len(set(counts.values())) > 1:
        parts = ", ".join(f"{name} {count}" for name, count in counts.items())
        notes.append(f"different-numbers-of-runs: The groups have {parts} runs.")
    beyond = {name: sorted({look, count - 1}) for name, count in counts.items() if count > look > 0}
    if beyond:
        parts = ", ".join(f"{name} {' to '.join(map(str, ends))}" for name, ends in beyond.items())
        notes.append(f"runs-beyond-the-look: Not compared until the next look: {parts}.")
    waiting = {name: sorted(log.unverified) for name, log in logs.items() if log.unverified}
    if waiting and look:
        parts = ", ".join(f"{name} {', '.join(map(str, runs))}" for name, runs in waiting.items())
        notes.append(f"unverified-runs: Not compared until they are verified: {parts}.")
    return tuple(notes)


def _cost(logs: Mapping[str, GroupScore]) -> boards.CoreCost:
    """The cost of a run. Some runs state the largest memory of all groups; a group's least is its own."""
    documents = [log.provenance for log in logs.values()]
    if len(logs) < len(CORES[CORE]) or not all(documents):
        return boards.CoreCost()
    seconds = [[run.cpu_seconds for run in runs if run.cpu_seconds is not None] for runs in documents]
    peaks = [[run.peak_memory_mb for run in runs if run.peak_memory_mb is not None] for runs in documents]
    stored = [min(run.memory.stored_steps for run in runs) for runs in documents]
    parameters = [min(run.memory.parameters_last for run in runs) for runs in documents]
    return boards.CoreCost(
        steps=sum(fmean(run.steps for run in runs) for runs in documents),
        cpu_seconds=sum(map(fmean, seconds)) if all(seconds) else None,
        peak_memory_mb=max(map(max, peaks)) if all(peaks) else None,
        stored_steps=max(stored),
        parameters=max(parameters),
    )


def _group(log: GroupScore, look: int, metric: Metric = FINAL) -> boards.CoreGroup:
    runs = _counted(log)
    values = log.metrics[metric.name].runs[: look or runs]
    if not values:
        return boards.CoreGroup(None, None, None, runs)
    value = statistics.to_interval(summary(values), suite_expert_errors([log], metric))
    return boards.CoreGroup(value.mean, value.low, value.high, runs)


def _in_other_ways(card: Scorecard) -> Iterator[boards.CoreReference]:
    """The rows of ``IN_OTHER_WAYS`` that the reference agent has, verified, on every group of the core."""
    for name, (protocol, metric_name, title) in IN_OTHER_WAYS.items():
        logs, metric = _scores(card, protocol), BY_NAME[metric_name]
        runs = last_look(min(map(_verified, logs.values()), default=0))
        has_values = all(log.metrics[metric_name].runs for log in logs.values())
        if runs and has_values and len(logs) == len(CORES[CORE]):
            groups = {group: _group(log, runs, metric) for group, log in logs.items()}
            value = _over_groups(logs.values(), metric, runs)
            yield boards.CoreReference(name=name, title=title, runs=runs, value=value, groups=groups)


def _over_groups(logs: Collection[GroupScore], metric: Metric, runs: int) -> BoardMetric:
    """The mean over groups of the first runs of each, with the errors of the experts."""
    mean = statistics.mean_of_groups([summary(log.metrics[metric.name].runs[:runs]) for log in logs])
    return BoardMetric.of(
        values.MetricValue.of(statistics.to_interval(mean, suite_expert_errors(logs, metric)))
    )


def _why(logs: Mapping[str, GroupScore], method: Method | None, original: str | None) -> str:
    """Why a submission, which may be a copy of another, is not compared; empty if it is."""
    if original is not None:
        return copy_of(original)
    if claimed := [log for log in logs.values() if _verified(log) < min(LOOKS[0], consecutive(log.runs))]:
        return f"Claimed: {claimed[0].why_claimed or 'not verified.'}"
    if missing := [name for name in CORES[CORE] if name not in logs]:
        return f"It lacks {', '.join(missing)}."
    if method is None:
        return next(
            f"No score in {name}: {value.why}"
            for name, log in logs.items()
            for value in (log.metrics[metric] for metric in CORE_METRICS)
            if not value.runs
        )
    few = [name for name, log in logs.items() if _counted(log) < LOOKS[0]]
    return f"Fewer than {LOOKS[0]} runs in {', '.join(few)}." if few else ""


def _submission(card: Scorecard, method: Method | None, original: str | None) -> CoreRow:
    logs = _scores(card)
    look = method.look if method else 0
    why = _why(logs, method, original)
    level = boards.board_level(card, KEY)
    metrics = dict.fromkeys(CORE_METRICS, BoardMetric(None, None, None, why))
    if method and look:
        metrics = {name: _over_groups(logs.values(), BY_NAME[name], look) for name in CORE_METRICS}
    return CoreRow(
        name=card.name,
        title=card.title,
        level=level if why or boards.is_verified(level) else VERIFIED,  # of the runs that are compared
        ranked=not why,
        why=why,
        observes=card.manifest.observes if card.manifest else None,
        parent=_parent(card),
        look=look,
        next_look=next_look(look),
        missing=tuple(name for name in CORES[CORE] if name not in logs),
        metrics=metrics,
        groups={name: _group(log, look) for name, log in logs.items()},
        cost=_cost(logs),
        notes=_notes(logs, look),
    )


def core_board(cards: Sequence[Scorecard]) -> boards.CoreBoard | None:
    """The core board of the scorecards; None without a submission on it. Agents that observe the task are on
    it.

    Withdrawn submissions, and those without runs on the core with its budget, are left out.
    """
    cards = [
        card
        for card in cards
        if not card.withdrawn and any(log.budget == STANDARD_BUDGET for log in _scores(card).values())
    ]
    if not cards:
        return None
    copies = duplicates(cards, KEY)
    methods = {card.name: method_of(card) for card in cards}
    made = [_submission(card, methods[card.name], copies.get(card.name)) for card in cards]
    submissions = boards.best_first(made, FINAL)
    ranked = [
        (submission, method)
        for submission in submissions
        if submission.ranked and (method := methods[submission.name])
    ]
    learners = [method for submission, method in ranked if not _learned_nothing(submission)]
    families = {FINAL.name: [method for _, method in ranked], FORGETTING.name: learners}  # each at 5 %
    pairs = {metric: compared_pairs(members, metric) for metric, members in families.items()}
    found = {
        metric: ranks([method.name for method in members], pairs[metric], BY_NAME[metric].better)
        for metric, members in families.items()
    }
    return boards.CoreBoard(
        suite=CORE,
        edition=EDITION,
        groups=CORES[CORE],
        budget=STANDARD_BUDGET,
        looks=LOOKS,
        levels=tuple(LOOK_LEVELS.values()),
        margin=MARGIN,
        ranked=len(ranked),
        rows=tuple(_with_ranks(submission, found) for submission in submissions),
        references=tuple(row for card in cards if card.name == REFERENCE for row in _in_other_ways(card)),
        pairs={metric: tuple(compared) for metric, compared in pairs.items()},
    )


def _learned_nothing(submission: CoreRow) -> bool:
    value = submission.metrics[LEARNING.name]
    return values.learned_nothing({LEARNING.name: values.MetricValue(value.mean, value.low, value.high)})


def _with_ranks(submission: CoreRow, found: Mapping[str, Mapping[str, tuple[int, int]]]) -> CoreRow:
    """The submission with its rank on each metric that has a family."""
    metrics = dict(submission.metrics)
    for metric, ranks in found.items():
        note = values.NOTHING_LEARNED if submission.ranked and submission.name not in ranks else ""
        metrics[metric] = replace(metrics[metric], rank=ranks.get(submission.name), rank_note=note)
    return replace(submission, metrics=metrics)
