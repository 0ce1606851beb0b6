"""A multi-head agent in PyTorch: a shared hidden layer, and an output layer per task.

Run `python examples/multi_head.py`. The agent asks for the task in training and in evaluation, so its
submissions have separate boards. It learns by PPO's clipped policy gradients without a value function. In the
protocol `joint`, the environments run different tasks.
"""

from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from gym_extensions.baselines import Card, Context, Observes, train
from gym_extensions.baselines.agent import Array


class MultiHead:
    observes = Observes(task_in_training=True, task_in_evaluation=True)

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        torch.manual_seed(seed)  # the initial weights
        self.learning = torch.Generator().manual_seed(seed)  # evaluation does not sample
        inputs, outputs = observation_space.shape[0], action_space.shape[0]
        # 30 output layers, as many as the largest group has tasks.
        self.network = nn.Sequential(nn.Linear(inputs, 64), nn.Tanh(), nn.Linear(64, 30 * outputs))
        self.optimizer = torch.optim.Adam(self.network.parameters(), lr=1e-3)

    def mean(self, observations: Array, tasks: Array) -> Tensor:
        """The mean actions (…, n, a) in observations (…, n, o) of n environments with these tasks."""
        heads: Tensor = self.network(torch.tensor(observations).float()).unflatten(-1, (30, -1))
        return heads[..., np.arange(len(tasks)), tasks, :]

    def act(self, observations: Array, context: Context) -> Array:
        return self.mean(observations, np.full(len(observations), context.task)).detach().numpy()

    def learn(self, env: Any, steps: int) -> None:
        for _ in range(steps // env.batch_steps):
            rows, following = [], env.reset()[0]
            for _ in range(env.batch_steps // env.num_envs):
                noise = 0.5 * torch.randn(env.action_space.shape, generator=self.learning)
                actions = self.mean(following, env.env_tasks).detach() + noise
                rows.append((following, actions, noise, *env.step(actions.numpy())[:4]))
                following = rows[-1][3]
            # Arrays (time, n, …).
            states, tried, noises, _, returns, terminated, truncated = map(np.stack, zip(*rows, strict=True))
            for time in reversed(range(len(returns) - 1)):
                returns[time] += 0.99 * returns[time + 1] * ~(terminated | truncated)[time]
            weights = torch.tensor((returns - returns.mean(0)) / (returns.std(0) + 1e-8))
            weights[1:][(terminated | truncated)[:-1]] = 0  # the step after an end ignores its action
            for _ in range(20):
                errors = torch.tensor(tried) - self.mean(states, env.env_tasks)
                # Of the probabilities of the actions now and before, with σ = 0.5.
                ratio = (2 * (torch.tensor(noises) ** 2 - errors**2).sum(-1)).exp()
                self.optimizer.zero_grad()
                torch.max(-ratio * weights, -ratio.clamp(0.8, 1.2) * weights).mean().backward()  # type: ignore[no-untyped-call]
                self.optimizer.step()

    def card(self) -> Card:
        return Card(
            "Multi-head policy gradient in PyTorch",
            evaluation="deterministic",
            hyperparameters={
                "learning_rate": 1e-3,
                "sigma": 0.5,
                "discount": 0.99,
                "clip": 0.2,
                "updates": 20,
            },
            parameters=sum(parameter.numel() for parameter in self.network.parameters()),
            packages=("torch",),
        )


if __name__ == "__main__":
    train(MultiHead, "hopper-gravity", "sequential", "smoke", runs=0, out="trained/multi-head")
