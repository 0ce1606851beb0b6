"""Boards of Continual World and MEAL from their own logs: imported, never verified or ranked."""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from gym_extensions.errors import BenchError, require_known
from gym_extensions.metrics import compute
from gym_extensions.metrics.formulas import METRICS
from gym_extensions.scoring.output.board_frames import ENDS, typed

Array = NDArray[np.float64]
IMPORTED = "imported"
NOT_VERIFIED = "Imported from the logs of another benchmark, not verified."


@dataclass(frozen=True, eq=False)
class ForeignRuns:
    """The runs of one method in another benchmark's logs.

    Attributes:
        name: the method.
        tasks: names of the T tasks, in training order.
        matrix: (runs, T, T), what :func:`gym_extensions.metrics.compute` takes: row s, column j is the
            performance on task j + 1 after training on s + 1 tasks. Neither benchmark logs untrained agents.
        single: (runs, T) final performance of agents trained on one task, as a mean over these; or None.
        auc: (runs, T) mean performance on a task while it is trained; or None.
        single_auc: (runs, T) the same of agents trained on one task, as a mean over these; or None.
    """

    name: str
    tasks: tuple[str, ...]
    matrix: Array
    single: Array | None = None
    auc: Array | None = None
    single_auc: Array | None = None


def foreign_runs(folder: str | Path, benchmark: str) -> list[ForeignRuns]:
    """The runs in another benchmark's logs, one value per method, sorted by its name.

    ``continual-world``: every folder below with ``progress.tsv`` and ``config.json`` is a run. The value of a
    stage is the mean stochastic success rate of its last five evaluations, as in that benchmark's own tables.
    Runs on a single task give ``single`` and ``single_auc``; runs on all tasks at once are left out.

    ``meal``: every folder ``seed_…`` below with ``0_soup.json``, ``1_soup.json``, … (or another metric, or
    npz), as that benchmark's download script writes them, is a run. The value of a stage is its last
    evaluation. The method's name is the path to its seeds.

    Args:
        folder: the folder with the logs. All methods in it have the same tasks.
        benchmark: ``continual-world`` or ``meal``.

    Raises:
        BenchError: there is no run, a file cannot be read, a task or stage is missing or has a value that is
            not finite, or methods have different tasks (``bad-foreign-log``).
    """
    require_known("benchmark", benchmark, READERS, "benchmark")
    root = Path(folder)
    found = sorted(READERS[benchmark](root), key=lambda runs: runs.name)
    if not found:
        raise _bad(root, f"No run of {benchmark} is below this folder.", "Name the folder of the logs.")
    for runs in found[1:]:
        if runs.tasks != found[0].tasks:
            message = f"{found[0].name} and {runs.name} have different tasks."
            raise _bad(root, message, "Name a folder with the runs of one sequence.")
    return found


def foreign_board(folder: str | Path, benchmark: str) -> pd.DataFrame:
    """A board of another benchmark, computed from its logs: one row per method. None has a rank.

    ================  =======  =====================================================================
    column            dtype    value
    ================  =======  =====================================================================
    name              str      the method
    level             str      ``imported``: nobody has verified the logs
    runs              int64    number of runs
    ranked            bool     False
    why               str      why the submission is not ranked
    ``METRIC``        float64  mean over runs, in the unit of the logs; may be missing
    ``METRIC_low``    float64  lower end of its 95 % interval; missing with one run or without a mean
    ``METRIC_high``   float64  upper end of its 95 % interval; missing with one run or without a mean
    ================  =======  =====================================================================

    The rows are sorted by final performance, best first. The arguments and errors are those of
    :func:`foreign_runs`.
    """
    names = [metric.name for metric in METRICS["sequential"]]
    dtypes = {"name": "str", "level": "str", "runs": "int64", "ranked": "bool", "why": "str"}
    dtypes |= dict.fromkeys([f"{name}{end}" for name in names for end in ENDS], "float64")
    rows = []
    for runs in foreign_runs(folder, benchmark):
        found = compute(runs.matrix, runs.single, auc=runs.auc, single_auc=runs.single_auc)
        cells = [end for name in names for end in (found[name].mean, found[name].low, found[name].high)]
        rows.append((runs.name, IMPORTED, len(runs.matrix), False, NOT_VERIFIED, *cells))
    return typed(rows, dtypes).sort_values(names[0], ascending=False, kind="stable", ignore_index=True)


def _bad(path: Path, message: str, hint: str) -> BenchError:
    return BenchError("bad-foreign-log", message, str(path), hint)


LAST_EVALUATIONS = 5
"""Of a stage, whose mean Continual World's own tables take."""
SUCCESS = re.compile(r"test/stochastic/(\d+)/(.+)/success")


def _continual_world(root: Path) -> Iterator[ForeignRuns]:
    keep = "Keep what Continual World writes."
    methods: dict[str, list[tuple[tuple[str, ...], Array, Array]]] = {}
    alone: dict[str, list[tuple[float, float]]] = {}
    for path in sorted(root.rglob("progress.tsv")):
        config = _read(path.with_name("config.json"), lambda file: dict(json.loads(file.read_bytes())), keep)
        log = _read(path, lambda file: pd.read_csv(file, sep="\t"), keep)
        columns = {int(found[1]): found for name in log if (found := SUCCESS.fullmatch(str(name)))}
        tasks = tuple(columns[index][2] for index in sorted(columns))
        if not tasks or sorted(columns) != list(range(len(tasks))):
            missing = next(index for index in range(len(columns) + 1) if index not in columns)
            raise _bad(path, f"It has no success rate of task {missing}.", "Log every task.")
        names = [columns[index][0] for index in range(len(tasks))]
        success = _read(path, lambda _: log[names].to_numpy(dtype=np.float64), keep)  # noqa: B023
        if "task" in config:
            values = _checked(success[:, 0], path)
            means = float(values[-LAST_EVALUATIONS:].mean()), float(values.mean())
            alone.setdefault(str(config["task"]), []).append(means)
        elif "train/active_env" in log:
            trained = log["train/active_env"]
            further = trained[trained.notna() & ~trained.isin(range(len(tasks)))]
            if len(further):
                message = f"It has rows of stage {further.iloc[0]}, and no success rate of its task."
                raise _bad(path, message, "Log every task.")
            stages = [success[trained == stage] for stage in range(len(tasks))]
            for stage, values in enumerate(stages):
                if not len(values):
                    raise _bad(path, f"It has no row of stage {stage}.", "Train on every task.")
                _checked(values, path)
            matrix = np.array([values[-LAST_EVALUATIONS:].mean(axis=0) for values in stages])
            auc = np.array([values[:, stage].mean() for stage, values in enumerate(stages)])
            reservoir = config.get("buffer_type") == "reservoir"
            method = "reservoir" if reservoir else str(config.get("cl_method") or "finetuning")
            methods.setdefault(method, []).append((tasks, matrix, auc))
    for method, runs in methods.items():
        tasks = runs[0][0]
        if any(other != tasks for other, _, _ in runs):
            raise _bad(root, f"The runs of {method} have different tasks.", "Separate their folders.")
        single = single_auc = None
        if all(name in alone for name in tasks):
            columns_alone = np.transpose([np.mean(alone[name], axis=0) for name in tasks])
            single, single_auc = (np.tile(column, (len(runs), 1)) for column in columns_alone)
        matrix, auc = (np.array([run[place] for run in runs]) for place in (1, 2))
        yield ForeignRuns(method, tasks, matrix, single, auc, single_auc)


def _read(path: Path, load: Callable[[Path], Any], hint: str) -> Any:
    try:
        return load(path)
    except (OSError, ValueError, TypeError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise _bad(path, f"The file cannot be read: {error}.", hint) from error


def _checked(values: Array, path: Path) -> Array:
    if not values.size or not np.isfinite(values).all():
        raise _bad(path, "A value is missing or not finite.", "Leave out runs that stopped early.")
    return values


CURVE = re.compile(r"(\d+)_(soup|success|coverage_fraction|win_rate|return)\.(json|npz)")


def _meal(root: Path) -> Iterator[ForeignRuns]:
    methods: dict[Path, list[Array]] = {}
    metrics: set[str] = set()
    for folder in sorted(path for path in root.rglob("seed_*") if path.is_dir()):
        matches = [match for path in sorted(folder.iterdir()) if (match := CURVE.fullmatch(path.name))]
        if not matches:
            continue
        found = {int(match[1]): match for match in matches}
        metrics |= {match[2] for match in matches}
        missing = next((index for index in range(max(found)) if index not in found), None)
        if missing is not None:
            raise _bad(folder, f"It has no curve of task {missing}.", "Download every task.")
        curves = [_curve(folder / found[index][0]) for index in range(len(found))]
        lengths = {len(curve) for curve in curves}
        if len(lengths) > 1 or len(curves[0]) % len(curves):
            message = f"Its {len(curves)} curves have {sorted(lengths)} evaluations."
            raise _bad(folder, message, "Give curves of equal length, a multiple of the number of tasks.")
        stage = len(curves[0]) // len(curves)
        methods.setdefault(folder.parent, []).append(np.array(curves).T[stage - 1 :: stage])
    if len(metrics) > 1:
        message = f"The curves are of {', '.join(sorted(metrics))}."
        raise _bad(root, message, "Name a folder with one of them.")
    for folder, runs in methods.items():
        name = root.resolve().name if folder == root else folder.relative_to(root).as_posix()
        if len({run.shape for run in runs}) > 1:
            raise _bad(folder, "Its seeds have different numbers of tasks.", "Separate their folders.")
        tasks = tuple(str(index) for index in range(len(runs[0])))
        yield ForeignRuns(name, tasks, np.array(runs))


def _curve(path: Path) -> Array:
    def load(path: Path) -> Array:
        if path.suffix == ".json":
            return np.array(json.loads(path.read_bytes()), dtype=np.float64)
        with np.load(path, allow_pickle=False) as file:
            return np.array(file["data"], dtype=np.float64)

    curve = _checked(_read(path, load, "Keep what MEAL's download writes."), path)
    if curve.ndim != 1:
        raise _bad(path, "The curve is not a list of numbers.", "Keep what MEAL's download writes.")
    return curve


READERS: dict[str, Callable[[Path], Iterator[ForeignRuns]]] = {
    "continual-world": _continual_world,
    "meal": _meal,
}
"""What reads the logs of a benchmark."""
