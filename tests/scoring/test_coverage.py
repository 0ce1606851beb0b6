"""The script behind the tables of docs/metrics.md: exact enumeration, and Student's t covers what it must."""

from __future__ import annotations

import importlib.util
import sys
from itertools import product
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

SCRIPT = Path(__file__).parents[2] / "scoring" / "measure_coverage.py"


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("measure_coverage", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["measure_coverage"] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("runs", "count"), [(3, 10), (5, 126)])
def test_all_resamples_are_enumerated(script: ModuleType, runs: int, count: int) -> None:
    counts, weights = script.multisets(runs)
    assert counts.shape == (count, runs)
    assert (counts.sum(axis=1) == runs).all()
    assert weights.sum() == pytest.approx(1)


def test_the_percentile_interval_is_that_of_all_27_resamples(script: ModuleType) -> None:
    values = [1.0, 2.0, 4.0]
    means = sorted(sum(chosen) / 3 for chosen in product(values, repeat=3))
    low, high = script.bootstraps(np.array([values]), *script.multisets(3))["percentile"]
    # The first of 27 weighs 1/27 > .025, and 26/27 < .975.
    assert (low[0], high[0]) == (pytest.approx(means[0]), pytest.approx(means[-1]))


@pytest.mark.parametrize("runs", [3, 5, 10, 20])
@pytest.mark.parametrize("shape", [0, 1], ids=["normal", "tasks that fail independently"])
def test_students_t_covers_94_to_96_per_cent(script: ModuleType, shape: int, runs: int) -> None:
    drawn = script.SHAPES[shape]
    low, high = script.student(drawn.draw(np.random.default_rng(1), (60_000, runs)))
    assert 0.94 <= np.mean((low <= drawn.mean) & (drawn.mean <= high)) <= 0.96


@pytest.mark.parametrize("gap", [0.0, 1.0])
def test_rank_intervals_hold_at_once_with_95_per_cent(script: ModuleType, gap: float) -> None:
    missed, width = script.family_wise(5, gap, 5, 200, np.random.default_rng(3))
    assert missed <= 0.05 + 3 * (0.05 * 0.95 / 200) ** 0.5
    assert 1 <= width <= 5
