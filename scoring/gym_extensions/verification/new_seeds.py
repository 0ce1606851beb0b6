"""New seeds, and whether logged returns are higher than the returns on them, by a permutation test.

Under the null hypothesis the logged and the new seeds of a task are exchangeable: both are drawn from the
same distribution, and the policies were fixed before the new ones. All runs, stages and protocols of a task
are evaluated on the same seeds, and tasks may be much harder from some of them, so that returns of one seed
are not independent. The test therefore exchanges seeds and not returns, which makes it exact for any
dependence between runs: it rejects an honest submission with a probability of at most ``NEW_SEEDS_ALPHA``. An
agent may draw the same noise in all tasks, so that episodes of one number are not independent either: the
same numbers are exchanged in all tasks. The new episodes do not share noise between tasks; the numbers of
both kinds are equal, so the test is then exact in the limit of many episodes.
"""

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.protocol import EVALUATION_EPISODES, seed_from
from gym_extensions.errors import BenchError
from gym_extensions.submissions.review import NEW_SEEDS_ALPHA

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

VALUE = re.compile(r"[0-9a-f]{40,128}")
PERMUTATIONS = 4999
ROUNDING = 1e-9
"""Statistics that differ by less are equal."""


class CellReturns(NamedTuple):
    """The returns of cells: logged (cells, prescribed seeds), and new (cells, new seeds).

    ``runs`` (cells,) has the run of each cell, as an index over all runs of all logs of the submission,
    ``stages`` (cells,) its stage.
    """

    runs: Integers
    stages: Integers
    logged: Array
    new: Array


def agrees(p_value: float) -> bool:
    """Whether the logged returns are not significantly higher than those on new seeds."""
    return p_value > NEW_SEEDS_ALPHA


@dataclass(frozen=True)
class Draw:
    """New seeds, which nobody knew when the files were submitted: they follow from both.

    ``digest`` is that of the logs and policies (:func:`files_digest`). ``value`` are 40 to 128 hexadecimal
    digits that were fixed after them, such as the merge commit's id. A second draw has the ``number`` 2.
    """

    digest: str
    value: str
    number: int = 1

    def seed(self, *names: object) -> int:
        """A seed for what the names say, which follows from ``<digest>/<value>/<number>/<name>/…``."""
        return seed_from(self.digest, self.value, self.number, *names)

    def seeds(self, group_id: str, task_id: str) -> list[int]:
        """The reset seeds of a task's new episodes: the same for all runs, stages and protocols."""
        return [self.seed(group_id, task_id, episode) for episode in range(EVALUATION_EPISODES)]


def require_value(value: str, option: str) -> str:
    """The value in lower case. Raises ``BenchError``, which names the option, unless it has 40 to 128
    hexadecimal digits."""
    if not VALUE.fullmatch(value.lower()):
        hint = "Pass 40 to 128 digits that nobody can choose, such as the randomness of a public beacon."
        raise BenchError("bad-seeds", f"{value[:80]!r} is not such a number.", option, hint)
    return value.lower()


def files_digest(runs: Mapping[str, str]) -> str:
    """The SHA-256 of one line per run, sorted: its name, a space, its digest."""
    return hashlib.sha256("".join(f"{name} {runs[name]}\n" for name in sorted(runs)).encode()).hexdigest()


def compare(cells: CellReturns, rng: np.random.Generator) -> float:
    """The one-sided p value of the logged returns of all cells against the new ones.

    A cell's difference is the difference of its two means over the standard deviation of its returns. The
    statistics are the sum over all cells, the largest sum over the cells of a run and that over those of a
    stage, divided by the square root of their number, and the largest of a cell. The p value is the smallest
    of the four times four (Bonferroni).
    """
    logged, new = cells.logged.shape[1], cells.new.shape[1]
    data = np.concatenate([np.full(logged, 1 / logged), np.full(new, -1 / new)])
    exchanged = rng.permuted(np.tile(data, (PERMUTATIONS, 1)), axis=1)
    weights = np.concatenate([data[None], exchanged])  # (1 + permutations, episodes): the first is the data
    returns = np.concatenate([cells.logged, cells.new], axis=1)
    deviation = returns.std(axis=1, keepdims=True)
    is_constant = deviation <= ROUNDING * np.maximum(1.0, np.abs(returns).max(axis=1, keepdims=True))
    standardized = np.where(is_constant, 0.0, returns / np.where(is_constant, 1.0, deviation))
    differences = standardized @ weights.T  # (cells, 1 + permutations)
    statistics = [differences.sum(axis=0), differences.max(axis=0)]
    for labels in (cells.runs, cells.stages):
        parts = (differences[labels == label] for label in np.unique(labels))
        statistics.append(np.max([part.sum(axis=0) / np.sqrt(len(part)) for part in parts], axis=0))
    p_values = [float((values >= values[0] - ROUNDING).mean()) for values in statistics]
    return min(1.0, len(p_values) * min(p_values))
