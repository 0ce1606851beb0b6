"""Makes the attacks of the table of the same name in `families`."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from gym_extensions.rollouts.policies import Policy

from ..evaluate import generator, replace_cells, rollouts, seeds_of, with_policy
from ..forger import Forger, Row, cells
from ..judge import Make
from ..recorders import RUNS
from ..workshop import Workshop, put

Source = tuple[str, int]
"""A protocol and a stage."""
OUTCOME = ("length", "return", "terminated", "success")


def keyed(rows: list[Row]) -> dict[tuple[str, ...], Row]:
    """The rows of a log by run, stage, task and episode."""
    return {(row["run"], row["stage"], row["task"], row["episode"]): row for row in rows}


def present(source: Source, target: Source, policies: str) -> Make:
    """Presents the episodes of a stage as those of another.

    Args:
        source: where the episodes are from.
        target: what they are presented as.
        policies: ``none`` leaves all policy files out, ``stated`` leaves them as they are, ``swapped``
            presents those of the source as those of the target too.
    """

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("linear"))
        originals = keyed(forger.rows(source[0]))
        rows = forger.rows(target[0])
        for row in rows:
            original = originals[row["run"], str(source[1]), row["task"], row["episode"]]
            if int(row["stage"]) == target[1]:
                arrays = forger.arrays(original, source[0])
                row |= {name: original[name] for name in OUTCOME}
                forger.bind(row, arrays, target[0])
        forger.write(rows, target[0])
        folder = forger.folder / forger.group.name / "policies"
        if policies == "none":
            shutil.rmtree(folder)
        elif policies == "swapped":
            for path in folder.glob(f"{source[0]}-run*-stage{source[1]}*.npz"):
                name = path.name.replace(f"stage{source[1]}", f"stage{target[1]}")
                put(folder / name, path.read_bytes())
        return forger.commit()

    return make


def worse(protocol: str, stage: int) -> Make:
    """Evaluates a policy that falls at once as that of a stage, from which gains are measured."""
    falls = [Policy(np.full(3, 1 - 0.01 * run), np.ones(3)) for run in RUNS]

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("linear"))
        rows = forger.rows(protocol)
        for cell in cells(rows):
            if int(cell[0]["stage"]) == stage:
                act = with_policy(falls[int(cell[0]["run"])], generator(cell))
                for row, rollout in zip(cell, rollouts(cell[0]["task"], act, seeds_of(cell)), strict=True):
                    forger.put_rollout(row, rollout, protocol)
        forger.write(rows, protocol)
        folder = forger.folder / forger.group.name / "policies"
        for run in RUNS:
            for path in folder.glob(f"{protocol}-run{run}-stage{stage}*"):
                put(path, falls[run].to_bytes())
        return forger.commit()

    return make


def files(edit: Callable[[Forger, Path], object]) -> Make:
    """Changes the folder of policies."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("linear"))
        edit(forger, forger.folder / forger.group.name / "policies")
        return forger.commit()

    return make


def of_another_run(forger: Forger, folder: Path) -> None:
    for path in folder.glob("single-run0-*"):
        put(path, (folder / path.name.replace("run0", "run1")).read_bytes())


def rows_per_task(forger: Forger, folder: Path) -> None:
    """Gives every policy a row of weights per task."""
    for path in folder.iterdir():
        policy = Policy.from_bytes(path.read_bytes())
        weights = (np.stack([policy.weights[0]] * 2),)
        put(path, replace(policy, weights=weights, biases=(np.zeros((2, 3)),)).to_bytes())


def declared_rows(forger: Forger, folder: Path) -> None:
    rows_per_task(forger, folder)
    forger.declare("task_in_evaluation", "true")


def without(pattern: str) -> Callable[[Forger, Path], None]:
    """Removes the policy files whose names match."""

    def edit(forger: Forger, folder: Path) -> None:
        for path in folder.glob(pattern):
            path.unlink()

    return edit


def replaced(policy: Policy) -> Callable[[Forger, Path], None]:
    """Replaces every policy file."""

    def edit(forger: Forger, folder: Path) -> None:
        for path in folder.iterdir():
            put(path, policy.to_bytes())

    return edit


def sampled(policy: Policy) -> Callable[[Forger, Path], None]:
    """Replaces every policy file, and says that actions are sampled."""

    def edit(forger: Forger, folder: Path) -> None:
        replaced(policy)(forger, folder)
        forger.declare("evaluation", '"sampled"')

    return edit


def hand_written(workshop: Workshop) -> Path:
    """Packs a constant action, which nobody trained, as the policy of all runs of ``linear``."""
    forger = Forger(workshop.copy("random"))
    policies = [Policy(np.full(3, -0.02 * run), np.ones(3)) for run in RUNS]
    replace_cells(
        forger,
        lambda cell: rollouts(
            cell[0]["task"], with_policy(policies[int(cell[0]["run"])], generator(cell)), seeds_of(cell)
        ),
    )
    for run in RUNS:
        forger.put_policy(policies[run], [run])
    forger.declare("algorithm", '"deep learning"')
    forger.declare("evaluation", '"deterministic"')
    forger.declare("parameters_last", "100000")
    return forger.commit()
