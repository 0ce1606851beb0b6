"""The performance profile of a score, up to its highest value."""

from __future__ import annotations

from bisect import bisect_right

from gym_extensions.scoring.metrics.aggregates import Profile
from gym_extensions.scoring.scorecard.model import GroupScore

STEP = 0.05


def whole_profile(score: GroupScore) -> Profile | None:
    """The document's profile, continued to the right until no run and task is above.

    The document ends at τ = 2. What lies above follows from the return matrix.
    """
    profile = score.profile
    if profile is None or not profile.fraction or profile.fraction[-1] <= 0:
        return profile
    values = sorted(
        share
        for run in score.return_matrix
        for task, value in zip(score.tasks, run[-1], strict=True)
        if (reference := score.reference.get(task)) and (share := reference.normalize(value)) is not None
    )
    if not values:
        return profile
    taus, shares = list(profile.tau), list(profile.fraction)
    while shares[-1] > 0:
        taus.append(round(taus[-1] + _step(values[-1]), 6))
        shares.append((len(values) - bisect_right(values, taus[-1])) / len(values))
    return Profile(tuple(taus), tuple(shares))


def _step(highest: float) -> float:
    """The distance of further points: few points, however far the values reach."""
    return max(STEP, highest / 40)
