"""From torch checkpoints to a submission: `python examples/checkpoints.py FOLDER`.

`pretend_to_train` stands for training code of your own: it writes a checkpoint per run and stage. The code
between the marked lines makes a submission from them, with the policies that verify it.
"""

import sys
from pathlib import Path

import numpy as np
import torch

from gym_extensions.baselines import Card, record
from gym_extensions.baselines.adapters.sb3_policy import policy_layers
from gym_extensions.policies import Policy

GROUP, RUNS = "hopper-gravity", (0, 1)
STAGES = 6  # the policy before training, and after each of the five tasks


def network() -> torch.nn.Sequential:
    """A policy for Hopper, from 11 observations to 3 actions."""
    return torch.nn.Sequential(torch.nn.Linear(11, 32), torch.nn.Tanh(), torch.nn.Linear(32, 3))


def pretend_to_train(folder: Path) -> None:
    """Writes `run<r>-stage<s>.pt` for every run and stage."""
    folder.mkdir(parents=True, exist_ok=True)
    for run in RUNS:
        torch.manual_seed(run)
        policy = network()
        for stage in range(STAGES):
            torch.save(policy.state_dict(), folder / f"run{run}-stage{stage}.pt")
            torch.nn.init.constant_(policy.get_parameter("2.bias"), 0.1 * (stage + 1))


# --- from checkpoints to a submission ---
def record_checkpoints(checkpoints: Path, out: Path) -> None:
    policy = network()
    size = sum(parameter.numel() for parameter in policy.parameters())
    card = Card("my algorithm", evaluation="deterministic", parameters=size)
    for run in RUNS:
        for stage in range(STAGES):
            policy.load_state_dict(torch.load(checkpoints / f"run{run}-stage{stage}.pt"))
            arrays = Policy(np.zeros(3), np.ones(3), **policy_layers(policy))  # not scaled, not squashed
            record(arrays, GROUP, "sequential", run=run, stage=stage, budget="smoke", card=card, out=out)


# --- end ---


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python examples/checkpoints.py FOLDER")
    root = Path(sys.argv[1])
    pretend_to_train(root / "checkpoints")
    record_checkpoints(root / "checkpoints", root / "mine")
