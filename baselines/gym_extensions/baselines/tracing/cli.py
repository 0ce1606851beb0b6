"""The command ``gym-extensions trace``, which writes the traces of a submission's audit sample."""

from __future__ import annotations

import argparse
from pathlib import Path

from gym_extensions.baselines.tracing.trace import trace
from gym_extensions.baselines.training.request import parse_runs
from gym_extensions.errors import reports_mistakes
from gym_extensions.rollouts.auditing.salt import require_salt


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    command = argparse.ArgumentParser(
        prog="gym-extensions trace",
        description="Write the traces of the audit sample that the logs of a submission and a salt select. "
        "Traces that were not kept are recorded again with the stored policies. Each trace has the digest in "
        "the log.",
    )
    command.add_argument("submission", type=Path, metavar="FOLDER", help="the submission's folder")
    command.add_argument(
        "--salt",
        metavar="HEX",
        help="64 hexadecimal digits that were fixed after the logs (default: the sample without a salt)",
    )
    command.add_argument(
        "--runs",
        help="only the traces of these runs, such as 0,1 or 0-4; the others then have none (default: all)",
    )
    command.add_argument(
        "--groups",
        action="append",
        default=[],
        metavar="FILE",
        help="also accept the custom group in this TOML file; may be repeated",
    )
    return command


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Writes the traces and returns the exit status."""
    options = parser().parse_args(argv)
    if options.salt is not None:
        require_salt(options.salt, "--salt")
    runs = parse_runs(options.runs) if options.runs else None
    counts = trace(options.submission, options.salt or "", groups=options.groups, runs=runs)
    for name, count in counts.items():
        print(f"{name}: {count} traces, {'drawn with the salt' if options.salt else 'drawn without a salt'}.")
    return 0
