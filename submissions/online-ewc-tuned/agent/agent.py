"""TRPO with online EWC from this project. One rule of tuning chose the coefficient."""

from functools import partial

from gym_extensions.baselines.algorithms.continual import OnlineEwc

make = partial(OnlineEwc, coefficient=0.001)
