"""Proximal policy optimization (Schulman et al. 2017) in PyTorch, with its own loop.

    python examples/ppo.py [BUDGET]

The agent has the two methods of every agent, `act` and `learn`. It observes neither tasks nor boundaries.
With `save` and `load` an interrupted run resumes; `policy` publishes the policy in the submission.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box
from torch import Tensor, nn

from gym_extensions.baselines import Card, train
from gym_extensions.baselines.adapters.sb3_policy import policy_layers
from gym_extensions.baselines.agent import Array
from gym_extensions.policies import Policy

GROUP = "hopper-gravity"
SETTINGS = {
    "learning_rate": 1e-3,
    "epochs": 10,
    "minibatches": 4,
    "gamma": 0.99,
    "gae_lambda": 0.95,
    "clip": 0.2,
}


class Network(nn.Module):
    """The mean and log σ of a Gaussian policy, and a value function."""

    def __init__(self, observations: int, actions: int) -> None:
        super().__init__()
        self.actor = nn.Sequential(nn.Linear(observations, 64), nn.Tanh(), nn.Linear(64, actions))
        self.critic = nn.Sequential(nn.Linear(observations, 64), nn.Tanh(), nn.Linear(64, 1), nn.Flatten(0))
        self.log_sigma = nn.Parameter(torch.full((actions,), -0.5))

    def log_probability(self, observations: Tensor, actions: Tensor) -> Tensor:
        """Of actions (n, a) in observations (n, o)."""
        policy = torch.distributions.Normal(self.actor(observations), self.log_sigma.exp())
        return policy.log_prob(actions).sum(-1)  # type: ignore[no-untyped-call]


class Ppo:
    """The agent."""

    def __init__(self, observation_space: Box, action_space: Box, seed: int) -> None:
        torch.manual_seed(seed)  # the initial weights
        self.network = Network(observation_space.shape[0], action_space.shape[0])
        self.optimizer = torch.optim.Adam(self.network.parameters(), lr=SETTINGS["learning_rate"])
        # Separate generators: evaluation does not change what is learned.
        self.acting = torch.Generator().manual_seed(2 * seed)
        self.learning = torch.Generator().manual_seed(2 * seed + 1)

    def act(self, observations: Array) -> Array:
        return self._sample(observations, self.acting).numpy()

    def learn(self, env: Any, steps: int) -> None:
        observations, _ = env.reset()
        for _ in range(steps // env.batch_steps):
            observations = self._learn_batch(env, observations)

    def _learn_batch(self, env: Any, observations: Array) -> Array:
        """Collects and learns one batch; returns the observations with which the next one begins."""
        rows = []
        for _ in range(env.batch_steps // env.num_envs):
            actions = self._sample(observations, self.learning)
            next_observations, rewards, terminated, truncated, _ = env.step(actions.numpy())
            ended = terminated | truncated
            rows.append((observations, actions, next_observations, rewards, terminated, ended))
            observations = next_observations
            if ended.any():  # otherwise the environment would spend its next step on the reset
                observations, _ = env.reset(options={"reset_mask": ended})
        self._update([as_tensor(np.stack(column)) for column in zip(*rows, strict=True)])
        return observations

    def _update(self, batch: list[Tensor]) -> None:
        """Learns from arrays (time, num_envs, …)."""
        observations, actions, nexts, rewards, terminated, ended = batch
        with torch.no_grad():
            values = self.network.critic(observations.flatten(0, 1)).view_as(rewards)
            next_values = self.network.critic(nexts.flatten(0, 1)).view_as(rewards) * (1 - terminated)
        errors = rewards + SETTINGS["gamma"] * next_values - values
        advantages, following = torch.empty_like(errors), torch.zeros_like(errors[0])
        for time in reversed(range(len(errors))):  # generalized advantage estimation
            decay = SETTINGS["gamma"] * SETTINGS["gae_lambda"] * (1 - ended[time])
            advantages[time] = following = errors[time] + decay * following
        targets = (advantages + values).flatten()
        weights = ((advantages - advantages.mean()) / (advantages.std() + 1e-8)).flatten()
        observations, actions = observations.flatten(0, 1), actions.flatten(0, 1)
        with torch.no_grad():
            before = self.network.log_probability(observations, actions)
        for _ in range(int(SETTINGS["epochs"])):
            order = torch.randperm(len(targets), generator=self.learning)
            for part in order.chunk(int(SETTINGS["minibatches"])):
                ratio = (self.network.log_probability(observations[part], actions[part]) - before[part]).exp()
                clipped = ratio.clamp(1 - SETTINGS["clip"], 1 + SETTINGS["clip"])
                policy_loss = -torch.min(ratio * weights[part], clipped * weights[part]).mean()
                value_loss = (self.network.critic(observations[part]) - targets[part]).pow(2).mean()
                self.optimizer.zero_grad()
                (policy_loss + 0.5 * value_loss).backward()
                nn.utils.clip_grad_norm_(self.network.parameters(), 0.5)
                self.optimizer.step()

    @torch.no_grad()
    def _sample(self, observations: Array, generator: torch.Generator) -> Tensor:
        mean: Tensor = self.network.actor(as_tensor(observations))
        return mean + self.network.log_sigma.exp() * torch.randn(mean.shape, generator=generator)

    def policy(self) -> Policy:
        zeros, log_sigma = np.zeros(len(self.network.log_sigma)), self.network.log_sigma.detach().numpy()
        layers = policy_layers(self.network.actor)
        return Policy(zeros, zeros + 1, **layers, head="gaussian", log_sigma=log_sigma)

    def card(self) -> Card:
        size = sum(parameter.numel() for parameter in self.network.parameters())
        return Card(
            "PPO in PyTorch",
            evaluation="sampled",
            hyperparameters=SETTINGS,
            parameters=size,
            packages=("torch",),
        )

    def save(self, path: Path) -> None:
        generators = {"acting": self.acting.get_state(), "learning": self.learning.get_state()}
        networks = {"network": self.network.state_dict(), "optimizer": self.optimizer.state_dict()}
        torch.save(networks | generators, path)

    def load(self, path: Path) -> None:
        saved = torch.load(path, weights_only=True)
        self.network.load_state_dict(saved["network"])
        self.optimizer.load_state_dict(saved["optimizer"])
        self.acting.set_state(saved["acting"])
        self.learning.set_state(saved["learning"])


def as_tensor(values: Array) -> Tensor:
    return torch.as_tensor(values, dtype=torch.float32)


if __name__ == "__main__":
    budget = sys.argv[1] if len(sys.argv) > 1 else "smoke"
    torch.set_num_threads(1)  # two are far slower where other programs use the cores
    train(Ppo, GROUP, "sequential", budget, runs=0, out=f"trained/ppo-{budget}")
