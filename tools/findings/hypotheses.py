"""The hypotheses of the second edition and their verdicts, as docs/findings/plan.md states them.

The plan and this module were written before any run of the second edition existed. The verdicts are written
once, to ``docs/findings/hypotheses.json``.
"""

import math
from collections.abc import Mapping
from dataclasses import replace

import msgspec
import numpy as np

from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.metrics.statistics import ALPHA, holm_adjusted, interval, summary, zero_mean_p
from gym_extensions.scoring.ranking.boards import CoreBoard
from gym_extensions.scoring.ranking.core_board import PLANNED, PLANNED_RUNS, core_board
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.core_score import core_logs, core_score
from tools.findings.claims import GroupRuns, core_runs
from tools.findings.tables import FINE_TUNING, LOST, WORDS, Value, against

CONFIRMED, CONTRADICTED, OPEN = "confirmed", "contradicted", "open"
SIGNS = {"H1": 1, "H2": -1, "H3": -1, "H4": -1, "H5": 1, "H6": -1}
"""The sign of first − second that a hypothesis about a pair of ``PLANNED`` states."""
MARGIN = 0.10
"""All upper limits of H8 have to lie below it."""
FORGETTING = tuple(name for name in CORES[CORE] if not name.startswith("hopper-body"))
"""The groups of H7. Holm's procedure is over all groups of the core."""


class Verdict(msgspec.Struct, frozen=True):
    """A hypothesis by its number, what was found, whether that confirms it, and the commit of the runs."""

    name: str
    found: str
    verdict: str
    commit: str = ""


def directed(board: CoreBoard, name: str) -> Verdict:
    """The verdict of a hypothesis about a pair of the core."""
    ((first, second, metric),) = (row for hypothesis, *row in PLANNED if hypothesis == name)
    if (found := against(board, metric, first, second)) is None:
        return Verdict(name, f"`{first}` and `{second}` are not compared", OPEN)
    text = f"`{first}` − `{second}`, {WORDS[metric]}: {found.value}, p = {found.p_value:.2g}"
    agrees = found.value.mean * SIGNS[name] > 0
    verdict = OPEN if found.verdict != "separated" else CONFIRMED if agrees else CONTRADICTED
    return Verdict(name, text, verdict)


def forgetting(lost: GroupRuns) -> list[Verdict]:
    """The verdict of H7 on each group, from the forgetting of the runs of fine-tuning by group id."""
    if any(len(lost.get(name, ())) < 2 for name in CORES[CORE]):
        return [Verdict("H7", f"`{FINE_TUNING}` lacks runs", OPEN)]
    parts = {name: summary(lost[name]) for name in CORES[CORE]}
    adjusted = holm_adjusted(np.array([zero_mean_p(part) for part in parts.values()]))
    p_values = dict(zip(parts, adjusted.tolist(), strict=True))
    found = []
    for name in FORGETTING:
        value, group = Value.of(interval(lost[name])), name.rpartition("-v")[0]
        verdict = OPEN if p_values[name] > ALPHA else CONFIRMED if value.mean > 0 else CONTRADICTED
        found.append(Verdict("H7", f"{group}: {value}, p = {p_values[name]:.2g}", verdict))
    return found


def penalties(board: CoreBoard) -> Verdict:
    """The verdict of H8."""
    pairs = {
        first: against(board, metric, first, second)
        for name, first, second, metric in PLANNED
        if name == "H8"
    }
    text = ", ".join(f"`{name}` {each.value if each else '–'}" for name, each in pairs.items())
    known = [each for each in pairs.values() if each]
    if any(each.verdict == "separated" and each.value.mean > 0 for each in known):
        verdict = CONTRADICTED
    else:
        high = max((each.value.high for each in known), default=math.inf)
        verdict = CONFIRMED if len(known) == len(pairs) and high < MARGIN else OPEN
    return Verdict("H8", f"minus `{FINE_TUNING}`, at the end: {text}", verdict)


def verdicts(board: CoreBoard, lost: GroupRuns) -> list[Verdict]:
    """All verdicts. ``lost`` is what the runs of fine-tuning forget."""
    pairs = [directed(board, name) for name in SIGNS]
    return [*pairs, *forgetting(lost), penalties(board)]


def tested(cards: Mapping[str, Scorecard], commit: str = "") -> list[Verdict]:
    """All verdicts, over runs 0 to 9, by the scorecards by name. Later runs test nothing again."""

    def of_plan(card: Scorecard) -> Scorecard:
        groups = dict(card.groups)  # with other protocols: the board needs each task alone
        for name, log in core_logs(card).items():
            groups[name] = groups[name] | {"sequential": replace(log, runs=log.runs[:PLANNED_RUNS])}
        card = replace(card, groups=groups)
        return replace(card, core=core_score(card))

    planned = {name: of_plan(card) for name, card in cards.items()}
    board = core_board(list(planned.values()))
    assert board is not None
    found = verdicts(board, core_runs(planned[FINE_TUNING], LOST))
    return [msgspec.structs.replace(each, commit=commit) for each in found]
