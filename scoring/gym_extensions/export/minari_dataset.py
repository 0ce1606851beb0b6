"""Episodes of a verified policy as a Minari dataset. Runs the simulator, and needs the extra ``minari``."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from gym_extensions import policies
from gym_extensions.catalog.groups import GROUPS, TaskGroup, group
from gym_extensions.catalog.protocol import stages
from gym_extensions.envs import make
from gym_extensions.envs.fingerprinting import require_published_engine
from gym_extensions.errors import BenchError, require_known
from gym_extensions.scoring.pipeline import refuse_problems
from gym_extensions.submissions.layout import run_key
from gym_extensions.submissions.manifest import Manifest
from gym_extensions.submissions.policies.files import AnyPolicy
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import CLAIMED, level
from gym_extensions.versions import version

ROOT = "MINARI_DATASETS_PATH"
"""The environment variable that tells Minari where its datasets are."""
MAX_EPISODES = 10_000


def write_dataset(
    folder: Path,
    submission: Path,
    group_name: str,
    *,
    protocol: str = "sequential",
    run: int = 0,
    stage: int | None = None,
    task: str | None = None,
    episodes: int = 20,
) -> str:
    """Runs a policy on the seeds 0 to episodes − 1, writes them, and returns the id of the dataset.

    The folder becomes Minari's root of datasets. ``stage`` and ``task`` are the last ones where None.

    Raises:
        BenchError: Minari is not installed, something that is wanted does not exist, or no verification of
            the run as it is now has passed.
    """
    if not 1 <= episodes <= MAX_EPISODES:
        hint = f"Give 1 to {MAX_EPISODES}."
        raise BenchError("bad-episodes", f"The number is {episodes}.", "--episodes", hint)
    try:
        import minari
    except ImportError as error:
        hint = "Run: pip install 'gym-extensions[minari]'"
        raise BenchError("not-installed", "Minari is not installed.", "minari", hint) from error
    members = group(group_name)
    names = [each.name for each in members.tasks]
    name = names[-1] if task is None else task
    require_known("task", name, names, members.id)
    known = list(stages(protocol, len(names)))
    stage = known[-1] if stage is None else stage
    if stage not in known:
        hint = f"Choose {known[0]} to {known[-1]}."
        raise BenchError("unknown-stage", f"Stage {stage} does not exist.", "--stage", hint)
    manifest = _verified(submission, members, protocol, run)
    trained = name if protocol == "single" else None
    policy = policies.load(submission, members, run=run, stage=stage, task=trained, protocol=protocol)
    position = names.index(name)
    require_published_engine()
    title = submission.resolve().name
    dataset = f"gym-extensions/{name}/{title}-{protocol}-run{run}-stage{stage}-v0"
    with _root(folder), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it asks for an e-mail address and for a link to code
        env: Any = minari.DataCollector(make(members.tasks[position]))
        for seed in range(episodes):
            sampled = manifest.protocol.evaluation == "sampled"
            _play(env, policy, position, seed, np.random.default_rng(seed) if sampled else None)
        env.create_dataset(
            dataset,
            algorithm_name=title,
            author=", ".join(manifest.authors),
            requirements=[f"gym-extensions=={version('gym-extensions')}"],
            description=f"The policy of {run_key(group_name, protocol, run)}, stage {stage}, "
            f"on {members.tasks[position].id}, with the seeds 0 to {episodes - 1}.",
        )
        env.close()
    return dataset


def _play(env: Any, policy: AnyPolicy, position: int, seed: int, noise: np.random.Generator | None) -> None:
    """Runs one episode on the task at this position of its group."""
    space = env.action_space
    observation, _ = env.reset(seed=seed)
    policy.reset()
    ended = False
    while not ended:
        action = policy.act(np.asarray(observation)[None], noise, position)[0]
        action = np.clip(action.reshape(space.shape), space.low, space.high).astype(space.dtype)
        observation, _, terminated, truncated, _ = env.step(action)
        ended = terminated or truncated


def _verified(submission: Path, tasks: TaskGroup, protocol: str, run: int) -> Manifest:
    """The manifest of a submission that has the run, with a verification that passed."""
    found = read(submission, GROUPS, only=(tasks.name,))
    refuse_problems(submission, found.problems)
    group = found.groups.get(tasks.id)
    key = run_key(tasks.name, protocol, run)
    digests = group.digests(protocol) if group and protocol in group.logs else {}
    if key not in digests or found.manifest is None:
        raise BenchError("unknown-run", f"It has no run {key}.", str(submission), "Name one of its runs.")
    if level(found.review, {key: digests[key]}) == CLAIMED:
        command = f"gym-extensions verify {submission} --seeds HEX --write"
        hint = f"Run: {command}, with 40 to 128 random hexadecimal digits"
        raise BenchError("not-verified", f"No verification of {key} has passed.", str(submission), hint)
    return found.manifest


@contextmanager
def _root(folder: Path) -> Iterator[None]:
    """Minari's root of datasets is this folder."""
    before = os.environ.get(ROOT)
    os.environ[ROOT] = str(folder.resolve())
    try:
        yield
    finally:
        os.environ.pop(ROOT)
        if before is not None:
            os.environ[ROOT] = before
