"""Speeds measured side by side: contestants take turns in one run, so noise affects all of them."""

import json
import os
import platform
import statistics
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.files import write_text
from gym_extensions.versions import blas_kernels, processor, version_or_none

Turn = Callable[[], tuple[int, float]]
"""One turn of a contestant: the number of steps, and the seconds they took."""
Compare = Callable[..., dict[str, float]]

FLOOR = 0.8
"""Below this fraction of its bar, a ratio fails its benchmark; noise of the machine explains less."""
ROWS = pytest.StashKey[list[dict[str, Any]]]()
PACKAGES = ("gymnasium", "mujoco", "numpy", "envpool", "stable_baselines3", "torch")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds ``--ratios FILE``: where the ratios of the session are written."""
    parser.addoption(
        "--ratios", type=Path, default=Path(".benchmarks/ratios.json"), help="where ratios are written"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Starts with no ratios."""
    config.stash[ROWS] = []


@pytest.fixture
def side_by_side(benchmark: Any, request: pytest.FixtureRequest) -> Compare:
    """Returns the median ratio of the first contestant's speed to each other one's, by name.

    A ratio below its bar is reported as missed. A ratio below ``FLOOR`` × its bar fails the benchmark.
    """

    def compare(
        measure: str,
        contestants: Mapping[str, Turn],
        *,
        bars: Mapping[str, float],
        rounds: int = 9,
        **about: Any,
    ) -> dict[str, float]:
        speeds: dict[str, list[float]] = {name: [] for name in contestants}

        def take_turns() -> None:
            for turn in contestants.values():  # a warm-up round
                turn()
            for _ in range(rounds):
                for name, turn in contestants.items():
                    steps, seconds = turn()
                    speeds[name].append(steps / seconds)

        benchmark.pedantic(take_turns, rounds=1, iterations=1)
        ours, *others = contestants
        ratios = {
            other: statistics.median(a / b for a, b in zip(speeds[ours], speeds[other], strict=True))
            for other in others
        }
        row = {
            "measure": measure,
            **about,
            "rounds": rounds,
            "per_second": {name: round(statistics.median(values), 1) for name, values in speeds.items()},
            "ratios": {other: round(ratio, 3) for other, ratio in ratios.items()},
            "bars": bars,
        }
        benchmark.extra_info.update(row)  # for --benchmark-json
        request.config.stash[ROWS].append(row)
        regressions = {other: ratios[other] for other, bar in bars.items() if ratios[other] < FLOOR * bar}
        assert not regressions, f"{measure}: {regressions} are below {FLOOR} × the bars {bars}"
        return ratios

    return compare


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Writes the ratios and the machine on which they were measured."""
    rows, path = session.config.stash[ROWS], session.config.getoption("--ratios")
    if rows:
        write_text(path, json.dumps({"format": 1, "machine": machine(), "rows": rows}, indent=1) + "\n")


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Prints one line per ratio, and whether it reaches its bar."""
    for row in config.stash[ROWS]:
        for other, ratio in row["ratios"].items():
            bar = row["bars"].get(other)
            verdict = "" if bar is None else f"  bar {bar}: {'reached' if ratio >= bar else 'MISSED'}"
            terminalreporter.write_line(
                f"{row['measure']:24} {row.get('task', ''):24} / {other:24} {ratio:8.3f}{verdict}"
            )


def machine() -> dict[str, Any]:
    """The machine: processor, cores, kernels of numpy's BLAS, system, versions."""
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "blas": blas_kernels(),
        "system": platform.platform(terse=True),
        "python": platform.python_version(),
        "packages": {name: version for name in PACKAGES if (version := version_or_none(name))},
    }
