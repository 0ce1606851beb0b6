"""What a stranger's code can do in the box: every attack of the table stops where its row says."""

import json
import re
from pathlib import Path

import pytest

from .attacks import ALL_INSIDE, ENDINGS, INSIDE, Attack, Ending, agent_file
from .conftest import Ordinary

CORE_PATTERN = Path("/proc/sys/kernel/core_pattern")
HEAD = """
import json
import gymnasium as gym
from gym_extensions.baselines.isolated.confine import MEBIBYTE, Limits
from gym_extensions.baselines.isolated.proxy import IsolatedAgent
from gym_extensions.errors import BenchError
from pathlib import Path
from gym_extensions.baselines.agent_spec import first_actions, require_agreement
from gym_extensions.baselines.agent import Resumable, load, policy_of, save
from gym_extensions.baselines.training.environment import TrainingEnv
from gym_extensions.catalog.groups import group
from gym_extensions.envs import make_vec
"""
ONE_BOX = f"""{HEAD}
spaces = gym.spaces.Box(-1, 1, (11,)), gym.spaces.Box(-1, 1, (3,))
agent = IsolatedAgent("inside.py:Agent", Limits(files=64 * MEBIBYTE, cpu_seconds=60))(*spaces, 0)
outcomes, seconds, process = agent.card().hyperparameters, agent.box_used[0], agent.box._process
del agent
print(json.dumps([outcomes, seconds, process.returncode]))
"""
ONE_BOX_EACH = f"""{HEAD}
small = dict(output=MEBIBYTE, policy=1_000_000)
hopper = group("hopper-gravity").tasks[0]
env = make_vec(hopper, 1)


def story(cpu_seconds, wait_seconds):
    limits = Limits(cpu_seconds=cpu_seconds, wait_seconds=wait_seconds, **small)
    spaces = env.single_observation_space, env.single_action_space
    agent = IsolatedAgent("agent.py:Agent", limits)(*spaces, 0)
    agent.card()
    actions = first_actions(agent, env, [1], None)
    policy = policy_of(agent)
    if policy is not None:
        require_agreement(policy, env, [1], actions, 0)
    if isinstance(agent, Resumable):
        save(agent, Path("saved.npz"))
        load(IsolatedAgent("agent.py:Agent", limits)(*spaces, 0), Path("saved.npz"))
    agent.learn(TrainingEnv(make_vec(hopper, 1), [hopper.id], steps=1000, batch_steps=250, seed=0), 1000)


verdicts = {{}}
for name, file, times in json.load(open("endings.json")):
    open("agent.py", "w").write(file)
    try:
        story(*times)
        verdicts[name] = ["none", ""]
    except BenchError as error:
        verdicts[name] = [error.code, str(error)]
print(json.dumps(verdicts))
"""


TIMES = {"loops": (2, 60), "sleeps": (60, 3)}
"""Seconds of processor time, and of waiting, by the first word of an agent's name."""


@pytest.fixture(scope="module")
def outcomes(ordinary: Ordinary) -> dict[str, str]:
    """What became of every attack, by name."""
    before = CORE_PATTERN.read_text()
    programs = json.dumps([(attack.name, attack.program) for attack in INSIDE])
    file = ordinary.home / "inside.py"
    file.write_text(f"PROGRAMS = {programs!r}\n{ALL_INSIDE}", encoding="utf-8")
    file.chmod(0o666)  # only the mount refuses to write it
    found: dict[str, str]
    found, seconds, status = ordinary.run(ONE_BOX)
    assert CORE_PATTERN.read_text() == before
    assert 0.1 < seconds < 60  # what a run's document states is more than the world's own time
    assert status is not None, "the guest outlives its box"
    return found


@pytest.mark.parametrize("attack", INSIDE, ids=lambda attack: attack.name)
def test_an_attack_is_stopped(outcomes: dict[str, str], attack: Attack) -> None:
    assert re.fullmatch(attack.outcome, outcomes[attack.name], re.DOTALL)


@pytest.fixture(scope="module")
def verdicts(ordinary: Ordinary) -> dict[str, tuple[str, str]]:
    """The code and the text of the error of every agent that ends with one."""
    files = [(each.name, agent_file(each), TIMES.get(each.name.split()[0], (60, 60))) for each in ENDINGS]
    (ordinary.home / "endings.json").write_text(json.dumps(files), encoding="utf-8")
    found: dict[str, tuple[str, str]] = ordinary.run(ONE_BOX_EACH)
    return found


@pytest.mark.parametrize("ending", ENDINGS, ids=lambda ending: ending.name)
def test_an_agent_ends_with_a_verdict(verdicts: dict[str, tuple[str, str]], ending: Ending) -> None:
    code, text = verdicts[ending.name]
    assert code == ending.code, text
    assert any(words in text for words in ending.words.split("|")) or ending.words in text
    assert len(text) < 3000
