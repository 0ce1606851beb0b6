"""The core board: one row per method in two lists, and all pairs of methods at prescribed looks.

See docs/metrics.md, "The core", and ``submission.core_score`` on looks.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from gym_extensions.catalog import groups as catalog
from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.documents import filled
from gym_extensions.metrics import statistics, values
from gym_extensions.metrics.formulas import CORE_METRICS, FINAL, FORGETTING, METRICS
from gym_extensions.metrics.statistics import ALPHA, Summary, summary
from gym_extensions.references import ALONE
from gym_extensions.scoring.group_score import GroupScore
from gym_extensions.scoring.ranking import boards
from gym_extensions.scoring.ranking.copies import COPY, alike_on, duplicates
from gym_extensions.scoring.scorecard import CoreScore, Scorecard
from gym_extensions.scoring.submission import core_score
from gym_extensions.submissions.review import VERIFIED, is_verified

MARGIN = 0.05
"""Two methods are equivalent if the interval of their difference lies between ± this."""
IN_OTHER_WAYS = {
    "joint": ("joint", FINAL, "TRPO, all tasks at once"),
    ALONE: ("single", METRICS["single"][0], "TRPO, each task alone"),
}
"""The rows of the reference agent without a rank: protocol, metric of the score, title."""
REFERENCE = "trpo"
"""The submission of the reference agent, with which readers compare the others."""
PLANNED = (
    ("H1", "cloning-tuned", "trpo", FINAL.name),
    ("H2", "cloning-tuned", "trpo", FORGETTING.name),
    ("H3", "reset", "trpo", FINAL.name),
    ("H4", "ppo-tuned", "trpo", FINAL.name),
    ("H5", "snapshots", "packnet-tuned", FINAL.name),
    ("H6", "multi-head", "trpo", FINAL.name),
    ("H8", "l2-tuned", "trpo", FINAL.name),
    ("H8", "l2-init-tuned", "trpo", FINAL.name),
    ("H8", "online-ewc-tuned", "trpo", FINAL.name),
)
"""The pairs that the plan of the second edition (docs/findings/plan.md) names: hypothesis, submissions,
metric. All other pairs are exploratory."""
PLANNED_RUNS = 10
PLANNED_LOOKS = {name: PLANNED_RUNS for _, *names, _ in PLANNED for name in names}
"""The runs of these submissions when their pairs are tested, once: before and afterwards, with other runs or
submissions, they are exploratory as well."""
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
        by_look: in place of values, those of the runs of each look, if they depend on which runs these are.
    """

    name: str
    parent: str
    values: Mapping[str, GroupRuns]
    starts: tuple[tuple[object, ...], ...] = ()
    by_look: Mapping[int, GroupRuns] = field(default_factory=dict)

    @property
    def look(self) -> int:
        """The last look for which every group has enough runs; 0 if there is none."""
        return core_score.last_look(min(map(len, self.values[FINAL.name])))


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


def lacking(looks: Mapping[str, int]) -> list[str]:
    """The submissions of the plan of which too few runs are compared.

    ``looks`` are those of the ranked submissions, by name.
    """
    return [name for name, runs in PLANNED_LOOKS.items() if looks.get(name, 0) < runs]


def compared_pairs(
    methods: Sequence[Method], metric: str, *, as_planned: bool = False
) -> list[boards.CorePair]:
    """All pairs of methods on one metric, in the order of ``itertools.combinations``.

    Each pair is compared at the last look that both have, and run by run if both declare the same parent and
    each of these runs has the same mean return on every task before and after the first stage, to the last
    bit: equal policies leave that in the logs.

    p values are multiplied by .05 / (level of the look), which makes them valid at whichever look one stops,
    and adjusted by Holm's procedure over all pairs. The intervals have the level of the look / (number of
    pairs): with 95 % confidence all of them hold, at all looks. Holm's procedure is a little less strict, so
    that a pair may be separated whose interval just touches 0. Every method has at least one complete look.
    ``as_planned`` says whether the pairs that the plan names are tested, or all are exploratory.
    """
    pairs, compared = list(combinations(methods, 2)), []
    for a, b in pairs:
        look = min(a.look, b.look)
        starts = zip(a.starts, b.starts, strict=True)
        same = all(len(first) >= look and first[:look] == second[:look] for first, second in starts)
        paired = a.parent == b.parent and bool(a.starts) and same
        first, second = (each.by_look.get(look, each.values[metric]) for each in (a, b))
        difference = pooled_difference(first, second, look, paired=paired)
        quantile = statistics.critical_value(core_score.LOOK_LEVELS[look] / len(pairs), difference.df)
        half_width = quantile * math.sqrt(difference.squared_error)
        compared.append(
            boards.CorePair(
                first=a.name,
                second=b.name,
                look=look,
                paired=paired,
                mean=difference.mean,
                low=difference.mean - half_width,
                high=difference.mean + half_width,
                p_value=min(1.0, statistics.zero_mean_p(difference) * ALPHA / core_score.LOOK_LEVELS[look]),
                verdict="open",
                exploratory=not as_planned or all({a.name, b.name, metric} != {*row} for _, *row in PLANNED),
                next_look=core_score.next_look(look),
            )
        )
    adjusted = statistics.holm_adjusted(np.array([pair.p_value for pair in compared])).tolist()
    return [decided(replace(pair, p_value=each)) for pair, each in zip(compared, adjusted, strict=True)]


def decided(pair: boards.CorePair) -> boards.CorePair:
    """The pair with its verdict.

    It is separated by Holm's procedure, else equivalent if the interval lies inside of ± ``MARGIN``.
    """
    if pair.p_value <= ALPHA:
        return replace(pair, verdict="separated", next_look=None)
    if pair.low > -MARGIN and pair.high < MARGIN:
        return replace(pair, verdict="equivalent", next_look=None)
    return pair


def ranks(names: Sequence[str], pairs: Sequence[boards.CorePair], better: str) -> dict[str, tuple[int, int]]:
    """The first and last possible rank of each method: 1 + (better ones), M − (worse ones), as separated.

    Pairs with another method do not count.
    """
    above, below = dict.fromkeys(names, 0), dict.fromkeys(names, 0)
    for pair in pairs:
        if pair.verdict == "separated" and pair.first in above and pair.second in above:
            is_first = (pair.mean > 0) == (better == "higher")
            winner, loser = (pair.first, pair.second) if is_first else (pair.second, pair.first)
            below[winner] += 1
            above[loser] += 1
    return {name: (1 + above[name], len(names) - below[name]) for name in names}


def method_of(card: Scorecard, parent: str) -> Method:
    """What a submission with a rank has on the core."""
    counted = [(log, core_score.counted_runs(log)) for log in core_score.core_logs(card).values()]
    values = {name: tuple(log.metrics[name].runs[:count] for log, count in counted) for name in CORE_METRICS}
    starts = tuple(tuple(run[:2] for run in log.return_matrix[:count]) for log, count in counted)
    return Method(card.name, parent, values, starts)


def as_compared(card: Scorecard, look: int) -> Scorecard:
    """The scorecard with the logs that the core compares, and of these the runs of the look.

    Without a look, the runs that may be compared. Later runs wait, and change neither which submission is a
    copy nor the level.
    """
    logs = {}
    for name, log in core_score.core_logs(card).items():
        runs, metrics = look or core_score.counted_runs(log), log.metrics
        if found := log.metrics[FINAL.name].runs[:runs]:
            value = replace(core_score.over_groups([log], FINAL, runs), runs=found)
            metrics = {**metrics, FINAL.name: value}
        level = log.level
        if not is_verified(level) and core_score.verified_runs(log) >= max(runs, 1):
            level = VERIFIED  # what is not verified are later runs
        sketches = log.episode_sketches[:runs]
        logs[name] = {KEY.protocol: replace(log, level=level, metrics=metrics, episode_sketches=sketches)}
    return replace(card, groups=logs)


def _in_other_ways(card: Scorecard) -> Iterator[boards.CoreReference]:
    for name, (protocol, metric, title) in IN_OTHER_WAYS.items():
        logs = core_score.core_logs(card, protocol)
        runs = core_score.last_look(min(map(core_score.verified_runs, logs.values()), default=0))
        has_values = all(log.metrics[metric.name].runs for log in logs.values())
        if runs and has_values and len(logs) == len(CORES[CORE]):
            groups = {group: core_score.on_group(log, runs, metric) for group, log in logs.items()}
            value = boards.BoardMetric.of(core_score.over_groups(logs.values(), metric, runs))
            yield boards.CoreReference(name=name, title=title, runs=runs, value=value, groups=groups)


def _row(card: Scorecard, core: CoreScore, original: str | None, alike: str, edition: int) -> boards.CoreRow:
    """The row of a submission as it is compared, which may be a copy of another, without its ranks."""
    why = core.why if original is None else COPY.format(original)
    why = why or ("Not trained here." if edition > 1 and not core.trained_here else "")
    return filled(
        boards.CoreRow,
        core,
        name=card.name,
        title=card.title,
        level=boards.board_level(card, KEY),
        ranked=not why,
        why=why,
        observes=card.manifest.observes if card.manifest else None,
        metrics={
            name: boards.BoardMetric.of(value if core.look else replace(value, why=why))
            for name, value in core.metrics.items()
        },
        alike=alike,
    )


def core_board(cards: Sequence[Scorecard]) -> boards.CoreBoard | None:
    """The core board of the scorecards; None without a submission on it.

    It has two ranked lists: agents that observe the task in evaluation are compared with each other. All
    pairs of both lists are one family, so that a method can be compared with every other one. Withdrawn
    submissions, and those without runs on the core with its budget, are left out.
    """
    scored = [(card, card.core) for card in cards if card.core]
    if not scored:
        return None
    compared = {card.name: as_compared(card, core.look) for card, core in scored}
    copies = duplicates(list(compared.values()), KEY)
    by_name = {card.name: card for card, _ in scored}
    # The second edition, of runs that were trained here alone, begins with those of the reference agent.
    edition = 1 + any(core.trained_here for card, core in scored if card.name == REFERENCE)
    alike = alike_on([card for name, card in compared.items() if name not in copies], KEY, FINAL.name)
    unsorted = [
        _row(compared[card.name], core, copies.get(card.name), alike.get(card.name, ""), edition)
        for card, core in scored
    ]
    made = boards.best_first(unsorted, FINAL)
    parts = [[row for row in made if row.task_conditioned == conditioned] for conditioned in (False, True)]
    rows = [row for part in parts for row in part]
    references = tuple(row for card, _ in scored if card.name == REFERENCE for row in _in_other_ways(card))
    alone = next((each.value for each in references if each.name == ALONE), values.Estimate())
    ranked = {row.name: method_of(by_name[row.name], row.parent) for row in rows if row.ranked}
    notes = {row.name: values.retention_note(row.metrics, alone) for row in rows if row.name in ranked}
    learners = [method for name, method in ranked.items() if not notes[name]]
    as_planned = edition > 1 and {name: method.look for name, method in ranked.items()} == PLANNED_LOOKS
    # Two families of pairs, each at 5 %.
    families = {FINAL.name: list(ranked.values()), FORGETTING.name: learners}
    pairs = {
        name: tuple(compared_pairs(family, name, as_planned=as_planned)) for name, family in families.items()
    }
    lists = [_ranked_list(part, pairs, notes) for part in parts if part]
    members = [[row.name for row in each.rows if row.ranked] for each in lists]
    return boards.CoreBoard(
        suite=CORE,
        edition=edition,
        groups=CORES[CORE],
        budget=STANDARD_BUDGET,
        looks=core_score.LOOKS,
        levels=tuple(core_score.LOOK_LEVELS.values()),
        margin=MARGIN,
        lists=tuple(lists),
        references=references,
        pairs=pairs,
        variants=tuple(_variants([by_name[name] for name in ranked], list(ranked.values()), members)),
    )


def _ranked_list(
    rows: Sequence[boards.CoreRow], pairs: Mapping[str, Sequence[boards.CorePair]], notes: Mapping[str, str]
) -> boards.CoreList:
    """A list with its ranks, and why little forgetting is no rank, from the notes of ranked submissions."""
    ranked = [row.name for row in rows if row.ranked]
    learners = [name for name in ranked if not notes[name]]
    final = ranks(ranked, pairs[FINAL.name], FINAL.better)
    forgetting = ranks(learners, pairs[FORGETTING.name], FORGETTING.better)
    made = []
    for row in rows:
        end, lost = row.metrics[FINAL.name], row.metrics[FORGETTING.name]
        end = replace(end, rank=final.get(row.name))
        lost = replace(lost, rank=forgetting.get(row.name), rank_note=notes.get(row.name, ""))
        made.append(replace(row, metrics=row.metrics | {FINAL.name: end, FORGETTING.name: lost}))
    return boards.CoreList(task_conditioned=rows[0].task_conditioned, ranked=len(ranked), rows=tuple(made))


def left_out(logs: Mapping[str, GroupScore]) -> Iterator[tuple[str, list[str]]]:
    """What is left out in turn, and the groups of the core with it: each body, each kind of change, and each
    group with a provisional expert. ``logs`` are those of a submission, by group id.
    """
    bodies = {name: catalog.group(name).tasks[0].body.name for name in logs}
    for body in dict.fromkeys(bodies.values()):
        yield body, [name for name in logs if bodies[name] == body]
    for kind, names in catalog.SUITES.items():
        if found := [name for name in logs if name in names]:
            yield kind, found
    for name, log in logs.items():
        if any(task.provisional for task in log.reference.values()):
            yield name, [name]


def _variants(
    cards: Sequence[Scorecard], methods: Sequence[Method], lists: Sequence[Sequence[str]]
) -> Iterator[boards.CoreVariant]:
    """The core without some groups; and by the interquartile mean over runs and tasks, each weighed alike.

    ``cards`` and ``methods`` are those of the ranked submissions, whose names ``lists`` has.
    """
    if not cards:
        return
    logs = [core_score.core_logs(card) for card in cards]
    for key, absent in left_out(logs[0]):
        kept = [at for at, name in enumerate(CORES[CORE]) if name not in absent]
        groups = tuple(CORES[CORE][at] for at in kept)
        of_kept, means = [], []
        for log, method in zip(logs, methods, strict=True):
            runs = tuple(method.values[FINAL.name][at] for at in kept)
            starts = tuple(method.starts[at] for at in kept)
            of_kept.append(replace(method, values={FINAL.name: runs}, starts=starts))
            means.append(core_score.over_groups([log[name] for name in groups], FINAL, method.look))
        title = f"{key.rpartition('-v')[0]} (provisional expert)" if key in absent else key
        scores = _in_lists(of_kept, means, lists)
        yield boards.CoreVariant(
            name=f"without-{key}", title=f"without {title}", groups=groups, scores=scores
        )
    of_middle, middles = [], []
    for log, method in zip(logs, methods, strict=True):
        looks = [look for look in core_score.LOOKS if look <= method.look]
        shares = {look: statistics.iqm_shares(core_score.final_scores(log.values(), look)) for look in looks}
        by_look = {look: tuple(map(tuple, each)) for look, each in shares.items()}
        of_middle.append(replace(method, by_look=by_look))
        of_groups = list(map(summary, shares[method.look]))
        middles.append(statistics.to_interval(statistics.mean_of_groups(of_groups)))
    title, scores = "interquartile mean over runs and tasks", _in_lists(of_middle, middles, lists)
    yield boards.CoreVariant(name="interquartile-mean", title=title, groups=CORES[CORE], scores=scores)


def _in_lists(
    methods: Sequence[Method],
    means: Sequence[values.Estimate | statistics.Interval],
    lists: Sequence[Sequence[str]],
) -> dict[str, boards.VariantScore]:
    """The scores of a variant with places and ranks in the lists, which name their members."""
    pairs, found = compared_pairs(methods, FINAL.name), {}
    by_name = {method.name: value for method, value in zip(methods, means, strict=True)}
    for members in lists:
        possible = ranks(members, pairs, FINAL.better)
        for name in members:
            own = by_name[name]
            place = 1 + sum((by_name[other].mean or 0.0) > (own.mean or 0.0) for other in members)
            found[name] = boards.VariantScore(own.mean, own.low, own.high, place, possible[name])
    return found
