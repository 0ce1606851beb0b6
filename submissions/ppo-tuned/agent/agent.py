"""PPO of Stable-Baselines3 from this project. One rule of tuning chose the learning rate and the normalization of rewards."""

from functools import partial

from gym_extensions.baselines.algorithms.ppo import make as ppo

make = partial(ppo, learning_rate=0.001, normalize_rewards=True)
