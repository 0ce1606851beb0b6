"""The agents of ``examples/`` at the budget ``smoke``: complete logs, true manifests, and what each shows."""

import warnings
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from gym_extensions import results
from gym_extensions.baselines import Context, Observes, Parallel, train
from gym_extensions.catalog.groups import with_custom
from gym_extensions.envs import MotorNoise, TaskGroup, customize, make_vec
from gym_extensions.submissions.reader import read

GROUP = TaskGroup(  # two tasks whose episodes are short
    "short-hoppers",
    (customize("Hopper", max_steps=60), customize("Hopper", [MotorNoise(0.05)], max_steps=60)),
)
NAMED = {"ppo": "Ppo", "sac": "Sac", "ewc": "Ewc", "multi_head": "MultiHead", "recurrent": "Recurrent"}
FACTORIES = NAMED | {"sb3_ppo": "ppo"}
OBSERVES = {
    "multi_head": Observes(task_in_training=True, task_in_evaluation=True),
    "ewc": Observes(boundaries=True),
    "sb3_ppo": Observes(boundaries=True),  # a new Stable-Baselines3 model for every stage
}
EPOCHS = {"ppo": {"epochs": 5}, "ewc": {"epochs": 10}, "recurrent": {"epochs": 3}}
QUICK = EPOCHS | {"sac": {"steps_per_update": 40}}
"""Settings that save time in the tests."""
LEARN = ("ppo", "ewc", "multi_head", "recurrent")
"""The agents whose first task shows progress after its 1000 steps. SAC learns later."""

Load = Callable[[str], ModuleType]


@pytest.fixture(scope="module")
def submissions(load_example: Load, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A submission of each agent. Those that can be saved act afterwards as before."""
    warnings.filterwarnings("error", message=r"After save\(\) and load\(\) the agent takes other actions")
    root = tmp_path_factory.mktemp("examples")
    for name, factory in FACTORIES.items():
        module = load_example(name)
        if name in QUICK:
            module.SETTINGS.update(QUICK[name])
        out = root / name
        parallel = Parallel(num_envs=1 if name == "sb3_ppo" else 5)  # more environments take less time
        agent = getattr(module, factory)
        train(agent, GROUP, "sequential", "smoke", 0, out=out, jobs=parallel, progress=False)
    return root


@pytest.mark.parametrize("name", FACTORIES)
def test_the_submission_is_complete_declares_what_is_observed_and_shows_that_the_agent_learns(
    submissions: Path, name: str
) -> None:
    submission = read(submissions / name, with_custom([GROUP]))
    assert submission.problems == ()
    assert submission.manifest and submission.manifest.observes == OBSERVES.get(name, Observes())
    if name in LEARN:
        episodes = results.episodes(submissions / name, groups=[GROUP])
        first = episodes[episodes["task"] == GROUP.task_ids[0]].groupby("stage")["return"].mean()
        assert first[1] > 1.2 * first[0]


def test_the_recurrent_state_is_kept_in_an_episode_and_cleared_where_one_starts(load_example: Load) -> None:
    env = make_vec(GROUP.tasks[0], 1)
    agent = load_example("recurrent").Recurrent(env.single_observation_space, env.single_action_space, 0)
    observations = np.ones((2, 11))
    first = agent.act(observations, Context(np.array([True, True])))
    second = agent.act(observations, Context(np.array([True, False])))
    np.testing.assert_allclose(second[0], first[0], atol=1e-6)
    assert not np.allclose(second[1], first[1], atol=1e-6)
