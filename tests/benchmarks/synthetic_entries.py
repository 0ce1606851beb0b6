"""Synthetic entries with training curves on the four gravity groups, to measure the site at scale."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.suites import SUITES
from gym_extensions.rollouts.manifest import Code, Memory, Observes, Protocol, Tuning
from gym_extensions.scoring.metrics.returns import Results
from gym_extensions.scoring.references import Reference, References
from gym_extensions.scoring.scorecard.build import score_group
from gym_extensions.scoring.scorecard.manifest import ManifestSummary
from gym_extensions.scoring.scorecard.model import VALIDATED, Scorecard
from gym_extensions.scoring.scorecard.suites import suite_scores

GROUPS = SUITES["gravity"]
BUDGET, STEPS, POINTS = "100k", 100_000, 50
RUNS, EPISODES = 5, 20
SPAN = 1000.0
"""Ceiling of every task; the floor is 0."""

REFERENCES = References(
    "synthetic",
    provisional=True,
    tasks={task: Reference(0.0, SPAN, unsolved=False) for name in GROUPS for task in group(name).task_ids},
)


def entries(count: int, seed: int = 0) -> Iterator[Scorecard]:
    """Scorecards of ``count`` entries with sequential runs; the same seed gives the same entries."""
    rng = np.random.default_rng(seed)
    for index in range(count):
        yield _entry(f"entry-{index:04d}", rng, runs=RUNS if index % 10 else 2)


def _entry(name: str, rng: np.random.Generator, runs: int) -> Scorecard:
    strength, keeps = rng.uniform(0.05, 1.2), rng.uniform(0.6, 1.02)
    groups = {}
    for group_id in GROUPS:
        results = _results(group_id, strength, keeps, runs, rng)
        groups[group_id] = {"sequential": score_group(results, REFERENCES, "sequential", BUDGET)}
    algorithm = ("TRPO", "PPO", "SAC", "EWC")[int(rng.integers(4))]
    return Scorecard(
        name=name,
        title=f"{algorithm} variant {name[-4:]}",
        trust="replayed (300 of 14000 episodes)" if rng.random() < 0.3 else VALIDATED,
        manifest=_manifest(algorithm, bool(rng.random() < 0.1)),
        groups=groups,
        suites=suite_scores(groups),
    )


def _results(group_id: str, strength: float, keeps: float, runs: int, rng: np.random.Generator) -> Results:
    """Returns of an agent that reaches a share of the ceiling and keeps a share of that per later stage."""
    members = group(group_id)
    tasks = len(members.tasks)
    reached = strength * SPAN * (1 + 0.15 * rng.standard_normal((runs, 1, tasks)))
    age = np.arange(tasks + 1)[:, None] - np.arange(1, tasks + 1)
    level = np.where(age >= 0, keeps ** np.maximum(age, 0), 0.1) * reached
    returns = level[..., None] + 40 * rng.standard_normal((runs, tasks + 1, tasks, EPISODES))
    steps = [STEPS // POINTS * (point + 1) for point in range(POINTS)]
    rise = 1 - np.exp(-np.arange(1, POINTS + 1) / 15)
    curves = {
        ("sequential", run, task): (steps, (reached[run, 0, at] * rise + 30 * noise).tolist())
        for run in range(runs)
        for at, task in enumerate(members.task_ids)
        for noise in [rng.standard_normal(POINTS)]
    }
    return Results(members, STEPS, {"sequential": tuple(range(runs))}, sequential=returns, curves=curves)


def _manifest(algorithm: str, conditioned: bool) -> ManifestSummary:
    return ManifestSummary(
        authors=("A. Researcher",),
        description="A synthetic entry.",
        code=Code("", ""),
        protocol=Protocol(BUDGET, algorithm, "sampled"),
        hyperparameters={"step_size": 0.01},
        observes=Observes(conditioned, False, conditioned),
        tuning=Tuning(0, ()),
        memory=Memory(2000, 12345, 12345),
        versions={},
        archive=None,
    )
