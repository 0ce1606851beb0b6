"""Simulates the core board: its errors over the looks, its power, and the coverage of its interval.

    python -m tools.benchmarks.measure_looks [errors] [growth] [power] [coverage] [groups]

Boards have methods without any difference, on seven groups. Runs are drawn from a normal distribution
(``normal``), or for every method and group from the runs of a committed submission and group, centred on 0
(``committed``): bimodal ones and unequal variances among them. An error is a separation. An adversary looks
at 5, 10, 20, 40 (and 80) runs and stops at the first error. Numbers are in percent, with standard errors.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr, stdtrit

from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.errors import reports_mistakes, require_known
from gym_extensions.metrics.statistics import ALPHA
from gym_extensions.scoring.pipeline import find_submissions, make_scorer
from gym_extensions.scoring.submission.core_score import LOOK_LEVELS, LOOKS
from tools import ROOT, argument_parser

Array = NDArray[np.float64]
Draw = Callable[[np.random.Generator, int, int, int], Array]
"""Values (boards, methods, groups, runs) of methods without a difference."""
Submissions = dict[str, dict[str, Array]]
"""Final performance of runs, by submission and group."""
Rows = Iterator[tuple[object, ...]]
"""The head of a table, then its rows."""

GROUPS = len(CORES[CORE])
LOOKED = LOOKS[:4]
"""The looks of the adversary."""
SEED = 20261126


def normal(rng: np.random.Generator, boards: int, methods: int, runs: int) -> Array:
    """Runs of equal variance."""
    return rng.standard_normal((boards, methods, GROUPS, runs))


def committed_runs() -> Submissions:
    """The runs of the committed submissions on the groups of the core, of which each has at least five."""
    scorer, found = make_scorer(only=("core",)), {}
    for folder in find_submissions(ROOT / "submissions"):
        card = scorer(folder)
        logs = {name: card.log(name, "sequential") for name in CORES[CORE]}
        runs = {name: log.metrics["final_performance"].runs for name, log in logs.items() if log}
        found[folder.name] = {name: np.array(each) for name, each in runs.items() if len(each) >= LOOKS[0]}
    return {name: groups for name, groups in found.items() if groups}


def from_committed(samples: Sequence[Array]) -> Draw:
    """Draws, for every method and group, from the runs of one of these samples, centred on 0."""
    longest = max(map(len, samples))
    table = np.array([np.resize(each - each.mean(), longest) for each in samples])
    sizes = np.array([len(each) for each in samples])

    def draw(rng: np.random.Generator, boards: int, methods: int, runs: int) -> Array:
        which = rng.integers(len(samples), size=(boards, methods, GROUPS, 1))
        index = (rng.random((boards, methods, GROUPS, runs)) * sizes[which]).astype(np.int64)
        return table[which, index]

    return draw


def draws(submissions: Submissions) -> dict[str, Draw]:
    """Both distributions of runs by name."""
    samples = [runs for groups in submissions.values() for runs in groups.values()]
    return {"normal": normal, "committed": from_committed(samples)}


def p_values(values: Array, runs: int) -> Array:
    """Of Welch's pooled test of all pairs (boards, pairs), over the first runs of each group."""
    part = values[..., :runs]
    means, errors = part.mean(-1), part.var(-1, ddof=1) / runs
    first, second = np.triu_indices(values.shape[1], 1)
    difference = (means[:, first] - means[:, second]).sum(-1)
    squares, terms = errors.sum(-1), (errors * errors).sum(-1) / (runs - 1)
    total = squares[:, first] + squares[:, second]
    df = total * total / (terms[:, first] + terms[:, second])
    return 2 * stdtr(df, -np.abs(difference) / np.sqrt(total))


def simulated(draw: Draw, boards: int, methods: int, looks: Sequence[int], chunk: int = 20_000) -> Array:
    """p values (boards, pairs, looks)."""
    rng = np.random.default_rng(SEED)
    step = max(1, chunk // (methods * methods))
    parts = []
    for start in range(0, boards, step):
        values = draw(rng, min(step, boards - start), methods, looks[-1])
        parts.append(np.stack([p_values(values, look) for look in looks], -1))
    return np.concatenate(parts)


def percent(errors: NDArray[np.bool_] | Array) -> str:
    """A share in percent with its standard error."""
    share = float(errors.mean())
    return f"{100 * share:.2f} ± {100 * float(np.sqrt(share * (1 - share) / errors.size)):.2f}"


def least(found: Array, looks: Sequence[int], levels: Sequence[float]) -> Array:
    """The smallest p value of each board times (pairs / level of its look): an error is at most 1."""
    chosen = [LOOKS.index(look) for look in looks]
    scaled = found[..., chosen].min(1) * found.shape[1] / np.array(levels)
    return scaled.min(-1)


def errors(submissions: Submissions) -> Rows:
    """The family-wise error under an adversary, at one look, and of tests at 5 % at each look."""
    yield (
        "methods",
        "runs",
        "stops, up to 40 runs",
        "stops, up to 80 runs",
        "20 runs",
        "stops at 5 %, up to 40 runs",
    )
    levels = list(LOOK_LEVELS.values())
    for name, draw in draws(submissions).items():
        for methods, boards in ((2, 100_000), (5, 40_000), (10, 20_000), (20, 4_000)):
            found = simulated(draw, boards, methods, LOOKS)
            cases = ((LOOKED, levels[:4]), (LOOKS, levels), ((20,), levels[2:3]), (LOOKED, [ALPHA] * 4))
            yield methods, name, *(percent(least(found, *case) <= 1) for case in cases)


def growth(submissions: Submissions) -> Rows:
    """The error over all versions of a board: submissions join, or an author sends many variants."""
    yield "what happens", "runs", "some version errs, 20 runs", "some version errs, stops, up to 40 runs"
    first, second = np.triu_indices(30, 1)
    levels = np.array(list(LOOK_LEVELS.values()))[:4]
    for name, draw in draws(submissions).items():
        scaled = simulated(draw, 4_000, 30, LOOKED) / levels
        cases = scaled[..., 2], scaled.min(-1)

        def some(editions: Sequence[tuple[NDArray[np.bool_], int]], part: Array) -> str:
            """The share of boards with an error in an edition: the pairs that count, and their number."""
            return percent(np.any([part[:, mask].min(1) <= 1 / pairs for mask, pairs in editions], axis=0))

        joins = [(second < methods, methods * (methods - 1) // 2) for methods in range(2, 16)]
        variants = [
            ((second < methods) & (second >= 10), methods * (methods - 1) // 2) for methods in range(11, 31)
        ]
        alone = [((first < 10) & (second >= 10), 55)]
        yield "a board grows from 2 to 15 submissions", name, *(some(joins, part) for part in cases)
        yield "20 variants join a board of 10, all stay", name, *(some(variants, part) for part in cases)
        yield "20 variants join a board of 10, one at a time", name, *(some(alone, part) for part in cases)


def power(_: Submissions) -> Rows:
    """The power of one pair among 45, with the level of one look and with 5 %, at the same number of runs."""
    yield (
        "runs",
        "difference (deviations of a run)",
        "one look at 5 % (power)",
        "with looks (power)",
        "runs for the same power",
    )
    rng = np.random.default_rng(SEED)
    values = rng.standard_normal((20_000, 2, GROUPS, 40))
    for runs, gap in ((5, 1.07), (10, 0.71), (20, 0.49)):
        shifted = values + np.array([0.0, gap])[None, :, None, None]
        plain = float((p_values(shifted, runs) <= ALPHA / 45).mean())
        limit = LOOK_LEVELS[runs] / 45
        powers = {each: float((p_values(shifted, each) <= limit).mean()) for each in range(runs, 2 * runs)}
        same = next(each for each, share in powers.items() if share >= plain)
        yield runs, gap, f"{100 * plain:.1f}", f"{100 * powers[runs]:.1f}", same


def coverage(submissions: Submissions) -> Rows:
    """How often the 95 % interval of the pooled difference of two committed submissions has the true
    difference.

    The truth is the difference of the submissions' means; runs are drawn from each submission's runs of each
    group, with replacement. The groups are those that both have, at least four.
    """
    yield "runs", "pairs of submissions", "mean (%)", "lowest (%)", "highest (%)"
    names = [name for name, groups in submissions.items() if len(groups) >= 4]
    rng = np.random.default_rng(SEED)
    boards = 4_000
    for runs in (5, 10, 20):
        found = []
        for index, a in enumerate(names):
            for b in names[index + 1 :]:
                shared = [name for name in submissions[a] if name in submissions[b]]
                total, terms, error = np.zeros(boards), np.zeros(boards), np.zeros(boards)
                for name in shared:
                    for sign, sample in ((1, submissions[a][name]), (-1, submissions[b][name])):
                        drawn = rng.choice(sample, (boards, runs))
                        square = drawn.var(1, ddof=1) / runs
                        total += square
                        terms += square * square / (runs - 1)
                        error += sign * (drawn.mean(1) - sample.mean())
                df = total * total / terms
                found.append(float((np.abs(error) <= stdtrit(df, 0.975) * np.sqrt(total)).mean()))
        numbers = (np.mean(found), np.min(found), np.max(found))
        yield runs, len(found), *(f"{100 * float(each):.1f}" for each in numbers)


def single_groups(submissions: Submissions) -> Rows:
    """On one group, how often the 95 % interval of a committed submission has its mean, and how often the
    board of ten methods without a difference separates some of them, at one look.

    Runs are drawn with replacement from those of a submission that has ten or more, centred on 0.
    """
    yield "runs", "interval: mean (%)", "lowest (%)", "error of ranks: mean (%)", "lowest (%)", "highest (%)"
    rng = np.random.default_rng(SEED)
    for runs in (5, 10, 20):
        covered, wrong = [], []
        for name in CORES[CORE]:
            samples = [each[name] for each in submissions.values() if name in each and len(each[name]) >= 10]
            for sample in samples:
                drawn = rng.choice(sample, (4_000, runs))
                half = stdtrit(runs - 1, 0.975) * drawn.std(1, ddof=1) / np.sqrt(runs)
                covered.append((np.abs(drawn.mean(1) - sample.mean()) <= half).mean())
            values = from_committed(samples)(rng, 3_000, 10, runs).swapaxes(1, 2).reshape(-1, 10, 1, runs)
            wrong.append((p_values(values, runs).min(1) <= ALPHA / 45).mean())
        shares = (np.mean(covered), np.min(covered), np.mean(wrong), np.min(wrong), np.max(wrong))
        yield runs, *(f"{100 * float(each):.1f}" for each in shares)


TABLES = {"errors": errors, "growth": growth, "power": power, "coverage": coverage, "groups": single_groups}


@reports_mistakes
def main(argv: Sequence[str] | None = None) -> int:
    """Prints every table, or those that are named, as Markdown."""
    parser = argument_parser("tools.benchmarks.measure_looks", __doc__)
    parser.add_argument("tables", nargs="*", help="default: all")
    chosen = parser.parse_args(argv).tables or list(TABLES)
    for name in chosen:
        require_known("table", name, TABLES)
    submissions = committed_runs()
    for name in chosen:
        head, *body = TABLES[name](submissions)
        lines = ["| " + " | ".join(map(str, row)) + " |" for row in (head, ["---"] * len(head), *body)]
        print(f"<!-- measured: {name} -->", *lines, "<!-- end -->\n", sep="\n", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
