"""From torch checkpoints to a submission: `python examples/checkpoints.py FOLDER`.

`pretend_to_train` stands for training code of your own: it writes one checkpoint per run and stage. Everything
between the two marked lines makes a submission from them that can be scored and replayed.
"""

import sys
from pathlib import Path

import torch

RUNS, STAGES = (0, 1), 6  # the untrained policy, and the policy after each of the five tasks


def network() -> torch.nn.Module:
    """A policy for Hopper: 11 observations, 3 actions."""
    return torch.nn.Sequential(torch.nn.Linear(11, 32), torch.nn.Tanh(), torch.nn.Linear(32, 3))


def pretend_to_train(folder: Path) -> None:
    """Writes `run<r>-stage<s>.pt` for every run and stage."""
    folder.mkdir(parents=True, exist_ok=True)
    for run in RUNS:
        torch.manual_seed(run)
        policy = network()
        for stage in range(STAGES):
            torch.save(policy.state_dict(), folder / f"run{run}-stage{stage}.pt")
            with torch.no_grad():
                policy[2].bias += 0.1


# begin: own code
def record_checkpoints(checkpoints: Path, out: Path) -> None:
    from gym_extensions.baselines import Card, record

    policy = network()
    card = Card("my algorithm", evaluation="deterministic", parameters=sum(p.numel() for p in policy.parameters()))

    @torch.no_grad()
    def act(observations):
        return policy(torch.as_tensor(observations, dtype=torch.float32)).numpy()

    for run in RUNS:
        for stage in range(STAGES):
            policy.load_state_dict(torch.load(checkpoints / f"run{run}-stage{stage}.pt"))
            record(act, "hopper-gravity", "sequential", run=run, stage=stage, out=out, budget="smoke", card=card)
# end: own code


if __name__ == "__main__":
    root = Path(sys.argv[1])
    pretend_to_train(root / "checkpoints")
    record_checkpoints(root / "checkpoints", root / "mine")
