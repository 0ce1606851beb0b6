"""What docs/findings.md says of other orders of the tasks, as soon as submissions have runs in them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import pandas as pd
from scipy.stats import kendalltau

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.metrics.formulas import FINAL, FORGETTING
from gym_extensions.metrics.statistics import difference, interval
from gym_extensions.scoring.group_score import GroupScore
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.core_score import final_scores
from tools.findings.tables import COLUMNS, Value, value, values_of


@dataclass(frozen=True)
class Orders:
    """The methods of a group with runs in another order, at the standard budget.

    Attributes:
        group: its name.
        ends: by method, the score at the end in ascending and in the other order; NaN without such runs.
        agreement: Kendall's τ of both orders over the methods that have both; None unless three or more have.
        positions: by method with a whole square, its score at the end by position, over all tasks equally.
        shares: by the same methods, those of position, task and rest in the score at the end, then in
            forgetting; empty where all values are equal.
    """

    group: str
    ends: Mapping[str, Sequence[Value]]
    agreement: float | None
    positions: Mapping[str, Sequence[Value]]
    shares: Mapping[str, Sequence[Sequence[Value]]]

    def place(self, method: str, at: int) -> str:
        """The place of a method by its mean in one order, among two or more that have it; empty without."""
        known = {name: ends[at].mean for name, ends in self.ends.items() if ends[at].is_known}
        if method not in known or len(known) < 2:
            return ""
        return f"{1 + sum(mean > known[method] for mean in known.values())}. "


def agreement(names: Sequence[str], rows: Sequence[Sequence[float]]) -> dict[tuple[str, str], float]:
    """Kendall's τ of every two columns, over the rows that have both, where these are three or more.

    ``rows`` has a value, or NaN, for each of the names.
    """
    found = {}
    for first, second in combinations(range(len(names)), 2):
        both = [(row[first], row[second]) for row in rows]
        both = [pair for pair in both if not any(map(math.isnan, pair))]
        if len(both) > 2:
            found[names[first], names[second]] = float(kendalltau(*zip(*both, strict=True)).statistic)
    return found


def orders(metrics: pd.DataFrame, effects: pd.DataFrame, other: str) -> list[Orders]:
    """Every group with runs in an order, from ``results.metrics`` and ``results.order_effects``."""
    found, both = [], ("sequential", other)
    effects = effects[effects["budget"] == STANDARD_BUDGET]
    others = metrics[(metrics["protocol"] == other) & (metrics["budget"] == STANDARD_BUDGET)]
    for group in GROUPS.values():
        names = others[others["group"] == group.id]["name"].unique()
        if not len(names):
            continue
        ends = {name: [value(metrics, name, group.id, FINAL.name, order) for order in both] for name in names}
        means = [[each.mean for each in row] for row in ends.values()]
        positions, shares = {}, {}
        for name in names if other == "balanced" else ():
            own = effects[(effects["submission"] == name) & (effects["group"] == group.id)]
            if at := effect_values(own, FINAL.name, "position"):
                positions[name] = at
                shares[name] = [effect_values(own, each.name, "share") for each in (FINAL, FORGETTING)]
        found.append(Orders(group.name, ends, agreement(both, means).get(both), positions, shares))
    return found


def effect_values(effects: pd.DataFrame, metric: str, kind: str) -> list[Value]:
    """The effects on a metric of a kind (``position``, ``share``), in their order."""
    return values_of(effects[(effects["metric"] == metric) & (effects["kind"] == kind)])


@dataclass(frozen=True)
class Turned:
    """A method that learned the tasks of a group in ascending and in descending order.

    Attributes:
        group, method: their names.
        ends: in ascending and in descending order, the score at the end on each task of the group.
        changes: descending minus ascending order, with Welch's interval, of each metric of ``COLUMNS``.
    """

    group: str
    method: str
    ends: tuple[Sequence[Value], Sequence[Value]]
    changes: Sequence[Value]


def turned(cards: Sequence[Scorecard]) -> list[Turned]:
    """Every method and group with at least two runs in each of the two orders, by group."""
    found = []
    for group in GROUPS.values():
        for card in cards:
            up, down = card.log(group.id, "sequential"), card.log(group.id, "descending")
            if up and down and min(len(up.runs), len(down.runs)) > 1:
                changes = [difference(down.metrics[name].runs, up.metrics[name].runs) for name in COLUMNS]
                ends = ends_by_task(up), ends_by_task(down)
                found.append(Turned(group.name, card.name, ends, [Value.of(each) for each in changes]))
    return found


def ends_by_task(log: GroupScore) -> list[Value]:
    """The score at the end on each task, over all runs."""
    (scores,) = final_scores([log], len(log.runs))
    return [Value.of(interval(of_task)) for of_task in scores.T.tolist()]
