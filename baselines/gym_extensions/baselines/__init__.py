"""Train agents, or record policies, through the protocols of a task group and write their submissions.

Importing this package loads neither a simulator nor torch: agents and training are imported on first use.
``Card``, ``Observes``, ``Policy`` and ``OnnxPolicy``, which agents are written with, need no simulator.

Example:
    >>> from gym_extensions.baselines import train
    >>> train("random", "hopper-gravity", "single", "smoke", runs=0, out="submissions/mine")  # doctest: +SKIP
"""

import importlib
from typing import TYPE_CHECKING, Any

from gym_extensions.submissions.manifest import Observes

if TYPE_CHECKING:
    from gym_extensions.baselines.adapters.sb3 import sb3
    from gym_extensions.baselines.agent import Agent, Card, Context, Factory, Resumable
    from gym_extensions.baselines.record_policies import record
    from gym_extensions.baselines.train_agent import train
    from gym_extensions.baselines.training.jobs import Origin, Parallel
    from gym_extensions.baselines.training.progress import (
        BatchTrained,
        JobFailed,
        JobFinished,
        Monitor,
        StageStarted,
        StepsTrained,
        TaskEvaluated,
        TrainingStarted,
    )
    from gym_extensions.submissions.policies.mlp import Policy
    from gym_extensions.submissions.policies.onnx import OnnxPolicy

__all__ = [
    "Agent",
    "BatchTrained",
    "Card",
    "Context",
    "Factory",
    "JobFailed",
    "JobFinished",
    "Monitor",
    "Observes",
    "OnnxPolicy",
    "Origin",
    "Parallel",
    "Policy",
    "Resumable",
    "StageStarted",
    "StepsTrained",
    "TaskEvaluated",
    "TrainingStarted",
    "record",
    "sb3",
    "train",
]

MODULES = {
    **dict.fromkeys(("Agent", "Card", "Context", "Factory", "Resumable"), ".agent"),
    "OnnxPolicy": "gym_extensions.submissions.policies.onnx",
    "Origin": ".training.jobs",
    "Parallel": ".training.jobs",
    "Policy": "gym_extensions.submissions.policies.mlp",
    "record": ".record_policies",
    "sb3": ".adapters.sb3",
    "train": ".train_agent",
}
"""The module of each public name; the others are in ``training.progress``."""


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        module = importlib.import_module(MODULES.get(name, ".training.progress"), __name__)
    except ModuleNotFoundError as missing:
        from gym_extensions.baselines.algorithms import missing_extra

        extra = missing_extra(missing.name)
        if extra is None:
            raise
        raise ModuleNotFoundError(f"{name} needs {extra[0]}. {extra[1]}", name=extra[0]) from missing
    return getattr(module, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
