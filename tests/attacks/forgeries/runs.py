"""Makes the attacks of the table of the same name in `families`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from gym_extensions.baselines.reproduction.reproduce import reproduce
from gym_extensions.catalog.groups import group
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import policy_name
from gym_extensions.rollouts.policies import Policy

from ..attack import NOT_DETECTED, REEVALUATED, REPRODUCED, Outcome
from ..evaluate import generator, rollouts, seeds_of, with_policy
from ..forger import Forger, Row, cells
from ..judge import Make
from ..recorders import HOPPER, RUNS
from ..workshop import Workshop, put


def as_runs(
    sources: Sequence[int],
    noise: float = 0.0,
    base: str = "random",
    edit: Callable[[Forger], object] = lambda _: None,
) -> Make:
    """Presents runs as the runs 0, 1, ….

    Args:
        sources: the run that each is.
        noise: relative difference that is added to every return, times the new number.
        base: the honest submission.
        edit: changes the result.
    """

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy(base))
        originals = forger.rows()
        rows = []
        contents = {id(row): forger.arrays(row) for row in originals}
        policies = forger.folder / forger.group.name / "policies"
        files = {path.name: path.read_bytes() for path in policies.iterdir()}
        for run, source in enumerate(sources):
            for original in (row for row in originals if int(row["run"]) == source):
                row = original | {"run": str(run)}
                arrays = contents[id(original)]
                factor = 1 + noise * run
                row["return"] = repr(float(row["return"]) * factor)
                forger.bind(row, arrays | {"segment_returns": arrays["segment_returns"] * factor})
                rows.append(row)
            for name, data in files.items():
                if f"-run{source}-" in name:
                    put(policies / name.replace(f"-run{source}-", f"-run{run}-"), data)
        for path in policies.iterdir():
            if not any(f"-run{run}-" in path.name for run in range(len(sources))):
                path.unlink()
        forger.write(rows)
        edit(forger)
        return forger.commit()

    return make


def trainable(forger: Forger) -> None:
    forger.declare("parameters_last", "100")


def another_episode(forger: Forger) -> None:
    """Gives every cell of every run one episode of its own, with actions of its policy."""
    trainable(forger)
    rows = forger.rows()
    for cell in cells(rows):
        run, task = int(cell[0]["run"]), cell[0]["task"]
        name = policy_name("single", run, 1, forger.group.tasks[forger.group.task_ids.index(task)].name)
        policy = Policy.from_bytes((forger.folder / forger.group.name / "policies" / name).read_bytes())
        episodes = rollouts(task, with_policy(policy, generator(cell)), seeds_of(cell))
        forger.put_rollout(cell[run], episodes[run])
    forger.write(rows)


def renumbered(numbers: Sequence[int]) -> Make:
    """Gives the runs other numbers, as they would have if others were left out."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("random"))
        forger.change(lambda row: row.update(run=str(numbers[int(row["run"])])))
        return forger.folder

    return make


def declared(key: str, value: str, base: str = "linear") -> Make:
    """States something else in the manifest."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy(base))
        forger.declare(key, value)
        return forger.commit()

    return make


def with_curve(steps: int, gain: float = 0.0) -> Make:
    """Adds training curves whose last point is at that step."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("linear"))
        lines = ["protocol,run,task,step,return"]
        for protocol in ("sequential", "single"):
            for run in RUNS:
                for task in group(HOPPER).task_ids:
                    height = 100.0 + (gain if protocol == "sequential" else 0.0)
                    points = (
                        f"{protocol},{run},{task},{steps * point // 12},{height}" for point in range(1, 13)
                    )
                    lines += points
        (forger.folder / HOPPER / "curves.csv").write_text("\n".join([*lines, ""]), newline="\n")
        return forger.commit()

    return make


def retrained(edit: Callable[[Forger, list[Row]], object]) -> Callable[[Workshop], Outcome]:
    """Judges a log of a reference agent on a small budget by retraining its first run.

    Small budgets have no boards; the step is the same on others.
    """

    def play(workshop: Workshop) -> Outcome:
        forger = Forger(workshop.copy("trpo"))
        rows = forger.rows()
        edit(forger, rows)
        forger.write(rows)
        forger.commit()
        try:
            comparison = reproduce(forger.folder, HOPPER, "single", 0, progress=False).comparison
        except BenchError as error:
            return Outcome(REEVALUATED, f"retraining: {error.code}")
        return (
            Outcome(REPRODUCED, NOT_DETECTED)
            if comparison.agrees
            else Outcome(REEVALUATED, "retraining: differs")
        )

    return play


def picked(forger: Forger, rows: list[Row]) -> None:
    """Presents as run 0 the run whose mean returns are nearest to those of run 0."""
    runs = [rows[start : start + 40] for start in range(0, len(rows), 40)]

    def distance(run: list[Row]) -> float:
        pairs = zip(cells(runs[0]), cells(run), strict=True)
        return max(abs(_mean_return(first) - _mean_return(other)) for first, other in pairs)

    nearest = min(range(1, len(runs)), key=lambda run: distance(runs[run]))
    for row, other in zip(runs[0], runs[nearest], strict=True):
        arrays = forger.arrays(other)
        row |= {name: other[name] for name in ("length", "return", "terminated")}
        forger.bind(row, arrays)


def _mean_return(cell: Sequence[Row]) -> float:
    return float(np.mean([float(row["return"]) for row in cell]))


def trained_longer(forger: Forger, rows: list[Row]) -> None:
    """Presents the episodes of a policy that stands as those of run 0."""
    policy = Policy(np.zeros(3), np.full(3, 1e-3))
    for cell in cells(rows[:40]):
        act = with_policy(policy, generator(cell))
        for row, rollout in zip(cell, rollouts(cell[0]["task"], act, seeds_of(cell)), strict=True):
            forger.put_rollout(row, rollout)


def other_settings(forger: Forger, rows: list[Row]) -> None:
    path = forger.folder / "submission.toml"
    path.write_text(path.read_text().replace("[observes]", "longer = true\n\n[observes]"), newline="\n")
