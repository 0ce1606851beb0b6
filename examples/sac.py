"""Soft actor-critic (Haarnoja et al. 2018) in PyTorch, small.

    python examples/sac.py [BUDGET]

Its buffer keeps the last 200,000 transitions, of all tasks. They are part of what `save` writes, so an
interrupted run resumes with the same results. Actions are the mean in evaluation, and samples in training.
"""

import sys
from pathlib import Path

import numpy as np
import torch
from gymnasium.spaces import Box
from torch import Tensor, nn

from gym_extensions.baselines import Card, train
from gym_extensions.baselines.adapters.sb3_policy import policy_layers
from gym_extensions.baselines.agent import Array, VectorEnv
from gym_extensions.policies import Policy

GROUP = "hopper-gravity"
SETTINGS = {
    "learning_rate": 1e-3,
    "gamma": 0.99,
    "tau": 0.005,
    "batch": 128,
    "warm_up": 100,
    "steps_per_update": 1,
    "buffer": 200_000,
}


class Actor(nn.Module):
    """A Gaussian policy whose sample is squashed by tanh."""

    def __init__(self, observations: int, actions: int) -> None:
        super().__init__()
        self.hidden = nn.Sequential(nn.Linear(observations, 64), nn.ReLU(), nn.Linear(64, 64), nn.ReLU())
        self.mean, self.log_sigma = nn.Linear(64, actions), nn.Linear(64, actions)

    def forward(self, observations: Tensor) -> Tensor:
        """The mean before tanh."""
        return self.mean(self.hidden(observations))

    def sample(self, observations: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor]:
        """Actions in [−1, 1] (n, a), and their log-probabilities (n,)."""
        hidden = self.hidden(observations)
        mean, log_sigma = self.mean(hidden), self.log_sigma(hidden).clamp(-5, 2)
        noise = torch.randn(mean.shape, generator=generator)
        actions = torch.tanh(mean + log_sigma.exp() * noise)
        density = -0.5 * noise**2 - log_sigma - 0.5 * np.log(2 * np.pi) - torch.log(1 - actions**2 + 1e-6)
        return actions, density.sum(-1)


class Critic(nn.Module):
    """The value of an action in an observation, estimated twice; the lower estimate counts."""

    def __init__(self, inputs: int) -> None:
        super().__init__()
        hidden = [(nn.Linear(inputs, 64), nn.ReLU(), nn.Linear(64, 64), nn.ReLU()) for _ in range(2)]
        self.estimates = nn.ModuleList(nn.Sequential(*layers, nn.Linear(64, 1)) for layers in hidden)

    def forward(self, observations: Tensor, actions: Tensor) -> Tensor:
        """Both estimates (2, n)."""
        inputs = torch.cat([observations, actions], dim=-1)
        return torch.stack([estimate(inputs).squeeze(-1) for estimate in self.estimates])


class Sac:
    """The agent."""

    def __init__(self, observation_space: Box, action_space: Box, seed: int) -> None:
        torch.manual_seed(seed)  # the initial weights
        observations, actions = observation_space.shape[0], action_space.shape[0]
        self.actor = Actor(observations, actions)
        self.critic, self.target = Critic(observations + actions), Critic(observations + actions)
        self.target.load_state_dict(self.critic.state_dict())
        self.log_temperature = nn.Parameter(torch.zeros(()))
        rate = SETTINGS["learning_rate"]
        self.actor_optimizer = torch.optim.Adam(
            [*self.actor.parameters(), self.log_temperature], lr=rate, fused=True
        )
        self.critic_optimizer = torch.optim.Adam(self.critic.parameters(), lr=rate, fused=True)
        self.learning = torch.Generator().manual_seed(seed)  # evaluation does not sample
        self.middle = (action_space.high + action_space.low) / 2
        self.half = (action_space.high - action_space.low) / 2
        sizes = {
            "observation": observations,
            "action": actions,
            "next": observations,
            "reward": 1,
            "terminated": 1,
        }
        self.buffer = {name: torch.zeros(int(SETTINGS["buffer"]), size) for name, size in sizes.items()}
        self.stored = 0  # transitions so far; the oldest are overwritten

    @torch.no_grad()
    def act(self, observations: Array) -> Array:
        return self.middle + self.half * torch.tanh(self.actor(as_tensor(observations))).numpy()

    def learn(self, env: VectorEnv, steps: int) -> None:
        observations, _ = env.reset()
        for step in range(steps // env.num_envs):
            with torch.no_grad():
                actions, _ = self.actor.sample(as_tensor(observations), self.learning)
            moved = env.step(self.middle + self.half * actions.numpy())
            next_observations, rewards, terminated, truncated, _ = moved
            self._store(observations, actions, next_observations, rewards[:, None], terminated[:, None])
            observations, ended = next_observations, terminated | truncated
            if ended.any():  # otherwise the environment would spend its next step on the reset
                observations, _ = env.reset(options={"reset_mask": ended})
            if self.stored > SETTINGS["warm_up"] and step % SETTINGS["steps_per_update"] == 0:
                self._update()

    def _store(self, *values: Array | Tensor) -> None:
        rows = torch.arange(self.stored, self.stored + len(values[0])) % len(self.buffer["reward"])
        for column, value in zip(self.buffer.values(), values, strict=True):
            column[rows] = as_tensor(value)
        self.stored += len(rows)

    def _update(self) -> None:
        """One gradient step of the critic, the actor and the temperature."""
        filled = min(self.stored, len(self.buffer["reward"]))
        rows = torch.randint(filled, (int(SETTINGS["batch"]),), generator=self.learning)
        observations, actions, nexts, rewards, terminated = (column[rows] for column in self.buffer.values())
        temperature = self.log_temperature.exp().detach()
        with torch.no_grad():
            next_actions, next_densities = self.actor.sample(nexts, self.learning)
            values = self.target(nexts, next_actions).amin(0) - temperature * next_densities
            targets = rewards.squeeze(-1) + SETTINGS["gamma"] * (1 - terminated.squeeze(-1)) * values
        critic_loss = (self.critic(observations, actions) - targets).pow(2).mean()
        descend(self.critic_optimizer, critic_loss)
        samples, densities = self.actor.sample(observations, self.learning)
        actor_loss = (temperature * densities - self.critic(observations, samples).amin(0)).mean()
        entropy_gap = (
            densities.detach() - samples.shape[1]
        ).mean()  # the target entropy is −(number of actions)
        descend(self.actor_optimizer, actor_loss - self.log_temperature * entropy_gap)
        with torch.no_grad():
            for slow, fast in zip(self.target.parameters(), self.critic.parameters(), strict=True):
                slow.lerp_(fast, SETTINGS["tau"])

    def policy(self) -> Policy:
        layers = policy_layers(self.actor.hidden, self.actor.mean)
        return Policy(self.middle, self.half, **layers, squash="tanh")

    def card(self) -> Card:
        size = sum(part.numel() for module in (self.actor, self.critic) for part in module.parameters())
        return Card(
            "SAC in PyTorch",
            evaluation="deterministic",
            hyperparameters=SETTINGS,
            stored_steps=int(SETTINGS["buffer"]),
            parameters=size + 1,
            packages=("torch",),
        )

    def save(self, path: Path) -> None:
        """Writes networks, optimizers, buffer and generator."""
        numbers = {"stored": self.stored, "temperature": self.log_temperature.data}
        states = {name: part.state_dict() for name, part in self._parts().items()}
        filled = {name: column[: self.stored].clone() for name, column in self.buffer.items()}
        torch.save(states | numbers | {"buffer": filled, "learning": self.learning.get_state()}, path)

    def load(self, path: Path) -> None:
        saved = torch.load(path, weights_only=True)
        for name, part in self._parts().items():
            part.load_state_dict(saved[name])
        for name, column in saved["buffer"].items():
            self.buffer[name][: len(column)] = column
        self.stored = saved["stored"]
        self.log_temperature.data = saved["temperature"]
        self.learning.set_state(saved["learning"])

    def _parts(self) -> dict[str, nn.Module | torch.optim.Optimizer]:
        networks = {"actor": self.actor, "critic": self.critic, "target": self.target}
        return networks | {"actor_optimizer": self.actor_optimizer, "critic_optimizer": self.critic_optimizer}


def descend(optimizer: torch.optim.Optimizer, loss: Tensor) -> None:
    optimizer.zero_grad()
    loss.backward()  # type: ignore[no-untyped-call]
    optimizer.step()


def as_tensor(values: Array | Tensor) -> Tensor:
    return torch.as_tensor(values, dtype=torch.float32)


if __name__ == "__main__":
    budget = sys.argv[1] if len(sys.argv) > 1 else "smoke"
    torch.set_num_threads(1)  # two are far slower where other programs use the cores
    train(Sac, GROUP, "sequential", budget, runs=0, out=f"trained/sac-{budget}")
