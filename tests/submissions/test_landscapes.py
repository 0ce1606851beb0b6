"""Shares of the best return, interpolation and extrapolation, from numbers that can be checked by hand."""

import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.worlds import axes
from gym_extensions.submissions.landscapes import Best, Landscape, MeasuredAxis, best, share, summary

GROUP = group("hopper-gravity")
(AXIS,) = axes(GROUP)


def landscape(*runs: float, first: float = 100.0) -> Landscape:
    """A landscape that is flat at 0 before the last stage; then a run has its value, ``first`` at .3 g."""
    flat = (0.0,) * len(AXIS.points)
    returns = tuple((*(flat,) * 5, (first, *(value,) * (len(flat) - 1))) for value in runs)
    zeros = tuple(tuple(flat for _ in run) for run in returns)
    return Landscape(
        group=GROUP.id,
        episodes=10,
        policies={str(run): "0" * 64 for run in range(len(runs))},
        versions={},
        axes=(MeasuredAxis(name="gravity", points=AXIS.points, returns=returns, deviations=zeros),),
    )


def best_of(*landscapes: Landscape) -> Best:
    return best({str(submission): {GROUP.id: each} for submission, each in enumerate(landscapes)})


def test_the_best_is_the_highest_mean_over_runs_of_any_stage_and_submission() -> None:
    found = best_of(landscape(100.0, 300.0), landscape(150.0, first=400.0))
    assert found == {(GROUP.id, "gravity"): (400.0, *[200.0] * 14)}
    assert best({}) == {}


def test_a_mean_over_runs_is_exact_so_that_all_versions_of_python_give_the_same() -> None:
    assert landscape(*[0.1] * 10).axes[0].means[-1][1:] == (0.1,) * 14


def test_a_share_needs_a_best_return_above_zero() -> None:
    assert share(50.0, 200.0) == 0.25
    assert share(-50.0, 200.0) == -0.25
    assert share(-50.0, 0.0) is None


def test_interpolation_and_extrapolation_are_mean_shares_with_an_interval_over_runs() -> None:
    one = landscape(100.0, 300.0)
    found = summary(one, GROUP, best_of(one, landscape(400.0, first=200.0)))
    assert found["interpolation"].runs == (0.25, 0.75)
    assert found["interpolation"].mean == 0.5
    assert found["interpolation"].ends == pytest.approx((0.5 - 12.706 * 0.25, 0.5 + 12.706 * 0.25), rel=1e-3)
    # five of the six values beyond have the run's share; at .3 g both runs have half of the best
    assert found["extrapolation"].runs == pytest.approx(((5 * 0.25 + 0.5) / 6, (5 * 0.75 + 0.5) / 6))
    assert summary(landscape(100.0), GROUP, best_of(one))["interpolation"].ends is None
