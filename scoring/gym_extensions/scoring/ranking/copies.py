"""Which submissions of a board are copies or have unusually equal runs, and which are of one family."""

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence

from gym_extensions.catalog.protocol import IN_ORDER
from gym_extensions.metrics.statistics import smaller_spread_p, standard_deviation
from gym_extensions.scoring.group_score import SKETCH_SIZE, Sketch
from gym_extensions.scoring.ranking.boards import BoardKey, logs_on
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.submissions.review import is_verified

COPY = "Has most episodes of {}."
"""Why a copy has no rank."""
SHARE = 0.5
"""Least share of common episodes of two runs, and of such runs of a submission, that makes it a duplicate."""

ALIKE_SHARE, ALIKE_ALPHA, ALIKE_OTHERS = 1 / 3, 0.01, 2
"""Runs are unusually alike if their standard deviation is significantly below this share of that of the other
submissions, of which there are at least two: honest methods differ in spread, but less than that."""
ALIKE = "The runs are unusually alike, so the interval may not be trusted: "
ALIKE += "their standard deviation is {:.2g}, that of the others {:.2g} (F test, p = {:.1g})."


def duplicates(cards: Sequence[Scorecard], key: BoardKey) -> dict[str, str]:
    """The original of each submission that is a copy, by name. Only logs of tasks in order can show that.

    Methods that differ between tasks alone rightly have equal single-task logs, and joint training is the
    same for them. Of identical submissions the original is one with verified runs in each group, then the one
    that was accepted first, then the first by name.
    """
    if key.protocol not in IN_ORDER:
        return {}

    def original_first(card: Scorecard) -> tuple[bool, str, str]:
        waits = any({*log.runs} <= {*log.unverified} for log in logs_on(card, key).values())
        return waits, card.accepted or "9999", card.name

    def sketches(card: Scorecard) -> list[Sketch]:
        return [
            tuple(f"{name} {digest}" for digest in sketch)  # equal episodes in two groups are two
            for name, log in logs_on(card, key).items()
            for sketch in log.episode_sketches
        ]

    return duplicate_submissions({card.name: sketches(card) for card in sorted(cards, key=original_first)})


def duplicate_submissions(submissions: Mapping[str, Sequence[Sketch]]) -> dict[str, str]:
    """The original that shares most episodes with a submission, by the name of the later submission.

    Two submissions share most episodes if half of the runs of either do: a copy with further runs, with
    changed runs or episodes, or without its training curves is still recognized. Of submissions that share
    most episodes, the first of the mapping, which has the sketches of their runs, is the original.
    """

    def has_most(first: Sequence[Sketch], second: Sequence[Sketch]) -> bool:
        """Whether half of the runs of the first share most episodes with a run of the second."""
        return sum(any(is_common(run, each) for each in second) for run in first) >= SHARE * len(first)

    holders: dict[str, list[str]] = defaultdict(list)
    copies: dict[str, str] = {}
    for name, sketches in submissions.items():
        digests = {digest for sketch in sketches for digest in sketch}
        suspected = {other for digest in digests for other in holders[digest]}
        for other, theirs in submissions.items():
            if other in suspected and (has_most(sketches, theirs) or has_most(theirs, sketches)):
                copies[name] = other
                break
        else:
            for digest in digests:
                holders[digest].append(name)
    return copies


def is_common(first: Sketch, second: Sketch) -> bool:
    """Whether two runs share at least half of their episodes, as estimated from their sketches.

    Two runs of n episodes with f n common ones have f / (2 − f) common ones per episode of either.
    """
    union = sorted({*first, *second})[:SKETCH_SIZE]
    return bool(union) and len({*first} & {*second} & {*union}) >= SHARE / (2 - SHARE) * len(union)


def unusually_alike(submissions: Mapping[str, Sequence[float]], alpha: float) -> dict[str, str]:
    """What to say of submissions whose runs are unusually alike, by name: five made from one, for example.

    ``submissions`` have a value per run, of two runs or more. The spread is compared, not the values.
    """
    found = {}
    for name, runs in submissions.items():
        others = [each for other, each in submissions.items() if other != name]
        if len(others) < ALIKE_OTHERS:
            continue
        p_value, pooled = smaller_spread_p(runs, others, ALIKE_SHARE)
        if p_value <= alpha:
            found[name] = ALIKE.format(standard_deviation(runs, ddof=1), pooled, p_value)
    return found


def alike_on(cards: Sequence[Scorecard], key: BoardKey, metric: str) -> dict[str, str]:
    """What to say of the verified submissions of a board whose runs of a group are unusually alike, by name.

    At the floor all runs are alike: a submission counts on a group where its interval is above 0. The level
    of the test is divided by the number of groups.
    """
    found: dict[str, str] = {}
    for group_id in key.groups:
        logs = {card.name: card.log(group_id, key.protocol) for card in cards}
        values = {name: log.metrics[metric] for name, log in logs.items() if log and is_verified(log.level)}
        runs = {name: value.runs for name, value in values.items() if value.ends and value.ends[0] > 0}
        for name, text in unusually_alike(runs, ALIKE_ALPHA / len(key.groups)).items():
            found.setdefault(name, text if len(key.groups) == 1 else f"{group_id}: {text}")
    return found


def family(algorithm: str) -> str:
    """The family of an algorithm: its name up to the first character that is not a letter or digit.

    >>> family("trpo-2017"), family("SAC_fresh_buffer")
    ('trpo', 'sac')
    """
    return re.split(r"[\W_]", algorithm.strip().casefold(), maxsplit=1)[0]


def related_submissions(cards: Mapping[str, Scorecard]) -> dict[str, tuple[str, ...]]:
    """The other submissions with a common author and the same family, by the submission's name."""
    groups: dict[tuple[str, str], set[str]] = defaultdict(set)
    for name, card in cards.items():
        if card.manifest:
            algorithm = family(card.manifest.protocol.algorithm)
            for author in card.manifest.authors:
                groups[" ".join(author.split()).casefold(), algorithm].add(name)
    related = {name: set().union(*(group for group in groups.values() if name in group)) for name in cards}
    return {name: tuple(sorted(others - {name})) for name, others in related.items()}
