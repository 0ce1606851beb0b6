"""In the box an agent gives the same logs, policies and manifests, byte for byte; and it resumes."""

import json
import re
import signal
import textwrap
import time

import pandas as pd
import pytest

from ..conftest import digests
from .conftest import ROOT, Ordinary

PAGE = (ROOT / "docs/agents.md").read_text(encoding="utf-8")
CLIMBER, POLICY, CARD, *_ = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
TRAIN = """
import json, sys
from gym_extensions.__main__ import main

print(json.dumps([main(["train", *command]) for command in json.loads(sys.argv[1])]))
"""
GLOBAL = """
import random
import numpy as np
try:
    from torch import rand
except ModuleNotFoundError:
    rand = np.random.rand


class Agent:
    \"\"\"Draws from all generators that the loop seeds, in training and in evaluation.\"\"\"

    def __init__(self, observation_space, action_space, seed):
        self.space, self.scale = action_space, random.random() + float(rand(1)[0])

    def act(self, observations, context):
        noise = np.random.uniform(-1, 1, (len(observations), *self.space.shape))
        return self.scale * noise * context.episode_starts[:, None] + 0.01 * random.random()

    def learn(self, env, steps):
        env.reset()
        for _ in range(steps // env.num_envs):
            drawn = env.action_space.sample() + env.np_random.normal(size=env.action_space.shape)
            *_, terminated, truncated, _ = env.step(drawn.astype(np.float32))
            self.scale = 0.9 * self.scale + 0.1 * float(drawn.mean())
            if (ended := terminated | truncated).any():
                env.reset(options={"reset_mask": ended})
"""
MEMORY = """
import json
import gymnasium as gym
from gym_extensions.baselines.isolated.proxy import IsolatedAgent
from gym_extensions.baselines.training.checkpoints import peak_memory_mb, usage_since

agent = IsolatedAgent("large.py:Agent")(gym.spaces.Box(-1, 1, (2,)), gym.spaces.Box(-1, 1, (2,)), 0)
print(json.dumps([peak_memory_mb(), usage_since(0.0, 0, agent).peak_memory_mb]))
"""


ACTING = """

class Acting(HillClimber):
    def act(self, observations):
        return self.policy().act(observations)
"""
"""After the hill climber: the same one, which acts with the policy that it publishes."""
SAC = """
from stable_baselines3 import SAC
from gym_extensions.baselines import sb3

make = sb3(SAC, learning_starts=900, batch_size=32, policy_kwargs={"net_arch": [16]})
"""
"""Its updates begin after 900 of the 1,000 steps of ``smoke``."""
WITH_TORCH = ("ppo", "sac:make", "recurrent:Recurrent")
HONEST = {
    "climber:HillClimber": "--protocol single",
    "drawing:Agent": "--evaluate-every 250",
    "multi-head": "--evaluate-every 500 --num-envs 2",
    **dict.fromkeys(("acting:Acting", "trpo", "cloning", "packnet", *WITH_TORCH), ""),
}
"""Agents, and options. ``acting`` acts with its policy, which numba compiles in every box."""
QUICK = ("climber:HillClimber", "drawing:Agent", "multi-head")


def climber() -> str:
    """The hill climber of docs/agents.md with policy and card, as a stranger would submit it."""
    head, _, main = CLIMBER.partition("\n\nif __name__")
    imports = "from gym_extensions.baselines import Card\nfrom gym_extensions.policies import Policy\n"
    body = "\n".join(textwrap.indent(textwrap.dedent(part), "    ") for part in (POLICY, CARD))
    return f"{imports}{head.rstrip()}\n\n{body}\n\nif __name__{main}"


def command(agent: str, out: str, *more: str) -> list[str]:
    named = ["--groups", "pusher", "--budget", "smoke", "--jobs", "0", "--quiet", "--out", out]
    return [agent, *named, *more]


def in_and_out(ordinary: Ordinary, inside: str, outside: str, *more: str) -> dict[str, str]:
    """The digests of the files of an agent, which are the same in and out of the box."""
    name = outside.partition(":")[0]
    commands = [command(inside, f"{name}-in", "--isolated", *more), command(outside, f"{name}-out", *more)]
    assert ordinary.run(TRAIN, json.dumps(commands)) == [0, 0]
    one, other = (digests(ordinary.home / f"{name}-{place}") for place in ("in", "out"))
    assert one == other
    return one


@pytest.fixture(scope="module")
def agents(ordinary: Ordinary) -> Ordinary:
    """The user, with the files of the agents: where they are trained, and in a folder of their own."""
    example = (ROOT / "examples/recurrent.py").read_text(encoding="utf-8")
    files = {"climber": climber(), "drawing": GLOBAL, "sac": SAC, "recurrent": example}
    for folder in (ordinary.home, ordinary.home / "agents"):
        folder.mkdir(exist_ok=True)
        for name, text in (files | {"acting": climber() + ACTING}).items():
            (folder / f"{name}.py").write_text(text, encoding="utf-8")
    return ordinary


@pytest.mark.parametrize(
    "agent", [each if each in QUICK else pytest.param(each, marks=pytest.mark.slow) for each in HONEST]
)
def test_the_same_files_in_and_out_of_the_box(agents: Ordinary, agent: str) -> None:
    if agent in WITH_TORCH:
        pytest.importorskip("torch")
    file, _, factory = agent.partition(":")
    inside = f"agents/{file}.py:{factory}" if factory else agent
    assert len(in_and_out(agents, inside, agent, *HONEST[agent].split())) >= 3
    (path,) = agents.home.glob(f"{file}-in/pusher/*/run0.json")
    words = f"gym-extensions train --isolated {inside.removeprefix('agents/')} --groups pusher"
    assert json.loads(path.read_bytes())["command"].startswith(words)
    stages = pd.read_csv(path.with_suffix(".csv")).groupby("stage")["return"].agg(tuple)
    assert len(stages) == 1 or stages.nunique() > 1, "it learns"


def test_the_memory_is_that_of_both_processes(ordinary: Ordinary) -> None:
    """An agent of 400 MB in a box: they lie in the guest, and the world has its own."""
    (ordinary.home / "large.py").write_text(f"{GLOBAL}\nHELD = np.ones(50_000_000)\n", encoding="utf-8")
    world, both = ordinary.run(MEMORY)
    assert world + 400 < both < world + 1000


def test_a_machine_that_dies_repeats_no_finished_stage(ordinary: Ordinary) -> None:
    """The world is killed in the second stage; the same command continues, and nothing is left running."""
    words = json.dumps([command("trpo", "died", "--isolated")])
    process = ordinary.start(TRAIN, words)
    stage = ordinary.home / "died/.progress/pusher/sequential-run0/stage1.json"
    while not stage.exists() and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert not (ordinary.home / "died/pusher").exists()
    finished = stage.stat().st_mtime_ns
    log = ordinary.home / "died/.progress/train.log"
    before = len(log.read_text().splitlines())
    assert ordinary.run(TRAIN, words) == [0]
    later = "\n".join(log.read_text().splitlines()[before:])
    assert "stage 2" in later
    assert "stage 1: trains" not in later
    assert not stage.exists() or stage.stat().st_mtime_ns == finished
    assert ordinary.run(TRAIN, json.dumps([command("trpo", "whole")])) == [0]
    assert digests(ordinary.home / "died") == digests(ordinary.home / "whole")


def test_a_network_is_read_and_run_in_a_box_of_its_own(ordinary: Ordinary) -> None:
    pytest.importorskip("onnx")
    pytest.importorskip("onnxruntime")
    network = (
        climber()
        .replace("return Policy(", "return OnnxPolicy(Policy(")
        .replace('output_activation="tanh",\n        )', 'output_activation="tanh",\n        ).to_onnx())')
    )
    file = ordinary.home / "network.py"
    file.write_text(network.replace("import Policy", "import OnnxPolicy, Policy"), encoding="utf-8")
    found = in_and_out(ordinary, "network.py:HillClimber", "network:HillClimber")
    assert [name for name in found if name.endswith(".onnx")]
