"""Attacks with policies of other stages, tasks and runs, and with policy files that are not those of the log."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from gym_extensions.rollouts.policies import Policy

from ..attack import REEVALUATED, REPLAYED, Attack
from ..evaluate import generator, replace_cells, rollouts, seeds_of, with_policy
from ..forger import Forger, Row, cells
from ..judge import Make, submission
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


UNIFORM = Policy(np.zeros(3), np.ones(3), head="uniform")
WIDE = Policy(np.zeros(3), np.ones(3), head="gaussian", log_sigma=np.full(3, 3.0))
LAST, FIRST, SINGLE = ("sequential", 2), ("sequential", 1), ("single", 1)
RETRAINING = "Retraining from committed code, which only reference agents have so far."

ATTACKS = (
    Attack(
        "The best stage is logged as the last one; no policies.",
        submission(present(FIRST, LAST, "none")),
        "new seeds: no policies",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "The best stage is logged as the last one, with the policies of the stated stages.",
        submission(present(FIRST, LAST, "stated")),
        "replay: actions-differ",
    ),
    Attack(
        "The best stage is logged as the last one, with its policies.",
        submission(present(FIRST, LAST, "swapped")),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        RETRAINING,
    ),
    Attack(
        "Experts of single tasks are logged as the last stage; no policies.",
        submission(present(SINGLE, LAST, "none")),
        "new seeds: no policies",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "Experts of single tasks are logged as the last stage, with the policies of the stages.",
        submission(present(SINGLE, LAST, "stated")),
        "replay: actions-differ",
    ),
    Attack(
        "The untrained stage is logged as the one after training, to forget nothing.",
        submission(present(("sequential", 0), FIRST, "stated")),
        "replay: actions-differ",
    ),
    Attack(
        "Experts are packed as one policy with weights per task.",
        submission(files(rows_per_task)),
        "rules: policy-observes-task",
    ),
    Attack(
        "Experts are packed as one policy with weights per task, and the manifest says so.",
        submission(files(declared_rows)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        "Nothing: such entries have a board of their own.",
    ),
    Attack(
        "A policy that falls at once is evaluated as the untrained one, which raises zero-shot transfer.",
        submission(worse("sequential", 0)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        RETRAINING + " New seeds find logs that are too high, not policies that are too weak.",
    ),
    Attack(
        "Policies that fall at once are evaluated in single.csv, which raises asymptotic transfer.",
        submission(worse("single", 1)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        RETRAINING + " The single-task scores of the entry are beside its transfer.",
    ),
    Attack(
        "The policy files of one run are those of another.",
        submission(files(of_another_run)),
        "replay: actions-differ",
    ),
    Attack(
        "The policy files are uniform, of a log that says deterministic.",
        submission(files(replaced(UNIFORM))),
        "rules: sampled-policy",
    ),
    Attack(
        "The policy files are uniform, and the manifest says sampled.",
        submission(files(sampled(UNIFORM))),
        "new seeds: reevaluation-differs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "The policy files are Gaussians that any action agrees with.",
        submission(files(sampled(WIDE))),
        "new seeds: reevaluation-differs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "The policy files of one run are missing.",
        submission(files(lambda forger, folder: [path.unlink() for path in folder.glob("*-run3-*")])),
        "rules: missing-policy",
    ),
    Attack(
        "Only single.csv has policies.",
        submission(files(lambda forger, folder: [path.unlink() for path in folder.glob("sequential*")])),
        "new seeds: no policies for some logs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "A hand-written controller is packed as a trained policy.",
        submission(hand_written),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        RETRAINING,
    ),
)
