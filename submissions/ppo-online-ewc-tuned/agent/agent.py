"""PPO of Stable-Baselines3 with online EWC on its actor, from this project. The settings are those of ppo-tuned and online-ewc-tuned."""

from functools import partial

from gym_extensions.baselines.algorithms.additions import with_addition
from gym_extensions.baselines.algorithms.ppo import make as ppo

make = partial(with_addition(ppo, "online-ewc", coefficient=0.001), learning_rate=0.001, normalize_rewards=True)
