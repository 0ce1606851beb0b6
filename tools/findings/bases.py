"""What docs/findings.md says of the same additions to TRPO and PPO, from the runs that there are."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.special import fdtrc

from gym_extensions.metrics.statistics import (
    Summary,
    holm_adjusted,
    mean_of_groups,
    subtract,
    summary,
    to_interval,
)
from tools.findings.claims import GroupRuns
from tools.findings.orders import agreement
from tools.findings.tables import NONE, Value, of_edition

GROUPS = ("hopper-gravity-v0", "halfcheetah-gravity-v0", "walker2d-wall-v0")
BASES = {"trpo": "TRPO", "ppo": "PPO"}
"""The learners by the name of their agent."""
ALONE = {"trpo": "trpo", "ppo": "ppo-tuned"}
"""Their submissions without an addition. The additions to PPO have its tuned settings."""
ADDITIONS = ("reset", "snapshots", "cloning", "online-ewc", "packnet")


def submission(base: str, addition: str = "") -> str:
    """The submission of a base with an addition, if any; those to ``trpo`` have the name of the addition."""
    if not addition:
        return ALONE[base]
    return of_edition(addition, 2) if base == "trpo" else f"ppo-{addition}-tuned"


def equal_means_p(estimates: Sequence[Summary]) -> float:
    """The p value of equal means of two or more independent estimates (Welch 1951).

    Their variances may differ. Of two it is that of Welch's t test. If none has a variance, it is 1 for equal
    means and 0 for others.
    """
    means, errors, df = np.array([(each.mean, each.squared_error, each.df) for each in estimates]).T
    if not errors.any():
        return float((means == means[0]).all())
    weights, count = 1 / np.maximum(errors, 1e-12 * errors.max()), len(means)
    shares = weights / weights.sum()
    between = weights @ (means - shares @ means) ** 2 / (count - 1)
    spread = ((1 - shares) ** 2 / df).sum() / (count * count - 1)
    p = fdtrc(count - 1, 1 / (3 * spread), between / (1 + 2 * (count - 2) * spread))
    return float(f"{p:.12g}")


@dataclass(frozen=True)
class BaseByAddition:
    """The score at the end, as a mean over ``GROUPS``, of bases with additions.

    Attributes:
        ends: by base, its score without an addition; NaN without runs, as everywhere here.
        effects: by addition and base, the score with the addition minus the score without.
        same: by addition that two or more bases have, the p value of equal effects, Welch's test of 1951 with
            Holm's correction over additions. Runs of different bases are independent.
        agreement: Kendall's τ of the scores on two bases, over the additions, and none, that both have, where
            these are three or more.
        missing: the submissions without two runs in each group.
    """

    ends: Mapping[str, Value]
    effects: Mapping[str, Mapping[str, Value]]
    same: Mapping[str, float]
    agreement: Mapping[tuple[str, str], float]
    missing: tuple[str, ...]

    def addition(self, name: str) -> str | None:
        """The addition to TRPO that a submission is."""
        return next((each for each in ADDITIONS if submission("trpo", each) == name), None)

    def smallest(self, addition: str) -> tuple[str, Value, list[str]] | None:
        """The base on which an addition has its smallest effect, the effect, and all bases that have it; None
        if fewer than two have it.
        """
        known = {BASES[base]: value for base, value in self.effects[addition].items() if value.is_known}
        if len(known) < 2:
            return None
        base = min(known, key=known.__getitem__)
        return base, known[base], list(known)


def base_by_addition(finals: Mapping[str, GroupRuns]) -> BaseByAddition:
    """The table, from the score at the end of every run, by submission and group id."""
    summaries = {
        name: [summary(runs[group]) for group in GROUPS]
        for name, runs in finals.items()
        if all(len(runs.get(group, ())) > 1 for group in GROUPS)
    }
    scores, effects, missing = dict[tuple[str, str], Summary](), dict[tuple[str, str], Summary](), []
    for base, addition in product(BASES, ("", *ADDITIONS)):
        name, alone = submission(base, addition), summaries.get(submission(base))
        if name not in summaries:
            missing.append(name)
            continue
        scores[base, addition] = mean_of_groups(summaries[name])
        if addition and alone:
            pairs = zip(summaries[name], alone, strict=True)
            effects[base, addition] = mean_of_groups([subtract(*pair) for pair in pairs])
    by_addition = {
        addition: [effects[base, addition] for base in BASES if (base, addition) in effects]
        for addition in ADDITIONS
    }
    several = {addition: found for addition, found in by_addition.items() if len(found) > 1}
    adjusted = holm_adjusted(np.array([equal_means_p(found) for found in several.values()]))
    means = [
        [scores[base, addition].mean if (base, addition) in scores else math.nan for base in BASES]
        for addition in ("", *ADDITIONS)
    ]
    return BaseByAddition(
        ends={base: value_of(scores.get((base, ""))) for base in BASES},
        effects={
            addition: {base: value_of(effects.get((base, addition))) for base in BASES}
            for addition in ADDITIONS
        },
        same=dict(zip(several, adjusted.tolist(), strict=True)),
        agreement=agreement(list(BASES), means),
        missing=tuple(missing),
    )


def value_of(estimate: Summary | None) -> Value:
    """The value of an estimate; NaN without one."""
    return Value.of(to_interval(estimate)) if estimate else NONE
