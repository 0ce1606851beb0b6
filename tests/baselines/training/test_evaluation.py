"""Evaluation: what an agent is given; during training: when, what is written, and no effect on learning."""

from pathlib import Path
from typing import Any

import numpy as np

from gym_extensions import results
from gym_extensions.baselines import Context, Monitor, train
from gym_extensions.baselines.agent import TaskLabel
from gym_extensions.baselines.algorithms.trpo import Trpo2017
from gym_extensions.baselines.training.progress import TaskEvaluated
from gym_extensions.baselines.training.runner import evaluate
from gym_extensions.catalog.groups import group
from gym_extensions.envs import make_vec
from gym_extensions.submissions.run import read_run

from ..conftest import QUICK_GROUP, SHORT_GROUP, Watched, digests
from .test_environment import Counting

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


class Sampling(Trpo2017):
    """An agent that samples, and draws from a global generator while it learns and acts."""

    policy: Any = None

    def act(self, observations: Any) -> Any:
        return super().act(observations) * np.random.random()  # noqa: NPY002

    def learn(self, env: Any, steps: int) -> None:
        super().learn(env, steps)
        self._theta *= np.float32(np.random.random())  # noqa: NPY002


def test_a_sampled_agent_that_can_be_saved_learns_and_acts_the_same(tmp_path: Path) -> None:
    logs = []
    for every in (500, None):
        monitor, out = Monitor(evaluate_every=every, evaluate_episodes=2), tmp_path / f"every-{every}"
        logs += train(Sampling, QUICK_GROUP, "sequential", "smoke", 0, out=out, progress=monitor)
    assert logs[0].read_bytes() == logs[1].read_bytes()


class Listening:
    """An agent that stores the context of each call."""

    def __init__(self, num_actions: int) -> None:
        self.num_actions, self.contexts = num_actions, list[Context]()

    def act(self, observations: Any, context: Context) -> Any:
        self.contexts.append(context)
        return np.ones((len(observations), self.num_actions))

    def learn(self, env: Any, steps: int) -> None:
        """Does nothing."""


def test_an_episode_starts_at_the_first_step_and_after_each_autoreset() -> None:
    agent = Listening(1)
    evaluate(agent, Counting([2, 5]), [11, 12])
    starts = np.array([context.episode_starts for context in agent.contexts]).T
    # The first environment's third observation is the last one of its episode. The step from there resets it.
    assert starts.tolist() == [[True, False, False, True, False], [True, False, False, False, False]]


def test_the_context_has_the_task_only_if_it_is_passed() -> None:
    agent, envs = Listening(3), make_vec("Hopper", 2)
    evaluate(agent, envs, [11, 12])
    assert not hasattr(agent.contexts[0], "task")
    evaluate(agent, envs, [11, 12], label=TaskLabel("gym_extensions/Hopper-v0", 2))
    assert (agent.contexts[-1].task_id, agent.contexts[-1].task) == ("gym_extensions/Hopper-v0", 2)
