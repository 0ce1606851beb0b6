"""The test of logged against new returns: honest submissions pass, selected episodes do not."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from gym_extensions.submissions.review import NEW_SEEDS_ALPHA
from gym_extensions.verification import new_seeds
from gym_extensions.verification.new_seeds import TaskReturns, compare

Array = NDArray[np.float64]
Draw = Callable[[np.random.Generator, tuple[int, ...]], Array]

RUNS = [run for run in range(5) for _ in range(2)]
STAGES = [stage for _ in range(5) for stage in range(2)]
"""The runs and stages of the ten cells of a task."""


def honest(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """Returns of mean 1 and standard deviation .27."""
    return 1 + 0.27 * rng.standard_normal(shape)


def best_of_two(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """The better of two episodes, which raises the mean by 15 %."""
    return np.maximum(honest(rng, shape), honest(rng, shape))


def best_cell_of_five(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """The best of five evaluations of 20 episodes, which raises the mean by 8 % at a deviation of .31."""
    returns = 1 + 0.31 * rng.standard_normal((5, *shape))
    best = returns.mean(axis=2).argmax(axis=0)
    return np.stack([returns[best[cell], cell] for cell in range(shape[0])])


def p_value(logged: Draw, seed: int, fresh: Draw = honest, tasks: int = 5) -> float:
    rng = np.random.default_rng(seed)
    shape = (len(RUNS), 20)
    submission = [TaskReturns(RUNS, STAGES, logged(rng, shape), fresh(rng, shape)) for _ in range(tasks)]
    return compare(submission, rng)


def test_honest_submissions_pass() -> None:
    p_values = [p_value(honest, seed) for seed in range(20)]
    assert min(p_values) > NEW_SEEDS_ALPHA
    assert np.median(p_values) > 0.3


@pytest.mark.parametrize("attack", [best_of_two, best_cell_of_five])
def test_selected_episodes_and_cells_are_refused(attack: Draw) -> None:
    assert max(p_value(attack, seed) for seed in range(5)) <= NEW_SEEDS_ALPHA


def test_lower_logged_returns_pass() -> None:
    assert p_value(honest, 0, fresh=best_of_two) == 1.0


def test_one_invented_run_of_five_is_refused() -> None:
    def one_run(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        returns = honest(rng, shape)
        returns[:2] = best_of_two(rng, (2, shape[1]))
        return returns

    assert max(p_value(one_run, seed) for seed in range(5)) <= NEW_SEEDS_ALPHA


def test_one_invented_cell_of_fifty_is_refused() -> None:
    calls: list[None] = []

    def one_cell(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        returns = honest(rng, shape)
        if not calls:
            returns[0] += 1.0
        calls.append(None)
        return returns

    assert p_value(one_cell, 0) <= NEW_SEEDS_ALPHA


def test_seeds_that_are_easy_for_all_policies_are_no_evidence() -> None:
    """With seeds of unequal difficulty, exchanging single returns would reject honest submissions."""

    def shared(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        return rng.standard_normal((1, shape[1])) + 0.1 * rng.standard_normal(shape)

    p_values = [p_value(shared, seed, fresh=shared, tasks=2) for seed in range(40)]
    assert sum(p <= NEW_SEEDS_ALPHA for p in p_values) <= 1
    assert sum(p <= 0.1 for p in p_values) <= 10


def test_noise_that_an_agent_draws_in_all_tasks_is_no_evidence() -> None:
    """The episodes of one number are lucky in all tasks of a run; new episodes have noise of their own."""

    def submission(seed: int) -> float:
        rng = np.random.default_rng(seed)
        noise = rng.standard_normal((5, 20))
        tasks = [
            TaskReturns(
                range(5), [0] * 5, noise + 0.5 * rng.standard_normal((5, 20)), rng.standard_normal((5, 20))
            )
            for _ in range(5)
        ]
        return compare(tasks, rng)

    p_values = [submission(seed) for seed in range(40)]
    assert sum(p <= NEW_SEEDS_ALPHA for p in p_values) <= 1
    assert sum(p <= 0.1 for p in p_values) <= 10


def test_constant_returns_pass() -> None:
    constant = np.full((2, 20), -100.0)
    rng = np.random.default_rng(0)
    assert compare([TaskReturns([0, 1], [0, 1], constant, constant)], rng) == 1.0
    assert compare([], rng) == 1.0


def test_invented_returns_of_a_constant_policy_are_refused() -> None:
    logged, fresh = np.full((2, 20), 5.0), np.full((2, 20), 4.0)
    result = compare([TaskReturns([0, 1], [0, 1], logged, fresh)], np.random.default_rng(0))
    assert result == pytest.approx(new_seeds.STATISTICS / (new_seeds.PERMUTATIONS + 1))
    assert not new_seeds.agrees(result)
