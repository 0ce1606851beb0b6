"""gym-extensions train: an agent through a protocol to a submission."""

from __future__ import annotations

import argparse
import errno
import re
import shlex
from pathlib import Path

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.training.display import shown
from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.errors import BenchError, reports_mistakes

EXTRA = ("tomli_w", "torch", "stable_baselines3")
"""What the extra ``baselines`` brings."""
FULL = (errno.ENOSPC, errno.EDQUOT)
"""The disk is full, or the user's part of it."""


def numbers(text: str) -> list[int]:
    """The numbers of ``0,2,5-7``; raises ``BenchError`` for anything else."""
    found: list[int] = []
    for part in text.split(","):
        span = re.fullmatch(r"\s*(\d+)\s*(?:-\s*(\d+)\s*)?", part)
        if span is None:
            hint = "Give numbers and ranges, as in 0,1 or 0-4."
            raise BenchError("bad-runs", f"{text!r} is no list of runs.", "--runs", hint)
        first, last = int(span[1]), int(span[2] or span[1])
        if last < first:
            hint = f"Write the smaller number first, as in {last}-{first}."
            raise BenchError("bad-runs", f"The range {part.strip()!r} is empty.", "--runs", hint)
        found += range(first, last + 1)
    return found


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    command = argparse.ArgumentParser(
        prog="gym-extensions train",
        description="Run an agent through a protocol and write its submission. "
        "Stopped and started again, it goes on at the last finished stage.",
    )
    command.add_argument("agent", help=f"{', '.join(algorithms.names())}, or module:factory of your own")
    command.add_argument(
        "--group", required=True, help="one or several, as in hopper-gravity,walker2d-gravity"
    )
    command.add_argument(
        "--protocol", default="sequential", help=f"of {','.join(PROTOCOLS)}; several by commas"
    )
    command.add_argument("--budget", default="1M", help=f"training steps a task: {', '.join(BUDGETS)}")
    command.add_argument("--runs", default="0", help="training seeds, as in 0,1 or 0-4")
    command.add_argument("--out", required=True, type=Path, help="the submission's folder")
    command.add_argument("--jobs", type=int, default=1, help="processes side by side (default 1)")
    command.add_argument(
        "--lanes", type=int, help="training environments side by side (default: the budget's)"
    )
    return command


def _train(asked: argparse.Namespace) -> None:
    from gym_extensions.baselines.train import train

    with shown() as screen:
        train(
            asked.agent,
            [name.strip() for name in asked.group.split(",")],
            [name.strip() for name in asked.protocol.split(",")],
            asked.budget,
            numbers(asked.runs),
            out=asked.out,
            jobs=asked.jobs,
            lanes=asked.lanes,
            listen=screen.hear,
            announce=screen.plan,
        )


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Trains, and tells where the submission lies."""
    asked = parser().parse_args(argv)
    if asked.jobs < 1:
        raise BenchError("bad-jobs", f"{asked.jobs} processes are too few.", "--jobs", "Give at least 1.")
    try:
        _train(asked)
    except KeyboardInterrupt:
        print("Stopped. The same command goes on from the last finished stage.")
        return 130
    except OSError as refusal:
        if refusal.errno not in FULL:
            raise
        hint = "Make room; the same command goes on from the last finished stage."
        raise BenchError("no-room", f"{refusal.strerror}.", str(asked.out), hint) from refusal
    except ModuleNotFoundError as missing:
        if missing.name not in EXTRA:
            raise
        hint = "Install the extra: pip install -c constraints.txt '.[baselines]'"
        raise BenchError("no-extra", f"Training needs {missing.name}.", hint=hint) from missing
    print(f"The submission is in {asked.out}. Look at it with: score {shlex.quote(str(asked.out))}")
    return 0
