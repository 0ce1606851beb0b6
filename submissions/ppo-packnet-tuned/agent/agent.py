"""PPO of Stable-Baselines3 with PackNet on its actor, from this project. The settings are those of ppo-tuned and packnet-tuned."""

from functools import partial

from gym_extensions.baselines.algorithms.additions import with_addition
from gym_extensions.baselines.algorithms.ppo import make as ppo

make = partial(with_addition(ppo, "packnet", retrain_share=0.4), learning_rate=0.001, normalize_rewards=True)
