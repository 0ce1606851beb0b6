"""Episodes of a published policy as a Minari dataset: `python examples/minari_dataset.py SUBMISSION GROUP`.

It runs the policy after the last stage on the last task of the group, and needs
`pip install 'minari[create,hdf5]'`. Minari writes below `~/.minari`, or where MINARI_DATASETS_PATH says.
"""

import sys
import tomllib
from pathlib import Path

import minari
import numpy as np

from gym_extensions import policies
from gym_extensions.catalog.groups import group
from gym_extensions.envs import make


def write(submission: str, group_name: str, run: int = 0, episodes: int = 20) -> str:
    """Runs the policy on the seeds 0 to episodes − 1, writes them, and returns the id of the dataset."""
    tasks = group(group_name).tasks
    policy = policies.load(submission, group_name, run=run, stage=len(tasks))
    manifest = tomllib.loads((Path(submission) / "submission.toml").read_text(encoding="utf-8"))
    is_sampled = manifest["protocol"]["evaluation"] == "sampled"
    env = minari.DataCollector(make(tasks[-1]))
    space = env.action_space
    for seed in range(episodes):
        observation, _ = env.reset(seed=seed)
        policy.reset()
        noise, ended = np.random.default_rng(seed) if is_sampled else None, False
        while not ended:
            action = policy.act(np.asarray(observation)[None], noise, len(tasks) - 1)[0]
            action = np.clip(action.reshape(space.shape), space.low, space.high).astype(space.dtype)
            observation, _, terminated, truncated, _ = env.step(action)
            ended = terminated or truncated
    name = Path(submission).resolve().name
    dataset = f"gym-extensions/{tasks[-1].name}/{name}-run{run}-v0"
    env.create_dataset(dataset, algorithm_name=name, description=f"{group_name}, seeds 0 to {episodes - 1}")
    env.close()
    return dataset


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: python examples/minari_dataset.py SUBMISSION GROUP")
    print(write(sys.argv[1], sys.argv[2]))
