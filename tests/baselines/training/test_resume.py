"""A run that is killed goes on at its last finished stage, and ends in the same bytes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.baselines.algorithms import trpo
from gym_extensions.baselines.train import train
from gym_extensions.errors import BenchError

from ..conftest import digests

COMMAND = [
    *(sys.executable, "-m", "gym_extensions", "train", "trpo", "--group", "hopper-gravity"),
    *("--protocol", "sequential,joint", "--budget", "smoke", "--runs", "0", "--out"),
]
MANY_THREADS = {**os.environ, "OPENBLAS_NUM_THREADS": "2"}
"""What a user's shell may say; the command's processes have one thread all the same."""


def test_killed_at_a_moment_and_started_again_the_files_are_those_of_one_go(trpo_submission, tmp_path):
    out = tmp_path / "killed"
    unit = out / ".progress/hopper-gravity/sequential-run0"
    process = subprocess.Popen(
        [*COMMAND, str(out)], stdout=subprocess.DEVNULL, start_new_session=True, env=MANY_THREADS
    )
    deadline = time.monotonic() + 120
    while not (unit / "stage1.json").exists() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.02)
    time.sleep(0.3)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert (unit / "stage1.json").exists()
    assert not (out / "hopper-gravity/sequential.csv").exists()
    done = subprocess.run([*COMMAND, str(out)], check=True, capture_output=True, text=True, env=MANY_THREADS)
    assert "sequential-run0 stage 1:" not in done.stdout, "a finished stage was run again"
    assert digests(out) == digests(trpo_submission)
    assert not unit.exists()


def test_a_worker_ends_when_the_command_is_killed(tmp_path):
    out = tmp_path / "killed"
    process = subprocess.Popen([*COMMAND, str(out)], stdout=subprocess.DEVNULL)
    unit = out / ".progress/hopper-gravity/sequential-run0"
    deadline = time.monotonic() + 120
    while not (unit / "settings.json").exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    workers = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    if not workers.exists():
        process.kill()
        pytest.skip("the system does not list child processes")
    children = [int(pid) for pid in workers.read_text().split()]
    process.kill()
    process.wait()
    deadline = time.monotonic() + 30
    while any(Path(f"/proc/{pid}").exists() for pid in children) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert children
    assert not [pid for pid in children if Path(f"/proc/{pid}").exists()]


def test_an_agent_that_is_saved_and_loaded_goes_on_as_if_never_stopped(tmp_path):
    from gym_extensions.baselines.training.recorder import Recorder
    from gym_extensions.envs import make_vec

    def learn(agent):
        env = make_vec("Hopper", 2)
        agent.learn(Recorder(env, ["Hopper"], steps=400, batch_steps=200, seed=9), 400)

    env = make_vec("Hopper", 2)
    spaces = (env.single_observation_space, env.single_action_space)
    kept, loaded = trpo.make(*spaces, 4), trpo.make(*spaces, 5)
    learn(kept)
    kept.save(tmp_path / "agent.npz")
    loaded.load(tmp_path / "agent.npz")
    seen = np.ones((3, 11))
    assert np.array_equal(kept.act(seen), loaded.act(seen))
    learn(kept)
    learn(loaded)
    assert np.array_equal(kept.act(seen), loaded.act(seen))


class PowerCutError(RuntimeError):
    """The machine goes down."""


class Forgetful:
    """Acts by what it has learned, how many stages there were, and cannot be saved; stops once."""

    stopped = False

    def __init__(self, observation_space, action_space, seed):
        self.shape, self.stages = action_space.shape, 0

    def act(self, observations):
        return np.full((len(observations), *self.shape), 1.0 - self.stages / 10)

    def learn(self, env, steps):
        self.stages += 1
        if self.stages == 3 and not Forgetful.stopped:
            Forgetful.stopped = True
            raise PowerCutError


def test_an_agent_that_cannot_be_saved_starts_again(tmp_path):
    with pytest.raises(PowerCutError):
        train(Forgetful, "hopper-gravity", "sequential", "smoke", 0, out=tmp_path / "stopped")
    train(Forgetful, "hopper-gravity", "sequential", "smoke", 0, out=tmp_path / "stopped")
    train(Forgetful, "hopper-gravity", "sequential", "smoke", 0, out=tmp_path / "whole")
    assert digests(tmp_path / "stopped") == digests(tmp_path / "whole")


def test_parts_of_another_run_are_not_mixed_in(tmp_path):
    Forgetful.stopped = False
    with pytest.raises(PowerCutError):
        train(Forgetful, "hopper-gravity", "sequential", "smoke", 0, out=tmp_path)
    with pytest.raises(BenchError, match="Parts of an unfinished run with other settings are here"):
        train("still", "hopper-gravity", "sequential", "smoke", 0, out=tmp_path)
