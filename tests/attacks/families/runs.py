"""Attacks with picked, copied and renamed runs, and with training that is not what the manifest says."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from gym_extensions.baselines.reproduction.reproduce import reproduce
from gym_extensions.catalog.groups import group
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies import Policy

from ..attack import NOT_DETECTED, REEVALUATED, REPRODUCED, Attack, Outcome
from ..evaluate import evaluations, generator, rollouts, seeds_of, with_policy
from ..forger import Forger, Row, cells
from ..judge import Make, submission
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
    """Gives every run one episode of its own."""
    trainable(forger)
    rows = forger.rows()
    for cell in cells(rows):
        forger.put_rollout(cell[int(cell[0]["run"])], next(evaluations(cell, 1))[0])
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
    """Presents run 2 as run 0."""
    for row, best in zip(rows[:40], rows[80:120], strict=True):
        arrays = forger.arrays(best)
        row |= {name: best[name] for name in ("length", "return", "terminated")}
        forger.bind(row, arrays)


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


PICKED = (
    "Retraining of a run that is chosen after the submission; only reference agents can be retrained so far."
)
ATTACKS = (
    Attack(
        "The best five of 50 runs, with their numbers.",
        submission(renumbered((3, 7, 20, 31, 44))),
        "rules: foreign-policy, foreign-trace, gaps-in-runs, missing-policy",
        quick=True,
    ),
    Attack(
        "Runs with the numbers of the reference agents.",
        submission(renumbered((1000, 1001, 1002, 1003, 1004))),
        "rules: gaps-in-runs, reserved-run",
        quick=True,
    ),
    Attack(
        "Run 0 of TRPO is that of a policy that was trained longer.",
        retrained(trained_longer),
        "retraining: differs",
        REEVALUATED,
        REEVALUATED,
    ),
    Attack(
        "Run 0 of TRPO is another run, whose returns are the same within noise.",
        retrained(picked),
        NOT_DETECTED,
        REPRODUCED,
        REPRODUCED,
        "The same bytes, which only the same processor gives; the gain is within the noise of evaluation.",
    ),
    Attack(
        "The best runs of an agent that is not a reference agent are renumbered.",
        submission(as_runs((3, 1, 4, 0, 2), base="gaussian")),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        PICKED,
    ),
    Attack(
        "TRPO was trained with other settings than the manifest states.",
        retrained(other_settings),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
    ),
    Attack("Four runs.", submission(as_runs((0, 1, 2, 3))), "board: Fewer than 5 runs.", quick=True),
    Attack(
        "One run five times, of an agent with parameters.",
        submission(as_runs((0,) * 5, edit=trainable)),
        "rules: identical-runs",
        quick=True,
    ),
    Attack(
        "One run five times, of an agent that is said to have no parameters.",
        submission(as_runs((0,) * 5)),
        "board: Fewer than 5 runs.",
        quick=True,
    ),
    Attack(
        "One run five times, with differences that replay tolerates.",
        submission(as_runs((0,) * 5, noise=1e-7, edit=trainable)),
        "rules: identical-runs",
        quick=True,
    ),
    Attack(
        "One run five times, with one other episode per cell.",
        submission(as_runs((0,) * 5, base="gaussian", edit=another_episode)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        PICKED + " The scorer notes runs that share most episodes.",
    ),
    Attack(
        "The budget is said to be 1M instead of 100k.",
        submission(declared("budget", '"1M"')),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        PICKED,
    ),
    Attack("A budget that does not exist.", submission(declared("budget", '"2M"')), "rules: bad-value"),
    Attack(
        "The smallest budget, to be alone on a board.",
        submission(declared("budget", '"smoke"')),
        "board: not on a board",
    ),
    Attack("A training curve goes beyond the budget.", submission(with_curve(110_000)), "rules: over-budget"),
    Attack(
        "Training goes on after the budget, and the curve is cut.",
        submission(with_curve(100_000)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        PICKED,
    ),
    Attack(
        "Training curves are invented, which raises the forward transfer.",
        submission(with_curve(100_000, gain=500.0)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        "Retraining. Curves have no traces; the scorer notes returns that are far above a curve.",
    ),
    Attack("Another version of MuJoCo.", submission(declared("mujoco", '"9.9"')), "rules: foreign-version"),
    Attack(
        "Another version of Gymnasium.",
        submission(declared("gymnasium", '"1.3.0"')),
        "rules: foreign-version",
    ),
    Attack(
        "Another version of numpy than the one that was used.",
        submission(declared("numpy", '"9.9"', base="random")),
        NOT_DETECTED,
        REPRODUCED,
        REPRODUCED,
        "Nothing: no step depends on it.",
    ),
    Attack(
        "An agent of the author's own is said to be the reference agent `random`.",
        submission(declared("algorithm", '"random"')),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
    ),
)
