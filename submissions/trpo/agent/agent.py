"""The reference agent of this project."""

from gym_extensions.baselines.algorithms.trpo import Trpo

make = Trpo
