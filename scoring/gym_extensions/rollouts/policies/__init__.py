"""Policies as plain arrays: a network, its normalization and its distribution, evaluated in numpy."""

from gym_extensions.rollouts.policies.policy import Policy

__all__ = ["Policy"]
