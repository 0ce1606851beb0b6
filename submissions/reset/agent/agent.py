"""TRPO from this project that starts every task with a new policy."""

from gym_extensions.baselines.algorithms.trpo import Reset

make = Reset
