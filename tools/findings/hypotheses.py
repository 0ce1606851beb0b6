"""The hypotheses of the second edition and their verdicts, as docs/findings/plan.md states them.

The plan and this module were written before any run of the second edition existed.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.metrics.statistics import holm, interval, summary, zero_mean_p
from gym_extensions.scoring.ranking.boards import CoreBoard, CorePair
from tools.findings.claims import GroupRuns
from tools.findings.tables import FINAL, FINE_TUNING, LOST, Value, of_edition

CONFIRMED, CONTRADICTED, OPEN = "confirmed", "contradicted", "open"
PAIRS = {
    "H1": ("cloning", "trpo", FINAL, 1),
    "H2": ("cloning", "trpo", LOST, -1),
    "H3": ("reset", "trpo", FINAL, -1),
    "H4": ("ppo", "trpo", FINAL, -1),
    "H5": ("snapshots", "packnet", FINAL, 1),
    "H6": ("multi-head", "trpo", FINAL, -1),
}
"""By hypothesis: two methods, the metric, and the sign of first − second that it states."""
PENALTIES, MARGIN = ("l2", "l2-init", "online-ewc"), 0.10
"""The methods of H8, and the limit below which all its upper limits have to lie."""
FORGETTING = tuple(name for name in CORES[CORE] if not name.startswith("hopper-body"))
"""The groups of H7. Holm's procedure is over all groups of the core."""
WORDS = {FINAL: "at the end", LOST: "forgetting"}


@dataclass(frozen=True)
class Verdict:
    """A hypothesis by its number, what was found, and whether that confirms it."""

    name: str
    found: str
    verdict: str


def pair_of(board: CoreBoard, metric: str, name: str, other: str) -> tuple[Value, CorePair] | None:
    """The difference name − other with its adjusted interval, and the pair; None if they are not compared."""
    if (pair := board.pair(metric, name, other)) is None:
        return None
    value = Value(pair.mean, pair.low, pair.high)
    return value if pair.first == name else Value(-pair.mean, -pair.high, -pair.low), pair


def directed(board: CoreBoard, name: str) -> Verdict:
    """The verdict of a hypothesis about a pair of the core."""
    *methods, metric, sign = PAIRS[name]
    first, second = (of_edition(str(each), board.edition) for each in methods)
    if (found := pair_of(board, str(metric), first, second)) is None:
        return Verdict(name, f"`{first}` and `{second}` are not compared", OPEN)
    value, pair = found
    text = f"`{first}` − `{second}`, {WORDS[str(metric)]}: {value}, p = {pair.p_value:.2g}"
    agrees = value.mean * float(sign) > 0
    verdict = OPEN if pair.verdict != "separated" else CONFIRMED if agrees else CONTRADICTED
    return Verdict(name, text, verdict)


def forgetting(lost: GroupRuns) -> list[Verdict]:
    """The verdict of H7 on each group, from the forgetting of the runs of fine-tuning by group id."""
    if any(len(lost.get(name, ())) < 2 for name in CORES[CORE]):
        return [Verdict("H7", f"`{FINE_TUNING}` lacks runs", OPEN)]
    parts = {name: summary(lost[name]) for name in CORES[CORE]}
    p_values = {name: zero_mean_p(part) for name, part in parts.items()}
    rejected = dict(zip(parts, holm(np.array([*p_values.values()])), strict=True))
    found = []
    for name in FORGETTING:
        value, group = Value.of(interval(lost[name])), name.rpartition("-v")[0]
        verdict = OPEN if not rejected[name] else CONFIRMED if value.mean > 0 else CONTRADICTED
        found.append(Verdict("H7", f"{group}: {value}, p = {p_values[name]:.2g}", verdict))
    return found


def penalties(board: CoreBoard) -> Verdict:
    """The verdict of H8."""
    names = [of_edition(each, board.edition) for each in PENALTIES]
    pairs = {name: pair_of(board, FINAL, name, FINE_TUNING) for name in names}
    text = ", ".join(f"`{name}` {each[0] if each else '–'}" for name, each in pairs.items())
    known = [each for each in pairs.values() if each]
    if any(pair.verdict == "separated" and value.mean > 0 for value, pair in known):
        verdict = CONTRADICTED
    else:
        high = max((value.high for value, _ in known), default=math.inf)
        verdict = CONFIRMED if len(known) == len(names) and high < MARGIN else OPEN
    return Verdict("H8", f"minus `{FINE_TUNING}`, at the end: {text}", verdict)


def verdicts(board: CoreBoard, lost: Mapping[str, GroupRuns]) -> list[Verdict]:
    """All verdicts in the second edition; none in the first. ``lost``: forgetting of runs by submission."""
    if board.edition < 2:
        return []
    pairs = [directed(board, name) for name in PAIRS]
    return [*pairs, *forgetting(lost.get(FINE_TUNING, {})), penalties(board)]


class Withdrawn(NamedTuple):
    """A pair whose verdict is another one in the second edition; names are those of the first."""

    first: str
    second: str
    metric: str
    before: str
    after: str


def withdrawn(first: CoreBoard, second: CoreBoard) -> list[Withdrawn]:
    """The pairs of the first edition with another verdict, or direction, in the second."""
    found = []
    for metric, pairs in first.pairs.items():
        for pair in pairs:
            names = [of_edition(name, second.edition) for name in (pair.first, pair.second)]
            if (again := pair_of(second, metric, *names)) is None:
                continue
            before, after = Value(pair.mean, pair.low, pair.high), again[0]
            kinds = [(pair.verdict, before.mean > 0), (again[1].verdict, after.mean > 0)]
            if kinds[0] != kinds[1] and "separated" in (pair.verdict, again[1].verdict):
                stated = (f"{value}, {kind}" for value, (kind, _) in zip((before, after), kinds, strict=True))
                found.append(Withdrawn(pair.first, pair.second, WORDS[metric], *stated))
    return found
