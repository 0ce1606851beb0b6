"""The command ``gym-extensions merge``, which joins submissions."""

from __future__ import annotations

import argparse
from pathlib import Path

from gym_extensions.baselines.submission.merge import merge
from gym_extensions.errors import reports_mistakes


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    command = argparse.ArgumentParser(
        prog="gym-extensions merge",
        description="Join submissions of one agent whose runs were trained on different machines. "
        "Runs, training curves, traces and policies are copied; the submissions stay as they are.",
    )
    command.add_argument("submissions", nargs="+", type=Path, metavar="FOLDER", help="a submission")
    command.add_argument("--out", required=True, type=Path, help="the new submission's folder")
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
    """Merges the submissions and returns the exit status."""
    options = parser().parse_args(argv)
    out = merge(options.submissions, options.out, groups=options.groups)
    print(f"The submission is in {out}.")
    return 0
