"""A unit as a piece of work for a process."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Factory
from gym_extensions.baselines.training.jobs import Unit
from gym_extensions.baselines.training.progress import Finished
from gym_extensions.baselines.training.runner import Listener, Settings, run_unit


@dataclass(frozen=True)
class UnitWork:
    """A unit and what it takes to run it."""

    unit: Unit
    agent: str | Factory
    settings: Settings
    out: Path

    def run(self, listen: Listener) -> list[Finished]:
        """Every stage of the unit, finished."""
        return run_unit(self.unit, made(self.agent), self.settings, self.out, listen)


def made(agent: str | Factory) -> Factory:
    """The factory that is named, or given."""
    return algorithms.factory(agent) if isinstance(agent, str) else agent


def name_of(agent: str | Factory) -> str:
    """What an agent without a card is called: by its factory, or its module where that is called ``make``."""
    if isinstance(agent, str):
        module, _, attribute = agent.partition(":")
    else:
        module, attribute = type(agent).__module__, getattr(agent, "__name__", type(agent).__name__)
    return attribute if attribute not in ("", "make") else module.rpartition(".")[2]
