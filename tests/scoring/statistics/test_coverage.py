"""The script behind the tables of docs/metrics.md: enumeration of resamples, and coverage of Student's t."""

from __future__ import annotations

import importlib.util
import sys
from itertools import product
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

SCRIPT = Path(__file__).parents[3] / "tests" / "benchmarks" / "measure_coverage.py"


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
    means = sorted(sum(resample) / 3 for resample in product(values, repeat=3))
    low, high = script.bootstraps(np.array([values]), *script.multisets(3))["percentile"]
    # The smallest mean has probability 1/27 > .025, and all but the largest 26/27 < .975.
    assert (low[0], high[0]) == (pytest.approx(means[0]), pytest.approx(means[-1]))


@pytest.mark.parametrize("runs", [3, 5, 10, 20])
@pytest.mark.parametrize("shape", [0, 1], ids=["normal", "tasks fail independently"])
def test_students_t_covers_94_to_96_per_cent(script: ModuleType, shape: int, runs: int) -> None:
    distribution = script.SHAPES[shape]
    low, high = script.student(distribution.draw(np.random.default_rng(1), (60_000, runs)))
    assert 0.94 <= np.mean((low <= distribution.mean) & (distribution.mean <= high)) <= 0.96


@pytest.mark.parametrize("gap", [0.0, 1.0])
def test_rank_intervals_hold_simultaneously_with_95_per_cent(script: ModuleType, gap: float) -> None:
    missed, width = script.family_wise(5, gap, 5, 200, np.random.default_rng(3))
    assert missed <= 0.05 + 3 * (0.05 * 0.95 / 200) ** 0.5
    assert 1 <= width <= 5


def test_one_data_set_and_one_board_suffice_for_both_tables(
    script: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(script, "LARGE", 100)
    monkeypatch.setattr(script, "SHAPES", script.SHAPES[:1])
    script.main(["--datasets", "1", "--boards", "1"])
    rows = [line for line in capsys.readouterr().out.splitlines() if line.startswith("| ")]
    # Two header rows and two separators; one shape at four numbers of runs; twelve boards.
    assert len(rows) == 4 + 4 + 12


# Requested number of data sets, runs, expected number.
DATASETS = [
    (4000, 3, 4000),
    (4000, 5, 4000),
    (4000, 10, 200),
    (20, 10, 1),
    (10, 10, 1),
    (1, 10, 1),
    (1, 5, 1),
]


@pytest.mark.parametrize(("requested", "runs", "expected"), DATASETS)
def test_ten_runs_take_a_twentieth_of_the_data_sets_and_at_least_one(
    script: ModuleType, requested: int, runs: int, expected: int
) -> None:
    assert script.datasets_at(runs, requested) == expected


@pytest.mark.parametrize("option", ["--datasets", "--boards"])
@pytest.mark.parametrize("text", ["0", "-3", "ten"])
def test_a_count_below_one_is_an_error(
    script: ModuleType, option: str, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as error:
        script.main([f"{option}={text}"])
    assert error.value.code == 2
    message = capsys.readouterr().err.splitlines()[-1]
    assert message.endswith(f"argument {option}: expected a whole number of at least 1, got {text!r}")
