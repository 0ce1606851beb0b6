"""PPO of Stable-Baselines3 with fresh networks for every task, from this project. The settings are those of ppo-tuned."""

from functools import partial

from gym_extensions.baselines.algorithms.ppo import make_reset

make = partial(make_reset, learning_rate=0.001, normalize_rewards=True)
