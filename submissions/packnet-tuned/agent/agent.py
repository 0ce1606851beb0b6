"""TRPO with PackNet from this project. One rule of tuning chose the share of a task's budget after pruning."""

from functools import partial

from gym_extensions.baselines.algorithms.packnet import PackNet

make = partial(PackNet, retrain_share=0.4)
