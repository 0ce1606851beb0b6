"""A multi-head agent in PyTorch: shared hidden layers, and an output layer per task.

    python examples/multi_head.py [BUDGET]

It asks for the task in training and in evaluation, so its entries have separate boards. It learns in all
protocols: in `joint`, the environments of one batch run different tasks.
"""

import sys

import numpy as np
import torch
from gymnasium.spaces import Box
from torch import nn

from gym_extensions.baselines import Context, Observes, train
from gym_extensions.baselines.agent import Array, VectorEnv


class MultiHead:
    observes = Observes(task_in_training=True, task_in_evaluation=True)

    def __init__(self, observation_space: Box, action_space: Box, seed: int) -> None:
        torch.manual_seed(seed)  # the initial weights
        self.learning = torch.Generator().manual_seed(seed)
        inputs, actions, heads = observation_space.shape[0], action_space.shape[0], 30  # of the largest group
        output = (nn.Linear(64, heads * actions), nn.Unflatten(-1, (heads, actions)))
        self.network = nn.Sequential(nn.Linear(inputs, 64), nn.Tanh(), *output)
        self.optimizer = torch.optim.Adam(self.network.parameters(), lr=2e-3)

    @torch.no_grad()
    def act(self, observations: Array, context: Context) -> Array:
        return self.mean(observations, context.task).numpy()

    def mean(self, observations: Array, tasks: int | Array) -> torch.Tensor:
        heads = self.network(torch.as_tensor(observations, dtype=torch.float32))
        return heads[..., np.arange(len(heads)) if heads.ndim == 3 else ..., tasks, :]

    def learn(self, env: VectorEnv, steps: int) -> None:
        pass


if __name__ == "__main__":
    budget = sys.argv[1] if len(sys.argv) > 1 else "smoke"
    train(MultiHead, "hopper-gravity", "sequential", budget, runs=0, out=f"trained/multi-head-{budget}")
