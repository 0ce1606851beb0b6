"""Simulates how often new seeds refuse honest submissions and submissions with selected episodes.

    python -m tools.benchmarks.measure_new_seeds [--submissions 400]

A submission has five runs of a group of five tasks, 150 cells (R[s][j] of six stages) of 20 logged and 20
new episodes per draw. A submission that the first draw refuses is evaluated with a second one, which decides.
Returns of a cell are drawn from one of three distributions: normal, lognormal, and falls (a sixth of the
episodes ends early, with a fifth of the return). ``seed`` is the correlation of the returns of one seed
between cells; in the committed logs of ``random`` and ``trpo-2017`` it is at most 0.009. The attacks log the
better of two evaluations of every episode, of all cells or of the last stage alone, or the best of five
evaluations of every cell.
"""

import numpy as np
from numpy.typing import NDArray

from gym_extensions.verification.new_seeds import CellReturns, agrees, compare
from tools import argument_parser

Array = NDArray[np.float64]

TASKS, RUNS, EPISODES, EVALUATIONS = 5, 5, 20, 5
BEST_OF_TWO = ("best of two episodes", "the same, last stage alone")
SPREAD = {"honest": 0.27, **dict.fromkeys(BEST_OF_TWO, 0.27), "best cell of five": 0.31}
"""Standard deviation over mean, such that the attacks raise the mean of normal returns by 15 % and by 8 %."""


def draw(rng: np.random.Generator, kind: str, spread: float, seed: float, cells: int) -> Array:
    """Returns (evaluations, cells, logged episodes and those of two draws)."""
    common = rng.standard_normal((1, 1, 3 * EPISODES))
    single = rng.standard_normal((EVALUATIONS, cells, 3 * EPISODES))
    noise = np.sqrt(seed) * common + np.sqrt(1 - seed) * single
    mean = rng.uniform(100, 3000, (1, cells, 1))
    if kind == "normal":
        return np.asarray(mean * (1 + spread * noise))
    if kind == "lognormal":
        return np.asarray(mean * np.exp(spread * noise))
    return np.asarray(mean * np.where(noise > 1, 0.2, 1.0) * (1 + 0.05 * rng.standard_normal(noise.shape)))


def submission(
    rng: np.random.Generator, attack: str, kind: str, seed: float
) -> tuple[CellReturns, CellReturns]:
    """The returns of a submission with two draws. The log is honest or selected."""
    runs, stages = np.divmod(np.arange(RUNS * (TASKS + 1)), TASKS + 1)
    tasks = []
    for _ in range(TASKS):
        returns = draw(rng, kind, SPREAD[attack], seed, len(runs))
        logged = returns[:, :, :EPISODES]
        selected = logged[0]
        if attack in BEST_OF_TWO:
            changed = (stages == TASKS) | (attack == BEST_OF_TWO[0])
            selected = np.where(changed[:, None], np.maximum(logged[0], logged[1]), logged[0])
        elif attack == "best cell of five":
            best = logged.mean(axis=2).argmax(axis=0)
            selected = logged[best, np.arange(len(runs))]
        tasks.append((selected, *np.split(returns[0, :, EPISODES:], 2, axis=1)))
    logged, *draws = (np.concatenate(parts) for parts in zip(*tasks, strict=True))
    first, second = (CellReturns(np.tile(runs, TASKS), np.tile(stages, TASKS), logged, new) for new in draws)
    return first, second


def refusals(rng: np.random.Generator, attack: str, kind: str, seed: float) -> tuple[bool, bool]:
    """Whether the first draw refuses a submission, and whether both do."""
    first, second = submission(rng, attack, kind, seed)
    if agrees(compare(first, rng)):
        return False, False
    return True, not agrees(compare(second, rng))


def main() -> None:
    """Prints the share of refused submissions."""
    parser = argument_parser("tools.benchmarks.measure_new_seeds", __doc__)
    parser.add_argument("--submissions", type=int, default=400)
    submissions = parser.parse_args().submissions
    rng = np.random.default_rng(20)
    print("| returns | seed | submission | refused by the first draw | by both |\n|---|---:|---|---:|---:|")
    for kind in ("normal", "lognormal", "falls"):
        for seed in (0.0, 0.3):
            for attack in SPREAD:
                refused = [refusals(rng, attack, kind, seed) for _ in range(submissions)]
                first, both = (sum(column) for column in zip(*refused, strict=True))
                print(f"| {kind} | {seed:g} | {attack} | {first} of {submissions} | {both} |", flush=True)


if __name__ == "__main__":
    main()
