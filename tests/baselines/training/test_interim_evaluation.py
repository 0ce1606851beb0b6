"""Evaluation during training: when, what is written, and that nothing else changes."""

import random
from pathlib import Path
from typing import Any

import numpy as np

from gym_extensions import results
from gym_extensions.baselines.algorithms.trpo import Trpo2017
from gym_extensions.baselines.training.environment import Report, TrainingEnv
from gym_extensions.baselines.training.progress import TaskEvaluated
from gym_extensions.baselines.training.runner import acting_copy, evaluate
from gym_extensions.catalog.groups import group
from gym_extensions.envs import make_vec
from gym_extensions.submissions.run import read_run

from ..conftest import SHORT_GROUP, Watched, digests

IDS = group(SHORT_GROUP).task_ids
ROWS = [
    *(("joint", 1, task, step) for step in (500, 1000, 1500) for task in IDS),
    *(("sequential", stage, task, 500) for stage in (1, 2) for task in IDS),
]


def test_every_task_is_evaluated_at_the_chosen_steps(watched: Watched) -> None:
    found = {
        (protocol, each.stage, each.task, round(step, -1), each.episodes)
        for protocol in ("joint", "sequential")
        for each in read_run(watched.folder / SHORT_GROUP / protocol / "run0.json").evaluations
        for step in each.steps
    }
    assert found == {(*row, 2) for row in ROWS}


def test_the_other_files_are_the_same_bytes_without_evaluation_during_training(
    watched: Watched, trpo_submission: Path
) -> None:
    files, expected = digests(watched.folder), digests(trpo_submission)
    assert {path for path in files if files[path] != expected[path]} == {
        f"{SHORT_GROUP}/{protocol}/run0.json" for protocol in ("joint", "sequential")
    }


def test_the_evaluations_are_events_and_rows_of_the_results(watched: Watched) -> None:
    events = [event for event in watched.events if isinstance(event, TaskEvaluated)]
    frame = results.evaluations(watched.folder)
    rows = zip(frame["stage"], frame["task"], frame["step"], frame["return"], strict=True)
    assert {(event.stage, event.task, event.step, round(event.mean_return, 9)) for event in events} == {
        (stage, task, step, round(value, 9)) for stage, task, step, value in rows
    }
    job_steps = [round(event.job_step, -1) for event in events if event.in_training]
    assert job_steps == [500, 500, 1500, 1500] + [step for step in (500, 1000, 1500) for _ in IDS]


def test_a_sampled_agent_that_can_be_saved_learns_and_acts_the_same(tmp_path: Path) -> None:
    env: Any = make_vec("Hopper", 2)

    def create() -> Any:
        return Trpo2017(env.single_observation_space, env.single_action_space, 5)

    def learn(report: Any) -> Any:
        agent = create()
        agents.append(agent)
        recorder = TrainingEnv(env, ["Hopper"], steps=200, batch_steps=100, seed=1, report=report)
        agent.learn(recorder, 200)
        return agent, random.random(), np.random.random()  # noqa: NPY002

    agents: list[Any] = []
    acted, returns = make_vec("Hopper", 2), list[float]()

    def report(batch: Report) -> None:
        path = tmp_path / "acting.npz"
        with acting_copy(agents[-1], create, path) as agent:
            for _ in range(2):
                random.random()
                np.random.random()  # noqa: NPY002
                returns.append(evaluate(agent, acted, [1, 2])[0].return_)
        assert not path.exists()

    outcomes = []
    for each in (report, lambda _: None):
        random.seed(3)
        np.random.seed(3)  # noqa: NPY002  (agents may draw from the global generators)
        outcomes.append(learn(each))
    (first, *numbers), (second, *same) = outcomes
    assert len(set(returns)) == 4, "the evaluations are samples"
    assert numbers == same
    assert np.array_equal(first._theta, second._theta)
    assert np.array_equal(first.act(np.ones((3, 11))), second.act(np.ones((3, 11))))
