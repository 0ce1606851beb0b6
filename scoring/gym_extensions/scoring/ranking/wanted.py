"""The runs that would help the core board most: those that complete the next look of a submission."""

import math
import shlex
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from statistics import NormalDist

from gym_extensions.catalog.groups import CORE, CORES, group
from gym_extensions.catalog.protocol import BUDGETS, STANDARD_BUDGET
from gym_extensions.scoring.ranking.boards import CoreBoard, CorePair, CoreRow
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.core_score import LOOK_LEVELS, core_logs
from gym_extensions.submissions.review import TRAINED_HERE

NORMAL = NormalDist()


@dataclass(frozen=True)
class Wanted:
    """The runs that a submission lacks for its next look.

    Attributes:
        name: of the submission.
        agent: the reference agent that trains them.
        look: number of runs per group that they complete.
        runs: their numbers by group.
        decides: about how many open comparisons they would separate; None for a submission without a rank.
        hours: processor time of all, by what a step of its other runs took; None if that is not known.
        trained_here: whether only maintainers can train them: others would not be compared.
    """

    name: str
    agent: str
    look: int
    runs: dict[str, list[int]]
    decides: float | None
    hours: float | None
    trained_here: bool

    @property
    def count(self) -> int:
        """The number of runs."""
        return sum(map(len, self.runs.values()))

    @property
    def rate(self) -> float:
        """Comparisons that are decided per processor hour; per run where the time is not known."""
        return (self.decides or 0.0) / (self.hours or self.count)

    def commands(self, folder: str = "") -> list[str]:
        """What trains them into the submission's folder: a command for each set of numbers."""
        out = folder or f"submissions/{self.name}"
        if self.trained_here:
            return [shlex.join(["gym-extensions", "maintain", "train-here", out, "--runs", str(self.look)])]
        by_numbers: dict[str, list[str]] = {}
        for name, runs in self.runs.items():
            is_range = runs == list(range(runs[0], runs[-1] + 1)) and len(runs) > 2
            numbers = f"{runs[0]}-{runs[-1]}" if is_range else ",".join(map(str, runs))
            by_numbers.setdefault(numbers, []).append(name)
        lines = []
        for numbers, names in by_numbers.items():
            words = ["gym-extensions", "train", self.agent, "--groups", ",".join(names)]
            words += ["--budget", STANDARD_BUDGET, "--runs", numbers, "--out", out]
            lines.append(f"{shlex.join(words)} --by NAME")
        return lines


def wanted(cards: Sequence[Scorecard], board: CoreBoard | None, agents: Collection[str]) -> list[Wanted]:
    """What submissions of this project's agents, given by name, or trained here, need for their next look.

    First what decides most open comparisons per hour of processor time, then submissions without a rank. In
    the second edition, all are trained here; code that was changed waits for its training and needs nothing.
    """
    if board is None:
        return []
    by_name, found = {card.name: card for card in cards}, []
    for row in board.rows:
        card, look = by_name[row.name], row.next_look
        assert card.manifest is not None, "it has runs"
        agent = card.manifest.protocol.algorithm
        is_here = any(log.level == TRAINED_HERE for log in core_logs(card).values())
        can_be_donated = board.edition == 1 and card.steps_counted and agent in agents
        waits = card.training is not None and card.training.outdated
        if look is None or waits or not (is_here or can_be_donated) or not (row.ranked or row.look == 0):
            continue
        if runs := _missing(card, look):
            decides = decided_by(row, board) if row.ranked else None
            found.append(Wanted(row.name, agent, look, runs, decides, _hours(card, runs), is_here))
    return sorted(found, key=lambda each: (each.decides is None, -each.rate, each.name))


def _missing(card: Scorecard, look: int) -> dict[str, list[int]]:
    """The sequential runs by group that a submission lacks for a look.

    A run after a gap is not scored, and counts as lacking; the command skips it.
    """
    logs, needed = core_logs(card), set(range(look))
    lacking = {each: needed - set(logs[each].runs if each in logs else ()) for each in CORES[CORE]}
    return {group(name).name: sorted(runs) for name, runs in lacking.items() if runs}


def _hours(card: Scorecard, runs: dict[str, list[int]]) -> float | None:
    """The processor time of these runs, if each step takes as long as in the submission's other runs."""
    if not card.cost or not card.cost.steps or card.cost.timed_groups < card.cost.groups:
        return None
    budget = BUDGETS[STANDARD_BUDGET]
    steps = sum(
        budget.steps_for(name) * len(group(name).tasks) * len(numbers) for name, numbers in runs.items()
    )
    return steps * card.cost.cpu_seconds / card.cost.steps / 3600


def decided_by(row: CoreRow, board: CoreBoard) -> float:
    """About how many open comparisons the next look of a submission would separate.

    The sum of their powers, if the present differences and deviations are the truth; half of it where the
    other submission needs its next look, too.
    """
    looks = {submission.name: submission.look for submission in board.rows}
    total = 0.0
    for pairs in board.pairs.values():
        for pair in pairs:
            if row.name in (pair.first, pair.second) and pair.next_look and pair.look == row.look:
                other = pair.second if pair.first == row.name else pair.first
                share = 1.0 if looks[other] > pair.look else 0.5
                total += share * power_at_next_look(pair, len(pairs))
    return total


def power_at_next_look(pair: CorePair, pairs: int) -> float:
    """The power to separate an open pair at its next look, by a normal distribution, not Student's t."""
    assert pair.next_look is not None
    now, then = (-NORMAL.inv_cdf(LOOK_LEVELS[look] / pairs / 2) for look in (pair.look, pair.next_look))
    standard_error = (pair.high - pair.low) / 2 / now
    return NORMAL.cdf(abs(pair.mean) / standard_error * math.sqrt(pair.next_look / pair.look) - then)
