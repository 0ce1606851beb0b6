"""The test of logged against new returns: honest submissions pass, selected episodes do not."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from gym_extensions.submissions.review import NEW_SEEDS_ALPHA
from gym_extensions.verification import new_seeds
from gym_extensions.verification.new_seeds import CellReturns, compare

Array = NDArray[np.float64]
Draw = Callable[[np.random.Generator, tuple[int, ...]], Array]

RUNS, STAGES = np.divmod(np.arange(10), 2)
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


def p_value(logged: Draw, seed: int, new: Draw = honest, tasks: int = 5) -> float:
    rng = np.random.default_rng(seed)
    shape = (len(RUNS), 20)
    returns = [(logged(rng, shape), new(rng, shape)) for _ in range(tasks)]
    cells = (np.concatenate(parts) for parts in zip(*returns, strict=True))
    return compare(CellReturns(np.tile(RUNS, tasks), np.tile(STAGES, tasks), *cells), rng)


def test_honest_submissions_pass() -> None:
    p_values = [p_value(honest, seed) for seed in range(20)]
    assert min(p_values) > NEW_SEEDS_ALPHA
    assert np.median(p_values) > 0.3


@pytest.mark.parametrize("attack", [best_of_two, best_cell_of_five])
def test_selected_episodes_and_cells_are_refused(attack: Draw) -> None:
    assert max(p_value(attack, seed) for seed in range(5)) <= NEW_SEEDS_ALPHA


def test_lower_logged_returns_pass() -> None:
    assert p_value(honest, 0, new=best_of_two) == 1.0


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

    p_values = [p_value(shared, seed, new=shared, tasks=2) for seed in range(40)]
    assert sum(p <= NEW_SEEDS_ALPHA for p in p_values) <= 1
    assert sum(p <= 0.1 for p in p_values) <= 10


def test_noise_that_an_agent_draws_in_all_tasks_is_no_evidence() -> None:
    """The episodes of one number are lucky in all tasks of a run; new episodes have noise of their own."""

    def submission(seed: int) -> float:
        rng = np.random.default_rng(seed)
        noise, shape = np.tile(rng.standard_normal((5, 20)), (5, 1)), (25, 20)
        logged, new = noise + 0.5 * rng.standard_normal(shape), rng.standard_normal(shape)
        return compare(CellReturns(np.tile(np.arange(5), 5), np.zeros(25, np.int64), logged, new), rng)

    p_values = [submission(seed) for seed in range(40)]
    assert sum(p <= NEW_SEEDS_ALPHA for p in p_values) <= 1
    assert sum(p <= 0.1 for p in p_values) <= 10


def test_constant_returns_pass() -> None:
    constant, labels = np.full((2, 20), -100.0), np.arange(2)
    assert compare(CellReturns(labels, labels, constant, constant), np.random.default_rng(0)) == 1.0


def test_invented_returns_of_a_constant_policy_are_refused() -> None:
    logged, new, labels = np.full((2, 20), 5.0), np.full((2, 20), 4.0), np.arange(2)
    result = compare(CellReturns(labels, labels, logged, new), np.random.default_rng(0))
    assert result == pytest.approx(4 / (new_seeds.PERMUTATIONS + 1))
    assert not new_seeds.agrees(result)
