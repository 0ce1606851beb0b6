"""Records the submission ``snapshots`` from the stored policies of another one, without training.

    python -m tools.snapshots submissions/trpo --groups core --runs 0-9 --out submissions/snapshots

After stage s, a task that was learned has the policy that the source stored right after learning it; every
other task has the source's present policy. That is what the agent ``snapshots`` has after it learned as the
source did. Each policy is evaluated anew; the curves are the source's. An interrupted command goes on
with the runs that are missing.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from gym_extensions.baselines import Card, Observes, record
from gym_extensions.baselines.cli import parse_runs
from gym_extensions.baselines.training.jobs import parse_groups
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.policies import Policy, load
from gym_extensions.submissions.layout import DOCUMENT, LOG, MANIFEST, run_file
from gym_extensions.submissions.manifest import Manifest, manifest_of, parse
from gym_extensions.submissions.policies.mlp_arrays import KEYS, LAYER_FIELDS
from gym_extensions.submissions.run import read_run

OBSERVES = Observes(task_in_training=True, task_in_evaluation=True, boundaries=True)


def stacked(policies: Sequence[Policy]) -> Policy:
    """One policy with a row per task, the policies of the tasks in order."""
    values: dict[str, Any] = {}
    for name in (field.name for field in fields(Policy)):
        rows = [getattr(policy, name) for policy in policies]
        if name in LAYER_FIELDS:  # a layer without a mask has None
            layers = zip(*rows, strict=True)
            values[name] = tuple(None if layer[0] is None else np.stack(layer) for layer in layers)
        else:
            values[name] = np.stack(rows) if KEYS[name].has_tasks and rows[0] is not None else rows[0]
    return Policy(**values)


def policies_until(source: Path, group: TaskGroup, run: int, stage: int) -> list[Policy]:
    """The policies that a run stored after the stages 1 to ``stage``; that of stage 0 for stage 0."""
    numbers = range(1, stage + 1) if stage else [0]
    found = [load(source, group, run=run, stage=number) for number in numbers]
    if not all(isinstance(policy, Policy) for policy in found):
        raise SystemExit(f"{source} has networks in {group.name}; only plain policies can be stacked.")
    return found  # type: ignore[return-value]


def card_from(manifest: Manifest, parameters: int) -> Card:
    """The card of the snapshots of a submission, with its hyperparameters and tuning."""
    title = manifest.title
    return Card(
        "snapshots",
        title=f"{title} + snapshots",
        description=f"{title} with a copy of its policy per learned task; recorded from its stored policies.",
        evaluation=manifest.protocol.evaluation,
        hyperparameters=manifest.hyperparameters,
        tuning_steps=manifest.tuning.steps if manifest.tuning else 0,
        tuning_tasks=tuple(manifest.tuning.tasks) if manifest.tuning else (),
        parameters=parameters,
        parent=manifest.protocol.algorithm,
    )


def record_run(source: Path, group: TaskGroup, run: int, out: Path) -> None:
    """Records all stages of a run."""
    manifest = manifest_of(parse((source / MANIFEST).read_bytes()))
    document = read_run(source / run_file(group.name, "sequential", run, DOCUMENT))
    curves: dict[int, dict[str, list[tuple[int, float]]]] = defaultdict(dict)
    for curve in document.curves:
        curves[curve.stage][curve.task] = list(zip(curve.steps, curve.returns, strict=True))
    for stage in range(len(group.tasks) + 1):
        policies = policies_until(source, group, run, stage)
        copy = (
            sum(array.size for array in (*policies[0].weights, *policies[0].biases)) + policies[0].num_actions
        )
        card = card_from(manifest, document.memory.parameters_first + (len(policies) - 1) * copy)
        record(
            stacked(policies) if stage else policies[0],
            *(group, "sequential"),
            run=run,
            stage=stage,
            out=out,
            budget=manifest.protocol.budget,
            card=card,
            observes=OBSERVES,
            curves=curves[stage],
        )


def main(argv: Sequence[str] | None = None) -> None:
    """Records the runs of every group and prints a line for each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("source", type=Path, help="the submission that stored the policies")
    parser.add_argument("--groups", default="core")
    parser.add_argument("--runs", default="0-9")
    parser.add_argument("--out", type=Path, default=Path("submissions/snapshots"))
    options = parser.parse_args(argv)
    for run in parse_runs(options.runs):
        for group in parse_groups(options.groups.split(",")):
            if not (options.out / run_file(group.name, "sequential", run, LOG)).exists():
                record_run(options.source, group, run, options.out)
                print(f"{group.name}, run {run}: recorded", flush=True)


if __name__ == "__main__":
    main()
