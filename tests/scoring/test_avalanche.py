"""Forgetting and transfer against Avalanche, an independent library of continual learning.

Avalanche's own stream plugins are driven through its own order of calls, so that which terms are counted and
how they are averaged is its code: an evaluation of the stream before any training, then for every experience
j = 1..T `before_training_exp` and again an evaluation of the stream. What a plugin emits last is compared.

===================== ====================================== =====================================
Avalanche             at the end of T experiences            here
===================== ====================================== =====================================
StreamForgetting      mean over j < T of p[j][j] − p[T][j]   forgetting
StreamBWT             its negative, term by term             minus forgetting
StreamForwardTransfer mean over j ≥ 2 of p[j−1][j] − p[0][j] zero-shot transfer
functional.forgetting all p[j][j] − p[s][j], s > j           terms of mean later forgetting
===================== ====================================== =====================================

A mean of no terms is 0.0 there and None here. Avalanche has no open tasks: one is trained on there and
not evaluated. Worst-case forgetting has no counterpart: Avalanche keeps the first value.
"""

import random
import sys
from collections.abc import Iterator, Sequence
from importlib import import_module, metadata
from pathlib import Path
from statistics import fmean
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gym_extensions.metrics.formulas import NormalizedRun
from gym_extensions.metrics.statistics import Number, mean

from ..metrics.test_formulas import function

torch = pytest.importorskip("torch")

EXACT = 1e-12


Cells = dict[tuple[int, int], list[float]]
"""The normalized returns of the episodes on task j after stage s."""


@pytest.fixture(scope="module")
def avalanche() -> Iterator[SimpleNamespace]:
    """Avalanche's metric classes, from its installed modules.

    `import avalanche` loads all of it, and with it torchvision, whose wheel asks for a CUDA build of torch.
    Two packages are therefore entered without running their ``__init__``: the root and the one that lists all
    metrics. Every module below them that is loaded is Avalanche's own; all are forgotten afterwards.
    """
    try:
        root = Path(str(metadata.distribution("avalanche-lib").locate_file("avalanche")))
    except metadata.PackageNotFoundError:
        pytest.skip("avalanche-lib is not installed")

    def package(*names: str) -> ModuleType:
        found = ModuleType(".".join(("avalanche", *names)))
        found.__path__ = [str(root.joinpath(*names))]
        sys.modules[found.__name__] = found
        return found

    before = set(sys.modules)
    try:
        package()
        metrics: Any = package("evaluation", "metrics")
        accuracy = import_module("avalanche.evaluation.metrics.accuracy")
        metrics.TaskAwareAccuracy = accuracy.TaskAwareAccuracy
        metrics.Mean = import_module("avalanche.evaluation.metrics.mean").Mean
        backward = import_module("avalanche.evaluation.metrics.forgetting_bwt")
        forward = import_module("avalanche.evaluation.metrics.forward_transfer")
        yield SimpleNamespace(
            Mean=metrics.Mean,
            StreamForgetting=backward.StreamForgetting,
            StreamBWT=backward.StreamBWT,
            StreamForwardTransfer=forward.StreamForwardTransfer,
            forgetting=import_module("avalanche.evaluation.functional").forgetting,
        )
    finally:
        for name in set(sys.modules) - before:
            if name.split(".")[0] == "avalanche":
                del sys.modules[name]


def of_returns(library: SimpleNamespace, plugin: str) -> Any:
    """The plugin on returns for accuracies: the two methods that its base class asks a subclass to give."""
    members = {
        "metric_update": lambda self, strategy: self._current_metric.update(strategy.mb_output.item()),
        "metric_result": lambda self, strategy: self._current_metric.result(),
    }
    made = type(f"{plugin}OfReturns", (getattr(library, plugin),), members)()
    made._current_metric = library.Mean()
    return made


def emitted(plugin: Any, T: int, scored: Sequence[int], cells: Cells) -> float:
    """What the plugin emits after the last evaluation: an episode is a minibatch, a return of 1 a success."""

    def experience(j: int) -> SimpleNamespace:
        return SimpleNamespace(current_experience=j - 1, origin_stream=SimpleNamespace(name="test"))

    strategy = SimpleNamespace(is_eval=True, eval_every=0, clock=SimpleNamespace(train_iterations=0))
    strategy.experience = experience(1)
    strategy.mb_y = torch.ones(1, dtype=torch.float64)
    values: list[Any] = []
    for stage in range(T + 1):
        if stage:
            strategy.experience = experience(stage)
            plugin.before_training_exp(strategy)
        plugin.before_eval(strategy)
        for j in scored:
            strategy.experience = experience(j)
            plugin.before_eval_exp(strategy)
            for value in cells[stage, j]:
                strategy.mb_output = torch.tensor([value], dtype=torch.float64)
                plugin.after_eval_iteration(strategy)
            plugin.after_eval_exp(strategy)
        values = plugin.after_eval(strategy)
    [last] = values
    return float(last.value)


def run_of(T: int, scored: Sequence[int], cells: Cells) -> NormalizedRun:
    return NormalizedRun(T, tuple(scored), {place: fmean(values) for place, values in cells.items()})


def same(ours: Number, theirs: float) -> None:
    """Equal, or no term: None here and 0.0 there."""
    if ours is None:
        assert theirs == 0.0
    else:
        assert theirs == pytest.approx(ours, abs=EXACT)


def random_runs() -> Iterator[tuple[int, list[int], Cells]]:
    """Forty runs of two to eight tasks; in every other one some tasks are open."""
    rng = random.Random(5)
    for number in range(40):
        T = rng.randint(2, 8)
        scored = [j for j in range(1, T + 1) if number % 2 or rng.random() < 0.7]
        yield T, scored, {(s, j): returns(rng) for s in range(T + 1) for j in scored}


def returns(rng: random.Random) -> list[float]:
    """Returns of a cell: a zero, as often as not; else episodes below the floor and above the expert."""
    return [0.0] if rng.random() < 0.5 else [rng.uniform(-2, 2) for _ in range(3)]


def test_forgetting_and_zero_shot_transfer_of_returns_are_avalanches(avalanche: SimpleNamespace) -> None:
    for T, scored, cells in random_runs():
        run = run_of(T, scored, cells)
        for ours, plugin, sign in (
            (function("forgetting")(run), "StreamForgetting", 1),
            (function("forgetting")(run), "StreamBWT", -1),
            (function("zero_shot_transfer")(run), "StreamForwardTransfer", 1),
        ):
            same(ours, sign * emitted(of_returns(avalanche, plugin), T, scored, cells))


def test_forgetting_at_every_later_stage_is_a_mean_of_avalanches_forgetting_matrix(
    avalanche: SimpleNamespace,
) -> None:
    """Its matrix holds 0 up to the stage that trains j; those are no terms here. The means are plain ones."""
    for T, scored, cells in random_runs():
        matrix = [[mean(cells[s, j]) for j in scored] for s in range(T + 1)]
        drops = avalanche.forgetting(matrix, boundary_indices=list(scored))
        columns = [drops[j + 1 :, place] for place, j in enumerate(scored) if j < T]
        run = run_of(T, scored, cells)
        if not columns:
            assert function("mean_later_forgetting")(run) is None
            continue
        later = float(np.mean([column.mean() for column in columns]))
        assert function("mean_later_forgetting")(run) == pytest.approx(later, abs=EXACT)
        last = float(np.mean([column[-1] for column in columns]))
        assert function("forgetting")(run) == pytest.approx(last, abs=EXACT)
