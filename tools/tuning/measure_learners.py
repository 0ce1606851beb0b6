"""Measures what an agent learns: deterministic or sampled returns and processor time, one JSON line per run.

    python -m tools.tuning.measure_learners --tasks HalfCheetah,Hopper,Walker2d --seeds 0 1 2 --jobs 2
    python -m tools.tuning.measure_learners --tasks Hopper@0.9,Walker2d@1.1 --set discount=0.99
    python -m tools.tuning.measure_learners --tasks Hopper@0.7,Hopper@0.9,Hopper@1.1 --sequential
    python -m tools.tuning.measure_learners --agent l2 --argument coefficient=0.1 --sequential

``Hopper@0.9`` is Hopper under .9 of the earth's gravity. With ``--sequential`` one agent per seed learns the
tasks in order, and every task is evaluated after each. ``--set`` changes rows of the agent's table in
``gym_extensions.baselines.algorithms.trpo``, as in ``--set discount=0.99 --set trust_region.max_kl=0.02``.
``--argument`` sets a keyword argument of the agent's factory. ``--agent`` is any name of ``train``.
"""

import argparse
import json
import os
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, fields, is_dataclass, replace
from multiprocessing import get_context
from typing import Any

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import TaskLabel, observes_of
from gym_extensions.baselines.algorithms.trpo import HENDERSON_2017, REFERENCE, TrpoSettings
from gym_extensions.baselines.training.environment import Report, TrainingEnv
from gym_extensions.baselines.training.runner import evaluate
from gym_extensions.catalog.tasks import Task, customize, task
from gym_extensions.catalog.variations import Gravity
from gym_extensions.envs import make_vec
from gym_extensions.errors import reports_mistakes, require_known
from tools import argument_parser

TABLES = {"trpo": REFERENCE, "trpo-2017": HENDERSON_2017}
EVALUATION_SEEDS = range(20)


@dataclass(frozen=True)
class Run:
    """One seed of one agent: the tasks that it learns in order, and the steps per task."""

    agent: str
    arguments: dict[str, Any]  # of the agent's factory
    tasks: tuple[str, ...]
    seed: int
    steps: int
    batch_steps: int
    num_envs: int


def task_named(text: str) -> Task:
    """The task of a name such as ``Hopper`` or ``Hopper@0.9``."""
    name, _, gravity = text.partition("@")
    return customize(task(name), (Gravity(float(gravity)),)) if gravity else task(name)


def with_setting(settings: Any, assignment: str) -> Any:
    """The dataclass with one row changed: ``discount=0.99``, ``trust_region.max_kl=0.02``.

    Raises ``BenchError`` for an unknown row.
    """
    path, _, text = assignment.partition("=")
    name, _, rest = path.partition(".")
    require_known("row", name, [row.name for row in fields(settings)], "--set")
    current = getattr(settings, name)
    if is_dataclass(current):
        return replace(settings, **{name: with_setting(current, f"{rest}={text}")})
    value: object = text if isinstance(current, str) else json.loads(text)
    return replace(settings, **{name: tuple(value) if isinstance(value, list) else value})


def trpo_settings(agent: str, assignments: Sequence[str]) -> dict[str, TrpoSettings]:
    """The keyword argument ``settings`` of the agent, empty for the defaults of its factory."""
    if not assignments and agent not in TABLES:
        return {}
    settings = TABLES.get(agent, REFERENCE)
    for assignment in assignments:
        settings = with_setting(settings, assignment)
    return {"settings": settings}


def measure(run: Run) -> list[dict[str, Any]]:
    """Trains and evaluates one run: one row per learned task, with the returns on all tasks after it."""
    tasks = [task_named(name) for name in run.tasks]
    evaluation = [make_vec(each, len(EVALUATION_SEEDS)) for each in tasks]
    spaces = (evaluation[0].single_observation_space, evaluation[0].single_action_space)
    make: Any = algorithms.factory("trpo" if run.agent in TABLES else run.agent)
    agent, rows = make(*spaces, run.seed, **run.arguments), []
    observes, ids = observes_of(agent, run.agent), tuple(each.id for each in tasks)
    for number, each in enumerate(tasks, start=1):
        env = make_vec(each, run.num_envs)
        batches: list[Report] = []
        recorder = TrainingEnv(
            env,
            [each.id],
            steps=run.steps,
            batch_steps=run.batch_steps,
            seed=1000 + run.seed,
            observes=observes,
            group_ids=ids,
            stage=number,
            report=batches.append,
        )
        start = time.process_time()
        agent.learn(recorder, run.steps)
        seconds = time.process_time() - start
        recorder.flush()
        env.close()
        returns = {}
        for index, (name, evaluation_env) in enumerate(zip(run.tasks, evaluation, strict=True)):
            label = TaskLabel(ids[index], index) if observes.task_in_evaluation else None
            episodes = evaluate(agent, evaluation_env, list(EVALUATION_SEEDS), label=label)
            returns[name] = round(sum(row.return_ for row in episodes) / len(episodes), 1)
        curve = [round(value) for batch in batches for value in batch.returns.values()]
        rows.append(
            {
                "trained": each.name,
                "seed": run.seed,
                "steps": run.steps,
                "num_envs": run.num_envs,
                "returns": returns,
                "cpu_s_per_1M": round(seconds / run.steps * 1e6, 1),
                "training_curve": curve[:: max(1, len(curve) // 15)],
            }
        )
    return rows


def runs(options: argparse.Namespace) -> Iterator[Run]:
    """The runs that the options name."""
    pairs = [assignment.partition("=") for assignment in options.argument]
    arguments = {name: json.loads(value) for name, _, value in pairs}
    arguments |= trpo_settings(options.agent, options.set)
    names = tuple(options.tasks.split(","))
    sizes = (options.steps, options.batch_steps, options.num_envs)
    for tasks in [names] if options.sequential else [(name,) for name in names]:
        for seed in options.seeds:
            yield Run(options.agent, arguments, tasks, seed, *sizes)


@reports_mistakes
def main(argv: Sequence[str] | None = None) -> int:
    """Prints a JSON line per run and learned task, as the runs finish."""
    parser = argument_parser("tools.tuning.measure_learners", __doc__)
    parser.add_argument("--agent", choices=algorithms.names(), default="trpo")
    parser.add_argument("--argument", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--tasks", default="HalfCheetah,Hopper,Walker2d")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2, 3, 4])
    parser.add_argument("--steps", type=int, default=300_000, help="per task")
    parser.add_argument("--batch-steps", type=int, default=2_000)
    parser.add_argument("--num-envs", type=int, default=20)
    parser.add_argument("--set", action="append", default=[], metavar="ROW=VALUE")
    parser.add_argument("--sequential", action="store_true")
    parser.add_argument("--jobs", type=int, default=1, help="worker processes of one BLAS thread each")
    options = parser.parse_args(argv)
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # read by the spawned workers, which load numpy afresh
    with ProcessPoolExecutor(options.jobs, mp_context=get_context("spawn")) as pool:
        for future in as_completed([pool.submit(measure, run) for run in runs(options)]):
            for row in future.result():
                row |= {"agent": options.agent, "set": options.set + options.argument}
                print(json.dumps(row), flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
