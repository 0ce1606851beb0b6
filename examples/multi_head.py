"""A multi-head agent in PyTorch: a shared hidden layer, and an output layer per task.

    python examples/multi_head.py [BUDGET]

It asks for the task in training and in evaluation, so its entries have separate boards. It learns by clipped
policy gradients in all protocols: in `joint`, the environments run different tasks.
"""

import sys

import numpy as np
import torch
from gymnasium.spaces import Box
from torch import Tensor, nn

from gym_extensions.baselines import Context, Observes, train
from gym_extensions.baselines.agent import Array, VectorEnv


class MultiHead:
    observes = Observes(task_in_training=True, task_in_evaluation=True)

    def __init__(self, observation_space: Box, action_space: Box, seed: int) -> None:
        torch.manual_seed(seed)  # the initial weights
        self.learning = torch.Generator().manual_seed(seed)  # evaluation does not sample
        self.heads = (30, action_space.shape[0])  # the largest group has 30 tasks
        hidden = nn.Sequential(nn.Linear(observation_space.shape[0], 64), nn.Tanh())
        self.network = nn.Sequential(hidden, nn.Linear(64, 30 * self.heads[1]), nn.Unflatten(-1, self.heads))
        self.optimizer = torch.optim.Adam(self.network.parameters(), lr=1e-3)

    def mean(self, observations: Array, tasks: Array) -> Tensor:
        """The mean actions (…, n, a) in observations (…, n, o) of n environments with these tasks."""
        return self.network(torch.tensor(observations).float())[..., range(len(tasks)), tasks, :]  # type: ignore[no-any-return]

    @torch.no_grad()
    def act(self, observations: Array, context: Context) -> Array:
        return self.mean(observations, np.full(len(observations), context.task)).numpy()

    def learn(self, env: VectorEnv, steps: int) -> None:
        for _ in range(steps // env.batch_steps):
            rows, observations = [], env.reset()[0]
            for _ in range(env.batch_steps // env.num_envs):
                mean = self.mean(observations, env.env_tasks).detach()
                actions = mean + 0.5 * torch.randn(mean.shape, generator=self.learning)
                following, rewards, terminated, truncated, _ = env.step(actions.numpy())
                rows.append((observations, actions.numpy(), rewards, terminated | truncated))
                observations = (
                    env.reset(options={"reset_mask": rows[-1][3]})[0] if rows[-1][3].any() else following
                )
            self.update(env.env_tasks, *map(np.stack, zip(*rows, strict=True)))

    def update(self, tasks: Array, observations: Array, actions: Array, rewards: Array, ended: Array) -> None:
        for t in reversed(range(len(rewards) - 1)):  # from rewards to returns, arrays (time, n)
            rewards[t] += 0.99 * rewards[t + 1] * ~ended[t]
        weights = torch.tensor((rewards - rewards.mean(0)) / (rewards.std(0) + 1e-8))
        for epoch in range(20):
            logs = -2 * (torch.tensor(actions) - self.mean(observations, tasks)).square().sum(
                -1
            )  # 1 / 2σ² = 2
            before = logs.detach() if epoch == 0 else before
            ratio = (logs - before).exp()
            self.optimizer.zero_grad()
            (-torch.min(ratio * weights, ratio.clamp(0.8, 1.2) * weights).mean()).backward()  # type: ignore[no-untyped-call]
            self.optimizer.step()


if __name__ == "__main__":
    budget = sys.argv[1] if len(sys.argv) > 1 else "smoke"
    train(MultiHead, "hopper-gravity", "sequential", budget, runs=0, out=f"trained/multi-head-{budget}")
