"""TRPO with an L2 penalty to the initial weights from this project. One rule of tuning chose the coefficient."""

from functools import partial

from gym_extensions.baselines.algorithms.continual import L2Init

make = partial(L2Init, coefficient=0.0001)
