"""Measures the coverage of the intervals in docs/metrics.md and prints its two tables in Markdown.

    python -m tools.benchmarks.measure_coverage [--datasets 4000] [--boards 1000]

Coverage: how often a 95 % interval over N runs contains the true mean, for ten shapes of variation between
runs. Student's t is compared with the percentile, BCa and bootstrap-t intervals, whose resamples are
enumerated, not drawn. Family-wise error: how often any rank interval of a board misses a submission's true
rank.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement, product
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from gym_extensions.metrics.statistics import critical_value, rank_intervals, significant_pairs, summary
from tools import argument_parser

Array = NDArray[np.float64]
NORMAL = NormalDist()
ALPHA = 0.05
TASK_NOISE = 0.2
"""Standard deviation between runs of a task, learned or not."""
LARGE = 200_000
"""Number of data sets for Student's t, which needs no resampling."""
BOOTSTRAPS = ("percentile", "BCa", "bootstrap-t")
CELLS = 4_000_000
"""Number of resampled means in memory at a time."""


@dataclass(frozen=True)
class Shape:
    """A distribution of a metric over runs: name, true mean and sampler."""

    name: str
    mean: float
    draw: Callable[[np.random.Generator, tuple[int, ...]], Array]


def _tasks(rng: np.random.Generator, size: tuple[int, ...]) -> Array:
    learned = rng.random((*size, 5)) < 0.7
    return (learned + rng.normal(0, TASK_NOISE, (*size, 5))).mean(axis=-1)


def _modes(share: float, width: float) -> Callable[[np.random.Generator, tuple[int, ...]], Array]:
    def draw(rng: np.random.Generator, size: tuple[int, ...]) -> Array:
        return (rng.random(size) < share) + rng.normal(0, width, size)

    return draw


SHAPES = (
    Shape("normal", 0.0, lambda rng, size: rng.normal(0, 1, size)),
    Shape("five tasks, each learned with probability .7", 0.7, _tasks),
    Shape("lognormal, mild (σ .5)", math.exp(0.125), lambda rng, size: rng.lognormal(0, 0.5, size)),
    Shape("lognormal, heavy (σ 1)", math.exp(0.5), lambda rng, size: rng.lognormal(0, 1, size)),
    Shape("exponential", 1.0, lambda rng, size: rng.exponential(1, size)),
    Shape("Student's t, 3 degrees of freedom", 0.0, lambda rng, size: rng.standard_t(3, size)),
    Shape("a fifth of the runs collapsed", 0.8, _modes(0.8, 0.2)),
    Shape("two narrow modes, 50/50", 0.5, _modes(0.5, 0.02)),
    Shape("two narrow modes, 80/20", 0.8, _modes(0.8, 0.02)),
    Shape("two narrow modes, 90/10", 0.9, _modes(0.9, 0.02)),
)


def multisets(runs: int) -> tuple[Array, Array]:
    """Every resample of N runs as counts [multiset, run], and its probability."""
    resamples = combinations_with_replacement(range(runs), runs)
    counts = np.array([np.bincount(resample, minlength=runs) for resample in resamples])
    ways = np.array([math.factorial(runs) / math.prod(map(math.factorial, row)) for row in counts])
    return counts.astype(np.float64), ways / runs**runs


def student(data: Array) -> tuple[Array, Array]:
    """Lower and upper ends of Student's t intervals, one per row of ``data``."""
    runs = data.shape[1]
    center = data.mean(axis=1)
    half_width = critical_value(0.05, runs - 1) * data.std(axis=1, ddof=1) / math.sqrt(runs)
    return center - half_width, center + half_width


def _ranked(values: Array, weights: Array) -> tuple[Array, Array]:
    """Sorted values and their cumulative weights, row by row; infinite values have weight 0."""
    order = np.argsort(values, axis=1)
    ranked = np.take_along_axis(values, order, axis=1)
    return ranked, np.cumsum(weights[order] * np.isfinite(ranked), axis=1)


def _at(ranked: tuple[Array, Array], share: Array | float) -> Array:
    """The weighted quantile of each row: the smallest value whose cumulative weight reaches the share."""
    values, cumulative = ranked
    shares = np.broadcast_to(share, len(values))
    reached = cumulative >= shares[:, None] * cumulative[:, -1:] - 1e-12
    return np.take_along_axis(values, reached.argmax(axis=1)[:, None], axis=1)[:, 0]


def bootstraps(data: Array, counts: Array, weights: Array) -> dict[str, tuple[Array, Array]]:
    """Lower and upper ends of the percentile, BCa and bootstrap-t intervals, over all resamples."""
    runs = data.shape[1]
    center, error = data.mean(axis=1), data.std(axis=1, ddof=1) / math.sqrt(runs)
    means = data @ counts.T / runs
    ranked, ends = _ranked(means, weights), (ALPHA / 2, 1 - ALPHA / 2)
    low, high = (_at(ranked, end) for end in ends)

    below = (means < center[:, None] - 1e-12) @ weights
    equal = (np.abs(means - center[:, None]) <= 1e-12) @ weights
    z0 = np.array([NORMAL.inv_cdf(min(max(share, 1e-6), 1 - 1e-6)) for share in below + equal / 2])
    left_out = (data.sum(axis=1, keepdims=True) - data) / (runs - 1)
    pull = left_out.mean(axis=1, keepdims=True) - left_out
    scale = 6 * np.maximum((pull**2).sum(axis=1), 1e-300) ** 1.5
    bend = (pull**3).sum(axis=1) / scale
    adjusted = []
    for end in ends:
        z = z0 + NORMAL.inv_cdf(end)
        shifted = z0 + z / (1 - bend * z)
        adjusted.append(_at(ranked, np.array([NORMAL.cdf(value) for value in shifted])))

    squares = (data**2) @ counts.T / runs
    spread = np.sqrt(np.maximum(squares - means**2, 0) * runs / (runs - 1) / runs)
    alike = spread < 1e-9 * np.maximum(error, 1e-300)[:, None]
    t = np.where(alike, np.inf, (means - center[:, None]) / np.where(alike, 1, spread))
    ranked_t = _ranked(t, weights)
    t_low, t_high = (_at(ranked_t, end) for end in ends)
    return {
        "percentile": (low, high),
        "BCa": (adjusted[0], adjusted[1]),
        "bootstrap-t": (center - t_high * error, center - t_low * error),
    }


def _covered(ends: tuple[Array, Array], mean: float) -> int:
    return int(((ends[0] <= mean) & (mean <= ends[1])).sum())


def coverage(shape: Shape, runs: int, datasets: int, rng: np.random.Generator) -> dict[str, float]:
    """The fraction of intervals that contain the true mean, by method."""
    shares = {"t": _covered(student(shape.draw(rng, (LARGE, runs))), shape.mean) / LARGE}
    if runs > 10:
        return shares
    counts, weights = multisets(runs)
    covered = dict.fromkeys(BOOTSTRAPS, 0)
    chunk = max(1, CELLS // len(weights))
    for start in range(0, datasets, chunk):
        data = shape.draw(rng, (min(chunk, datasets - start), runs))
        for method, ends in bootstraps(data, counts, weights).items():
            covered[method] += _covered(ends, shape.mean)
    return shares | {method: count / datasets for method, count in covered.items()}


def family_wise(
    submissions: int, gap: float, runs: int, boards: int, rng: np.random.Generator
) -> tuple[float, float]:
    """How often any rank interval of a board misses a true rank, and the mean number of ranks in one."""
    truth = np.arange(submissions) * -gap
    true = [(1, submissions) if gap == 0 else (rank, rank) for rank in range(1, submissions + 1)]
    missed, width = 0, 0
    for _ in range(boards):
        board = [summary(row) for row in (truth[:, None] + rng.normal(0, 1, (submissions, runs))).tolist()]
        ranks = rank_intervals(board, significant_pairs(board), "higher")
        pairs = zip(ranks, true, strict=True)
        missed += any(low > first or high < last for (low, high), (first, last) in pairs)
        width += sum(high - low + 1 for low, high in ranks)
    return missed / boards, width / boards / submissions


def _error(share: float, count: int) -> float:
    return math.sqrt(share * (1 - share) / count)


def main() -> None:
    """Print both tables."""
    parser = argument_parser("tools.benchmarks.measure_coverage", __doc__)
    at_most = "number of data sets at N = 3 and 5; a twentieth of it at 10"
    parser.add_argument("--datasets", type=int, default=4000, help=at_most)
    parser.add_argument("--boards", type=int, default=1000, help="number of boards per family-wise error")
    options = parser.parse_args()
    generators = map(np.random.default_rng, np.random.SeedSequence(0).spawn(len(SHAPES) * 4 + 12))

    print("| shape | N | t | percentile | BCa | bootstrap-t |\n| --- | --- | --- | --- | --- | --- |")
    for shape, runs in product(SHAPES, (3, 5, 10, 20)):
        # ten runs have 92,378 resamples
        datasets = max(1, options.datasets // 20) if runs == 10 else options.datasets
        shares = coverage(shape, runs, datasets, next(generators))
        cells = [f"{100 * shares['t']:.1f}"]
        for method in BOOTSTRAPS:
            if method in shares:
                error = _error(shares[method], datasets)
                cells.append(f"{100 * shares[method]:.1f} ± {100 * error:.1f}")
            else:
                cells.append("–")
        print(f"| {shape.name} | {runs} | {' | '.join(cells)} |", flush=True)

    print("\n| truth | submissions | runs | family-wise error | mean width of a rank interval |")
    print("| --- | --- | --- | --- | --- |")
    truths = {"all tied": 0.0, "one run standard deviation apart": 1.0}
    for truth, submissions, runs in product(truths, (5, 10, 20), (5, 10)):
        wrong, width = family_wise(submissions, truths[truth], runs, options.boards, next(generators))
        error = _error(max(wrong, 1 / options.boards), options.boards)
        cell = f"{100 * wrong:.1f} ± {100 * error:.1f}"
        print(f"| {truth} | {submissions} | {runs} | {cell} | {width:.1f} |", flush=True)


if __name__ == "__main__":
    main()
