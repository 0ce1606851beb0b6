"""Lists the runs that would help the core board most: those that complete the next look of a submission.

    python -m tools.wanted [SUBMISSION …]

Those come first that would decide most comparisons per run. Each is one command, and one pull request may
bring any of them.
"""

from __future__ import annotations

import argparse
import math
import shlex
from collections.abc import Sequence
from pathlib import Path
from statistics import NormalDist

from gym_extensions.baselines.submission import finished_runs
from gym_extensions.catalog.groups import CORE, CORES, group
from gym_extensions.errors import reports_mistakes
from gym_extensions.scoring.pipeline import find_submissions, make_scorer, scorecards
from gym_extensions.scoring.ranking.boards import CoreBoard, CorePair, CoreRow
from gym_extensions.scoring.ranking.core_board import core_board
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.core_score import LOOK_LEVELS
from gym_extensions.verification.after_merge import is_of_this_project

NORMAL = NormalDist()


def wanted(folders: Sequence[Path]) -> list[str]:
    """What the submissions of this project's agents need for their next look, of all submissions, in words.

    First what decides most open comparisons per run. After the line of a submission follows a command for
    each group, which trains its missing runs; ``--runs`` may name any one of them.
    """
    cards = list(scorecards(folders, make_scorer(only=("core",))))
    board = core_board(cards)
    by_name = {card.name: (folder, card) for folder, card in zip(folders, cards, strict=True)}
    found = []
    for row in board.rows if board else ():
        folder, card = by_name[row.name]
        runs = _missing(row, folder, card)
        if board is None or card.manifest is None or not runs:
            continue
        decides, count = _decides(row, board) if row.ranked else None, sum(map(len, runs.values()))
        more = "" if decides is None else f"; about {decides:.1f} comparisons would be decided"
        lines = [f"{row.name}: {count} runs complete its look at {row.next_look} runs{more}."]
        agent, budget = card.manifest.protocol.algorithm, card.manifest.protocol.budget
        for name, numbers in runs.items():
            words = ["gym-extensions", "train", agent, "--groups", name, "--protocol", "sequential"]
            words += ["--budget", budget, "--runs", ",".join(map(str, numbers)), "--out", str(folder)]
            lines.append(f"  {shlex.join(words)} --by NAME")
        found.append(((decides is None, -(decides or 0.0) / count, row.name), lines))
    lines = [line for _, of_submission in sorted(found) for line in of_submission]
    return lines or ["No submission of a reference agent needs runs for its next look."]


def _missing(row: CoreRow, folder: Path, card: Scorecard) -> dict[str, list[int]]:
    """The sequential runs by group that a submission lacks; none if none can be donated or compared."""
    is_own = card.manifest is not None and is_of_this_project(card.manifest.protocol)
    could_be_ranked = row.ranked or row.look == 0
    if not is_own or not could_be_ranked or row.next_look is None:
        return {}
    wanted = set(range(row.next_look))
    lacking = {each: wanted - finished_runs(folder, each, "sequential") for each in map(group, CORES[CORE])}
    return {each.name: sorted(runs) for each, runs in lacking.items() if runs}


def _decides(row: CoreRow, board: CoreBoard) -> float:
    """About how many open comparisons the next look of a submission would separate.

    The sum of their powers, if the present differences and deviations are the truth; half of it where the
    other submission needs its next look, too.
    """
    looks = {submission.name: submission.look for submission in board.rows}
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


@reports_mistakes
def main(argv: Sequence[str] | None = None) -> int:
    """Prints the runs that submissions need."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    help_ = "all submissions of the board (default: submissions)"
    parser.add_argument("submissions", nargs="*", type=Path, default=[Path("submissions")], help=help_)
    options = parser.parse_args(argv)
    print("\n".join(wanted(find_submissions(options.submissions))))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
