"""Wrong arguments of ``train``, and what results depend on."""

import subprocess
import sys
import threading
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Monitor, Origin, Parallel, train
from gym_extensions.scoring.pipeline import make_scorer
from gym_extensions.submissions.run import read_run

from ..conftest import refused
from .conftest import QUICK_GROUP, SHORT_GROUP, digests

BAD: list[tuple[type[Monitor | Origin | Parallel], dict[str, Any], str]] = [
    (Monitor, {"evaluate_every": 2.5}, "bad-evaluate-every"),
    (Monitor, {"evaluate_every": True}, "bad-evaluate-every"),
    (Monitor, {"evaluate_episodes": 0}, "bad-evaluate-episodes"),
    (Parallel, {"num_threads": "2"}, "bad-num-threads"),
    (Parallel, {"num_envs": "8"}, "bad-num-envs"),
    (Origin, {"by": "A" * 201}, "bad-origin"),
    (Origin, {"by": "A\u200bB"}, "bad-origin"),
    (Origin, {"seeds": 5}, "bad-origin"),
]


@pytest.mark.parametrize(("settings", "arguments", "code"), BAD)
def test_a_setting_of_wrong_type_or_range_is_rejected(settings: Any, arguments: Any, code: str) -> None:
    with refused(code):
        settings(**arguments)


@pytest.mark.parametrize(
    ("arguments", "code"), [({"jobs": Parallel(num_envs=21)}, "bad-num-envs"), ({"jobs": 1.5}, "bad-jobs")]
)
def test_a_wrong_argument_is_rejected_at_once(arguments: dict[str, Any], code: str, tmp_path: Path) -> None:
    with refused(code):
        train("zero", SHORT_GROUP, "single", "smoke", 0, out=tmp_path / "mine", **arguments)
    assert not (tmp_path / "mine").exists()


def test_logs_and_policies_do_not_depend_on_the_number_of_threads(tmp_path: Path) -> None:
    for num_threads in (1, 2):
        folder = tmp_path / f"{num_threads}-threads"
        parallel = Parallel(num_threads=num_threads)
        train("trpo", QUICK_GROUP, "sequential", "smoke", 0, out=folder, jobs=parallel)
    one, two = map(digests, sorted(tmp_path.iterdir()))
    assert {Path(name).suffix for name in one} >= {".csv", ".npz"}
    assert one == two


class Explorer:
    """An agent whose random numbers come from everywhere but from a generator of its own."""

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        self.weights = np.zeros((observation_space.shape[0], action_space.shape[0]))
        self.weights += action_space.sample() * np.random.random()  # noqa: NPY002

    def act(self, observations: Any) -> Any:
        noise = np.random.standard_normal((len(observations), self.weights.shape[1]))  # noqa: NPY002
        return np.tanh(observations @ self.weights + noise)

    def learn(self, env: Any, steps: int) -> None:
        env.reset()
        for _ in range(steps // env.num_envs // 10):
            observations, *_ = env.step(env.action_space.sample())
            scale = 1e-3 * env.np_random.random() * np.random.random()  # noqa: NPY002
            self.weights += scale * np.outer(observations.mean(axis=0), env.single_action_space.sample())


def test_random_numbers_of_spaces_environments_and_global_generators_follow_the_run(tmp_path: Path) -> None:
    for name in ("first", "second"):
        train(Explorer, QUICK_GROUP, "sequential", "smoke", [0, 1], out=tmp_path / name)
    first, second = (digests(tmp_path / name) for name in ("first", "second"))
    assert first == second
    logs = [f"{QUICK_GROUP.name}/sequential/run{run}.csv" for run in (0, 1)]
    assert first[logs[0]] != first[logs[1]]


def test_worker_processes_train_an_agent_of_a_notebook_as_this_process_does(tmp_path: Path) -> None:
    code = """
from gym_extensions.baselines import train
from gym_extensions.baselines.algorithms.floors import Zero
class Mine(Zero): ...
for jobs in (0, 2):
    train(Mine, "pusher", "joint", "smoke", 0, out=f"jobs{jobs}", jobs=jobs)
"""
    subprocess.run([sys.executable], input=code, text=True, cwd=tmp_path, check=True)
    assert digests(tmp_path / "jobs0") == digests(tmp_path / "jobs2")


DRAWN = """
import torch


class Drawn:
    def __init__(self, observation_space, action_space, seed):
        self.layer = torch.nn.Linear(observation_space.shape[0], action_space.shape[0])

    def act(self, observations):
        return self.layer(torch.as_tensor(observations, dtype=torch.float32)).detach().numpy()

    def learn(self, env, steps): ...
"""


def test_a_worker_process_loads_and_seeds_torch_for_the_agents_weights(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    (tmp_path / "drawn.py").write_text(DRAWN)
    for jobs in (0, 1):
        agent = f"{tmp_path / 'drawn.py'}:Drawn"
        train(agent, QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / f"jobs{jobs}", jobs=jobs)
    assert digests(tmp_path / "jobs0") == digests(tmp_path / "jobs1")


def test_a_script_that_its_workers_would_run_again_is_named(tmp_path: Path) -> None:
    code = """
from gym_extensions.baselines import train
train("zero", "pusher", "joint", "smoke", 0, out="mine", jobs=2)
"""
    (tmp_path / "script.py").write_text(code)
    command = [sys.executable, "script.py"]
    errors = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False).stderr
    assert "put the call of train under `if __name__ == '__main__':`" in errors
    assert errors.count("Traceback (most recent") == 1


def test_an_agent_that_a_worker_process_cannot_receive_is_refused_before_training(tmp_path: Path) -> None:
    agent: Any = partial(print, threading.Lock())
    with refused("bad-agent", "cannot receive the agent"):
        train(agent, "pusher", "joint", "smoke", 0, out=tmp_path / "mine", jobs=2)
    assert not (tmp_path / "mine").exists()


def test_runs_in_other_orders_are_those_of_their_rows_and_are_scored(tmp_path: Path) -> None:
    """Of two tasks, row 0 of the square ascends and row 1 descends: the same runs, in every byte."""
    protocols, ids = ("sequential", "descending", "balanced"), QUICK_GROUP.task_ids
    train("packnet", QUICK_GROUP, protocols, "smoke", (0, 1), out=tmp_path / "mine")
    folder = tmp_path / "mine" / QUICK_GROUP.name
    for row, equal in enumerate(["sequential", "descending"]):
        assert read_run(folder / f"balanced/run{row}.json").order == list(ids[:: 1 - 2 * row])
        logs = [folder / f"{protocol}/run{row}.csv" for protocol in ("balanced", equal)]
        assert logs[0].read_bytes() == logs[1].read_bytes()
    text = (folder / "sequential/run0.json").read_text()
    assert '"order"' not in text
    card = make_scorer((QUICK_GROUP,))(tmp_path / "mine")
    assert (card.problems, list(card.groups[QUICK_GROUP.id])) == ((), list(protocols))
