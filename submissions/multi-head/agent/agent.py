"""TRPO from this project with an output layer per task."""

from gym_extensions.baselines.algorithms.multi_head import MultiHead

make = MultiHead
