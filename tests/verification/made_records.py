"""Records on Hopper that are made in a second: its bar is lowered, and the policies fall at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.references.experts import Step
from gym_extensions.scoring import records
from gym_extensions.scoring.records import CARD, Bar, Record
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.verification.verify_record import write_record

HISTORY = (Step("mine", "sac", 2_000_000, command="python train.py"),)


def lower_the_bar(patch: pytest.MonkeyPatch, floor: float = -1000.0) -> None:
    """Makes every task open, with this floor, in this process; no honest claim is refused by chance."""
    patch.setattr(records, "bar", lambda _: Bar(floor, floor_deviation=1.0))
    patch.setattr(records, "BELOW_CLAIM", 6.0)


def make_policy(inputs: int = 11, actions: int = 3, **changes: Any) -> Policy:
    """A policy that always does the same: it falls after about 20 steps."""
    arrays = {"weights": (np.zeros((inputs, actions)),), "biases": (np.ones(actions),)}
    return Policy(np.zeros(actions), np.ones(actions), **(arrays | changes))


def make_record(folder: Path, name: str = "mine", policy: Policy | None = None) -> Record:
    """A record on Hopper in a folder of records."""
    policy = policy or make_policy()
    path = write_record(policy, "Hopper", name, authors=["A. Author"], history=HISTORY, folder=folder)
    return Record(path)


def change_card(record: Record, old: str, new: str) -> Record:
    """The record with another text in its card."""
    text = record.path.read_text()
    assert old in text
    record.path.write_text(text.replace(old, new))
    return Record(record.path)


def claim_more(record: Record) -> Record:
    """The record with a claim of 10,000 more."""
    mean = record.card.measurement.mean
    return change_card(record, f'"mean": {mean!r}', f'"mean": {mean + 10_000.0!r}')


def record_path(folder: Path, task: str = "Hopper", name: str = "mine") -> Path:
    """The path of a record's card."""
    return folder / "records" / task / f"{name}{CARD}"
