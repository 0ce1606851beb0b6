"""What tests of ``gym-extensions train`` share: the words of the command, and a stand-in for training."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from gym_extensions.baselines import train_agent

OPTIONS = {"--groups": "hopper-gravity", "--budget": "smoke", "--out": "out"}


def command(agent: str, **changed: str) -> list[str]:
    """The words of the command with these options added or changed."""
    options = OPTIONS | {f"--{name.replace('_', '-')}": value for name, value in changed.items()}
    return ["train", agent, *(word for pair in options.items() for word in pair)]


def replace_train(monkeypatch: pytest.MonkeyPatch, function: Callable[..., Any]) -> None:
    """Makes the command call that function instead of training."""
    monkeypatch.setattr(train_agent, "train", function)
