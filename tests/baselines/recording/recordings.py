"""What tests of recording share: the call that records a stage, its error message, and the log."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Card, record
from gym_extensions.errors import BenchError

from ..conftest import QUICK_GROUP

GROUP = QUICK_GROUP.name
TASKS = QUICK_GROUP.tasks
CARD = Card("mine", evaluation="deterministic", parameters=7)


def zero(observations: Any) -> Any:
    """The policy that most tests record."""
    return np.zeros((len(observations), 7))


def push(observations: Any) -> Any:
    """Another policy."""
    return np.full((len(observations), 7), 0.5)


def record_stage(
    out: Path, policy: Any = zero, protocol: str = "sequential", **changes: Any
) -> dict[str, float]:
    """Records one stage of run 0, by default with the policy ``zero``."""
    arguments: dict[str, Any] = {"run": 0, "out": out, "budget": "smoke", "card": CARD} | changes
    return record(policy, QUICK_GROUP, protocol, **arguments)


def message(*arguments: Any, **changes: Any) -> str:
    """The error with which ``record_stage`` refuses these arguments."""
    with pytest.raises(BenchError) as error:
        record_stage(*arguments, **changes)
    return str(error.value)


def logged(out: Path, protocol: str = "sequential") -> list[dict[str, str]]:
    """The rows of the log."""
    with (out / GROUP / f"{protocol}.csv").open(newline="") as file:
        return list(csv.DictReader(file))
