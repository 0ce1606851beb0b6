"""TRPO with an L2 penalty from this project. One rule of tuning chose the coefficient."""

from functools import partial

from gym_extensions.baselines.algorithms.continual import L2

make = partial(L2, coefficient=0.0003)
