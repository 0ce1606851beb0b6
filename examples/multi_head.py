"""A multi-head agent in PyTorch: a shared hidden layer, and an output layer per task.

Run `python examples/multi_head.py`. The agent asks for the task in training and in evaluation, so its entries
have separate boards. It learns by PPO's clipped policy gradients without a value function, in all protocols: in
`joint`, the environments run different tasks.
"""

from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from gym_extensions.baselines import Context, Observes, train
from gym_extensions.baselines.agent import Array


class MultiHead:
    observes = Observes(task_in_training=True, task_in_evaluation=True)

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        torch.manual_seed(seed)  # the initial weights
        self.learning = torch.Generator().manual_seed(seed)  # evaluation does not sample
        inputs, outputs = observation_space.shape[0], action_space.shape[0]
        layers = (
            nn.Linear(inputs, 64),
            nn.Tanh(),
            nn.Linear(64, 30 * outputs),
            nn.Unflatten(-1, (30, outputs)),
        )
        self.network = nn.Sequential(*layers)  # 30 output layers, as many as the largest group has tasks
        self.optimizer = torch.optim.Adam(self.network.parameters(), lr=1e-3)

    def mean(self, observations: Array, tasks: Array) -> Tensor:
        """The mean actions (…, n, a) in observations (…, n, o) of n environments with these tasks."""
        heads: Tensor = self.network(torch.tensor(observations).float())
        return heads[..., np.arange(len(tasks)), tasks, :]

    @torch.no_grad()
    def act(self, observations: Array, context: Context) -> Array:
        return self.mean(observations, np.full(len(observations), context.task)).numpy()

    def learn(self, env: Any, steps: int) -> None:
        for _ in range(steps // env.batch_steps):
            rows, following = [], env.reset()[0]
            for _ in range(env.batch_steps // env.num_envs):
                noise = 0.5 * torch.randn(env.action_space.shape, generator=self.learning)
                actions = self.mean(following, env.env_tasks).detach() + noise
                rows.append((following, actions, noise, *env.step(actions.numpy())[:4]))
                following = rows[-1][3]
            self.update(env.env_tasks, [np.stack(column) for column in zip(*rows, strict=True)])

    def update(self, tasks: Array, batch: list[Array]) -> None:
        observations, actions, noise, _, returns, terminated, truncated = batch  # (time, n, …)
        for time in reversed(range(len(returns) - 1)):
            returns[time] += 0.99 * returns[time + 1] * ~(terminated | truncated)[time]
        weights = torch.tensor((returns - returns.mean(0)) / (returns.std(0) + 1e-8))
        weights[1:][(terminated | truncated)[:-1]] = 0  # the step after an end ignores its action
        for _ in range(20):
            distances = (torch.tensor(actions) - self.mean(observations, tasks)).square()
            ratio = (
                2 * (torch.tensor(noise).square() - distances).sum(-1)
            ).exp()  # of probabilities, σ = 0.5
            self.optimizer.zero_grad()
            torch.max(-ratio * weights, -ratio.clamp(0.8, 1.2) * weights).mean().backward()
            self.optimizer.step()


if __name__ == "__main__":
    train(MultiHead, "hopper-gravity", "sequential", "smoke", runs=0, out="trained/multi-head")
