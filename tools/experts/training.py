"""Trains the runs of the table: TRPO, usually from a policy, with checkpoints at fixed intervals."""

import json
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.algorithms.trpo import REFERENCE, Trpo, TrpoSettings
from gym_extensions.baselines.trust_region.policy import EPSILON, Moments
from gym_extensions.baselines.trust_region.values import Collector, Transitions
from gym_extensions.catalog.tasks import task as published_task
from gym_extensions.envs import make_vec
from gym_extensions.references.experts import seed as seed_of
from gym_extensions.submissions.policies.mlp import Policy
from tools.experts.candidates import SCREENING, Workplace, write_policy
from tools.experts.recipes import Recipe, training_task

MOMENTS_COUNT = 1e6
"""Observations that the moments of a policy count as when it is trained further."""


class SeededEnv(gym.vector.VectorWrapper[Any, Any, Any]):
    """Environments with seeds of their first episodes, and weighted terms of the infos added to rewards."""

    def __init__(self, env: Any, seeds: list[int], bonus: dict[str, float]) -> None:
        super().__init__(env)
        self._seeds, self._bonus = seeds, bonus

    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        first, self._seeds = self._seeds, []
        env: Any = self.env  # seeds may be a list
        return env.reset(seed=first or None, options=options)

    def step(self, actions: Array) -> Any:
        space: Any = self.env.single_action_space
        clipped = np.clip(actions, space.low, space.high).astype(space.dtype)
        observations, rewards, terminated, truncated, infos = self.env.step(clipped)
        for name, weight in self._bonus.items():
            if name not in infos:  # every environment is being reset
                continue
            rewards = rewards + weight * np.where(infos[f"_{name}"], infos[name], 0.0)
        return observations, rewards, terminated, truncated, infos


class FurtherTrpo(Trpo):
    """TRPO that starts from a policy; the value function alone learns in the first batches."""

    value_batches = 0

    def start_from(self, policy: Policy) -> None:
        """Takes over the network, log σ and the moments of a policy of the same shapes."""
        parts = [part.ravel() for pair in zip(policy.weights, policy.biases, strict=True) for part in pair]
        sigma = np.full(len(policy.action_offset), -1.0, np.float32)
        if policy.log_sigma is not None and policy.log_sigma_weight is None:
            sigma = np.maximum(policy.log_sigma, self._settings.trust_region.least_log_sigma)
        self._theta = np.concatenate([*parts, sigma]).astype(np.float32)
        if policy.observation_mean is not None and policy.observation_scale is not None:
            squares = np.square(policy.observation_scale - EPSILON) * MOMENTS_COUNT
            self._moments = Moments(MOMENTS_COUNT, policy.observation_mean.astype(float), squares)

    def train(self, collector: Collector, steps: int, batch_steps: int) -> int:
        """Takes ``steps`` transitions in batches; returns how many were taken."""
        self._batch_steps = batch_steps
        return self._train(collector, steps)

    def _update(self, transitions: Transitions) -> None:
        kept = self._theta
        super()._update(transitions)
        if self.value_batches > 0:
            self.value_batches -= 1
            self._theta = kept


def trpo_settings(start: Policy | None) -> TrpoSettings:
    """The reference settings with the architecture of the policy to start from."""
    if start is None:
        return REFERENCE
    return replace(
        REFERENCE,
        hidden=tuple(weights.shape[1] for weights in start.weights[:-1]),
        activation=start.activation,
        tanh_mean="tanh" in (start.squash, start.output_activation),
        normalize_observations=start.observation_mean is not None,
    )


def train(work: Workplace, recipe: Recipe, seed: int, parent: str | None, command: str) -> Iterator[str]:
    """Trains a run, unless it is finished, and screens each checkpoint on the targets; yields lines."""
    name = f"{recipe.name}-seed{seed}"
    folder = work.folder / "policies" / name
    if (folder / "run.json").exists():
        return
    folder.mkdir(parents=True, exist_ok=True)
    targets = recipe.targets or recipe.tasks[-1:]
    seeds = [
        seed_of(published_task(targets[0]), "train", 100_000 * seed + index)
        for index in range(recipe.num_envs)
    ]
    envs = make_vec([training_task(each) for each in recipe.tasks], recipe.num_envs)
    env = SeededEnv(envs, seeds, dict(recipe.bonus))
    start = None if parent is None else work.policy(parent, training_task(recipe.tasks[-1]))
    spaces: Any = (env.single_observation_space, env.single_action_space)
    agent = FurtherTrpo(spaces[0], spaces[1], seed, trpo_settings(start))
    if start is not None:
        agent.start_from(start)
        agent.value_batches = recipe.value_batches
    collector = Collector(env)
    checkpoints: list[dict[str, Any]] = []
    steps, seconds = 0, 0.0
    while steps < recipe.steps:
        began = time.process_time()
        steps += agent.train(collector, min(recipe.checkpoint, recipe.steps - steps), recipe.batch_steps)
        seconds += time.process_time() - began
        write_policy(folder / f"{steps}.npz", agent.policy())
        row: dict[str, Any] = {"steps": steps, "cpu_seconds": round(seconds, 1)}
        for target in targets:
            seen = work.evaluate(f"{name}@{steps}", published_task(target), "select", SCREENING)
            row[target] = round(seen.mean, 1)
        yield f"{name} {row}"
        checkpoints.append(row)
        document = {
            "recipe": recipe.name,
            "seed": seed,
            "agent": "trpo",
            "parent": parent,
            "command": command,
            "tasks": recipe.tasks,
            "targets": targets,
            "checkpoints": checkpoints,
        }
        place = folder / ("run.json" if steps >= recipe.steps else "running.json")
        place.write_text(json.dumps(document, indent=1))
    (folder / "running.json").unlink(missing_ok=True)
    env.close()
