"""A recurrent agent in PyTorch: a GRU policy that infers the task from what it has observed.

    python examples/recurrent.py [BUDGET]

It asks for nothing. `context.episode_starts` says where an episode begins, and the state is cleared there. In
training it is cleared at the same moments, and gradients flow through the steps of a batch.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box
from torch import Tensor, nn

from gym_extensions.baselines import Card, Context, train
from gym_extensions.baselines.agent import Array

GROUP = "hopper-gravity"
SIGMA = 0.5
SETTINGS = {"sigma": SIGMA, "hidden": 32, "learning_rate": 3e-3, "epochs": 10, "gamma": 0.99, "clip": 0.2}


class Network(nn.Module):
    """Mean actions from observations and the state of a GRU."""

    def __init__(self, observations: int, actions: int) -> None:
        super().__init__()
        self.cell = nn.GRUCell(observations, int(SETTINGS["hidden"]))
        self.mean = nn.Linear(observations + int(SETTINGS["hidden"]), actions)

    def step(self, observations: Tensor, state: Tensor, starts: Tensor) -> tuple[Tensor, Tensor]:
        """Mean actions (n, a) and the next state (n, hidden); `starts` (n,) is 1 where an episode begins."""
        state = self.cell(observations, state * (1 - starts[:, None]))
        return self.mean(torch.cat([observations, state], dim=-1)), state


class Recurrent:
    """The agent. It learns by clipped policy gradients."""

    def __init__(self, observation_space: Box, action_space: Box, seed: int) -> None:
        torch.manual_seed(seed)  # the initial weights
        self.network = Network(observation_space.shape[0], action_space.shape[0])
        self.optimizer = torch.optim.Adam(self.network.parameters(), lr=SETTINGS["learning_rate"])
        self.learning = torch.Generator().manual_seed(seed)  # evaluation does not sample
        self.state = torch.zeros(0)  # of the present evaluation; not part of what is learned

    @torch.no_grad()
    def act(self, observations: Array, context: Context) -> Array:
        if context.episode_starts.all():  # an evaluation begins, perhaps of another number of environments
            self.state = self._no_state(len(observations))
        starts = as_tensor(context.episode_starts)
        mean, self.state = self.network.step(as_tensor(observations), self.state, starts)
        return mean.numpy()

    def learn(self, env: Any, steps: int) -> None:
        for _ in range(steps // env.batch_steps):
            observations, _ = env.reset()
            state, starts = self._no_state(env.num_envs), np.ones(env.num_envs, bool)
            rows = []
            for _ in range(env.batch_steps // env.num_envs):
                with torch.no_grad():
                    mean, state = self.network.step(as_tensor(observations), state, as_tensor(starts))
                actions = mean + SIGMA * torch.randn(mean.shape, generator=self.learning)
                next_observations, rewards, terminated, truncated, _ = env.step(actions.numpy())
                rows.append((observations, starts, actions, rewards))
                observations, starts = next_observations, terminated | truncated
                if starts.any():  # otherwise the environment would spend its next step on the reset
                    observations, _ = env.reset(options={"reset_mask": starts})
            self._update([as_tensor(np.stack(column)) for column in zip(*rows, strict=True)])

    def _update(self, batch: list[Tensor]) -> None:
        """Learns from arrays (time, num_envs, …)."""
        observations, starts, actions, rewards = batch
        returns, following = torch.empty_like(rewards), torch.zeros_like(rewards[0])
        for time in reversed(range(len(rewards))):
            returns[time] = following = rewards[time] + SETTINGS["gamma"] * following
            following = following * (1 - starts[time])  # nothing flows to the episode before
        weights = (returns - returns.mean()) / (returns.std() + 1e-8)
        before = self._log_probability(observations, starts, actions).detach()
        for _ in range(int(SETTINGS["epochs"])):
            ratio = (self._log_probability(observations, starts, actions) - before).exp()
            clipped = ratio.clamp(1 - SETTINGS["clip"], 1 + SETTINGS["clip"])
            loss = -torch.min(ratio * weights, clipped * weights).mean()
            self.optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            self.optimizer.step()

    def _log_probability(self, observations: Tensor, starts: Tensor, actions: Tensor) -> Tensor:
        """Up to a constant, of arrays (time, num_envs, …), through the states of all steps."""
        state, means = self._no_state(observations.shape[1]), []
        for observation, start in zip(observations, starts, strict=True):
            mean, state = self.network.step(observation, state, start)
            means.append(mean)
        return -0.5 * ((actions - torch.stack(means)) / SIGMA).pow(2).sum(-1)

    def _no_state(self, num_envs: int) -> Tensor:
        return torch.zeros(num_envs, int(SETTINGS["hidden"]))

    def card(self) -> Card:
        size = sum(parameter.numel() for parameter in self.network.parameters())
        return Card(
            "GRU policy",
            evaluation="deterministic",
            hyperparameters=SETTINGS,
            parameters=size,
            packages=("torch",),
        )

    def save(self, path: Path) -> None:
        networks = {"network": self.network.state_dict(), "optimizer": self.optimizer.state_dict()}
        torch.save(networks | {"learning": self.learning.get_state()}, path)

    def load(self, path: Path) -> None:
        saved = torch.load(path, weights_only=True)
        self.network.load_state_dict(saved["network"])
        self.optimizer.load_state_dict(saved["optimizer"])
        self.learning.set_state(saved["learning"])


def as_tensor(values: Array) -> Tensor:
    return torch.as_tensor(values, dtype=torch.float32)


if __name__ == "__main__":
    budget = sys.argv[1] if len(sys.argv) > 1 else "smoke"
    torch.set_num_threads(1)  # two are far slower where other programs use the cores
    train(Recurrent, GROUP, "sequential", budget, runs=0, out=f"trained/recurrent-{budget}")
