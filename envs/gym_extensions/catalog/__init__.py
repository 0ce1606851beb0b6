"""Describes the benchmark as data, with bodies, variations, tasks, groups, budgets and the protocol.

Loads no simulator.
"""
