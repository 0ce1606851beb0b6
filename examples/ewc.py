"""Elastic weight consolidation (Kirkpatrick et al. 2017) on a policy gradient, in PyTorch.

    python examples/ewc.py [BUDGET]

At the end of a task the agent stores its parameters and their Fisher information. Later tasks pay for moving
parameters that mattered. It asks for `boundaries`, because later calls of `learn` do something else than the
first one; the manifest says so.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box
from torch import Tensor, nn

from gym_extensions.baselines import Card, Observes, train
from gym_extensions.baselines.agent import Array

GROUP = "hopper-gravity"
SIGMA = 0.5
SETTINGS = {"sigma": SIGMA, "penalty": 100.0, "learning_rate": 1e-3, "epochs": 20, "gamma": 0.99, "clip": 0.2}


class Ewc:
    """A Gaussian policy, learned by clipped policy gradients with a quadratic penalty on forgetting."""

    observes = Observes(boundaries=True)

    def __init__(self, observation_space: Box, action_space: Box, seed: int) -> None:
        torch.manual_seed(seed)  # the initial weights
        inputs, outputs = observation_space.shape[0], action_space.shape[0]
        self.actor = nn.Sequential(nn.Linear(inputs, 64), nn.Tanh(), nn.Linear(64, outputs))
        self.optimizer = torch.optim.Adam(self.actor.parameters(), lr=SETTINGS["learning_rate"])
        self.learning = torch.Generator().manual_seed(seed)  # evaluation does not sample
        size = sum(parameter.numel() for parameter in self.actor.parameters())
        self.anchors = torch.zeros(0, size)  # the parameters at the end of each task, (tasks, size)
        self.fishers = torch.zeros(0, size)  # how much each parameter mattered there

    @torch.no_grad()
    def act(self, observations: Array) -> Array:
        return self.actor(as_tensor(observations)).numpy()

    def learn(self, env: Any, steps: int) -> None:
        observations, _ = env.reset()
        for _ in range(steps // env.batch_steps):
            rows = []
            for _ in range(env.batch_steps // env.num_envs):
                mean = torch.from_numpy(self.act(observations))
                actions = mean + SIGMA * torch.randn(mean.shape, generator=self.learning)
                next_observations, rewards, terminated, truncated, _ = env.step(actions.numpy())
                ended = terminated | truncated
                rows.append((observations, actions, rewards, ended))
                observations = next_observations
                if ended.any():  # otherwise the environment would spend its next step on the reset
                    observations, _ = env.reset(options={"reset_mask": ended})
            batch = [as_tensor(np.stack(column)) for column in zip(*rows, strict=True)]
            self._update(*batch)
        if env.stage < env.num_tasks:
            self._consolidate(batch[0].flatten(0, 1))

    def _update(self, observations: Tensor, actions: Tensor, rewards: Tensor, ended: Tensor) -> None:
        """Learns from arrays (time, num_envs, …)."""
        returns, following = torch.empty_like(rewards), torch.zeros_like(rewards[0])
        for time in reversed(range(len(rewards))):
            returns[time] = following = rewards[time] + SETTINGS["gamma"] * (1 - ended[time]) * following
        weights = (returns - returns.mean()) / (returns.std() + 1e-8)
        before = self._log_probability(observations, actions).detach()
        for _ in range(int(SETTINGS["epochs"])):
            ratio = (self._log_probability(observations, actions) - before).exp()
            clipped = ratio.clamp(1 - SETTINGS["clip"], 1 + SETTINGS["clip"])
            loss = -torch.min(ratio * weights, clipped * weights).mean() + self._forgetting()
            self.optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            self.optimizer.step()

    def _forgetting(self) -> Tensor:
        """λ / 2 · Σ F (θ − θ*)², summed over the earlier tasks; 0 in the first one."""
        parameters = nn.utils.parameters_to_vector(self.actor.parameters())
        return SETTINGS["penalty"] / 2 * (self.fishers * (parameters - self.anchors) ** 2).sum()

    def _consolidate(self, observations: Tensor) -> None:
        """Stores the parameters and the diagonal of their Fisher information in observations (n, o).

        The Fisher information of a Gaussian policy with fixed σ is the mean square of the gradients of its
        mean actions, divided by σ².
        """
        fisher = torch.zeros(self.anchors.shape[1])
        for observation in observations:
            for mean in self.actor(observation):
                gradients = torch.autograd.grad(mean, list(self.actor.parameters()), retain_graph=True)
                fisher += nn.utils.parameters_to_vector(gradients) ** 2 / SIGMA**2 / len(observations)
        parameters = nn.utils.parameters_to_vector(self.actor.parameters()).detach()
        self.anchors = torch.cat([self.anchors, parameters[None]])
        self.fishers = torch.cat([self.fishers, fisher[None]])

    def _log_probability(self, observations: Tensor, actions: Tensor) -> Tensor:
        """Up to a constant, of arrays (time, num_envs, …)."""
        errors = (actions - self.actor(observations)) / SIGMA
        return -0.5 * errors.pow(2).sum(-1)

    def card(self) -> Card:
        size = self.anchors.shape[1] + 2 * self.anchors.numel()
        return Card(
            "EWC in PyTorch",
            evaluation="deterministic",
            hyperparameters=SETTINGS,
            parameters=size,
            packages=("torch",),
        )

    def save(self, path: Path) -> None:
        networks = {"actor": self.actor.state_dict(), "optimizer": self.optimizer.state_dict()}
        tensors = {"anchors": self.anchors, "fishers": self.fishers, "learning": self.learning.get_state()}
        torch.save(networks | tensors, path)

    def load(self, path: Path) -> None:
        saved = torch.load(path, weights_only=True)
        self.actor.load_state_dict(saved["actor"])
        self.optimizer.load_state_dict(saved["optimizer"])
        self.anchors, self.fishers = saved["anchors"], saved["fishers"]
        self.learning.set_state(saved["learning"])


def as_tensor(values: Array) -> Tensor:
    return torch.as_tensor(values, dtype=torch.float32)


if __name__ == "__main__":
    budget = sys.argv[1] if len(sys.argv) > 1 else "smoke"
    train(Ewc, GROUP, "sequential", budget, runs=0, out=f"trained/ewc-{budget}")
