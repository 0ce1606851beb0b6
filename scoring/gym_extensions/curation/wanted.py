"""Which runs would help the core board most: those that complete the next look of an entry."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import NormalDist

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.submission import finished_runs
from gym_extensions.catalog.groups import CORE, CORES, group
from gym_extensions.rollouts.manifest import RECORDED
from gym_extensions.scoring.pipeline import make_scorer, scorecards
from gym_extensions.scoring.ranking.boards import CoreBoard, CoreEntry, CorePair
from gym_extensions.scoring.ranking.core_board import LOOK_LEVELS, core_board
from gym_extensions.scoring.scorecard import Scorecard

NORMAL = NormalDist()


@dataclass(frozen=True)
class Wanted:
    """What an entry in a folder, of an agent of this project, needs for its next look at n runs.

    ``runs`` are the numbers of the missing sequential runs by group name. ``decides`` is how many open
    comparisons the look would decide, about; None for an entry without any.
    """

    entry: Path
    agent: str
    budget: str
    look: int
    runs: Mapping[str, tuple[int, ...]]
    decides: float | None

    @property
    def count(self) -> int:
        """The number of missing runs."""
        return sum(map(len, self.runs.values()))

    @property
    def commands(self) -> Iterator[str]:
        """A command for each group, which trains the missing runs; ``--runs`` may name any one of them."""
        for name, runs in self.runs.items():
            words = ["gym-extensions", "train", self.agent, "--groups", name, "--protocol", "sequential"]
            words += ["--budget", self.budget, "--runs", ",".join(map(str, runs)), "--out", str(self.entry)]
            yield shlex.join(words)


def wanted(folders: Sequence[Path]) -> list[Wanted]:
    """What the entries of this project's agents need, of all entries; first what decides most per run."""
    cards = list(scorecards(folders, make_scorer(only=("core",))))
    board = core_board([card for card in cards if not card.withdrawn])
    by_name = {card.name: (folder, card) for folder, card in zip(folders, cards, strict=True)}
    rows = board.rows if board else ()
    found = [_of(row, *by_name[row.name], board) for row in rows if board and row.next_look]
    present = [each for each in found if each is not None and each.count]
    return sorted(
        present, key=lambda each: (each.decides is None, -(each.decides or 0.0) / each.count, each.entry.name)
    )


def _of(row: CoreEntry, folder: Path, card: Scorecard, board: CoreBoard) -> Wanted | None:
    """What an entry needs; None if runs of it cannot be donated, or would not be compared."""
    protocol = card.manifest.protocol if card.manifest else None
    is_own = protocol and protocol.steps == RECORDED and protocol.algorithm in algorithms.names()
    could_be_ranked = row.ranked or row.look == 0
    if protocol is None or not is_own or not could_be_ranked or row.next_look is None:
        return None
    runs = {}
    for name in CORES[CORE]:
        members = group(name)
        missing = set(range(row.next_look)) - finished_runs(folder, members, "sequential")
        if missing:
            runs[members.name] = tuple(sorted(missing))
    decides = _decides(row, board) if row.ranked else None
    return Wanted(folder, protocol.algorithm, protocol.budget, row.next_look, runs, decides)


def _decides(row: CoreEntry, board: CoreBoard) -> float:
    """About how many open comparisons the next look of an entry would separate.

    The sum of their powers, if the present differences and deviations are the truth; half of it where the
    other entry needs its next look, too.
    """
    looks = {entry.name: entry.look for entry in board.rows}
    total = 0.0
    for pairs in board.pairs.values():
        for pair in pairs:
            if row.name in (pair.first, pair.second) and pair.verdict == "open" and pair.look == row.look:
                other = pair.second if pair.first == row.name else pair.first
                share = 1.0 if looks[other] > pair.look else 0.5
                total += share * power_at_next_look(pair, len(pairs))
    return total


def power_at_next_look(pair: CorePair, pairs: int) -> float:
    """The power to separate a pair at its next look, with a normal distribution in place of Student's t."""
    if pair.next_look is None:
        return 0.0
    now, then = (-NORMAL.inv_cdf(LOOK_LEVELS[look] / pairs / 2) for look in (pair.look, pair.next_look))
    standard_error = (pair.high - pair.low) / 2 / now
    if standard_error == 0:
        return float(pair.mean != 0)
    return NORMAL.cdf(abs(pair.mean) / standard_error * math.sqrt(pair.next_look / pair.look) - then)


def lines_of(found: Sequence[Wanted]) -> Iterator[str]:
    """What is wanted in words, an entry after the other."""
    for each in found:
        more = "" if each.decides is None else f"; about {each.decides:.1f} comparisons would be decided"
        yield f"{each.entry.name}: {each.count} runs complete its look at {each.look} runs{more}."
        yield from (f"  {command}" for command in each.commands)
    if not found:
        yield "No entry of this project needs runs for its next look."
