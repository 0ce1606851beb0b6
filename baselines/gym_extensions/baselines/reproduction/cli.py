"""The command ``gym-extensions reproduce``, which retrains one run of a submission."""

from __future__ import annotations

import argparse
from pathlib import Path

from gym_extensions.baselines.reproduction.draw import LoggedRun, draw_run
from gym_extensions.baselines.reproduction.reproduce import Reproduction, reproduce
from gym_extensions.baselines.submission import manifest
from gym_extensions.baselines.training.request import require_positive
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.errors import BenchError, reports_mistakes


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    command = argparse.ArgumentParser(
        prog="gym-extensions reproduce",
        description="Retrain one run of a submission in a temporary folder and compare it with the log. The "
        "exit status is 0 if the rows are the same bytes or all mean returns agree within evaluation noise, "
        "else 1. The agent's code is imported and run.",
    )
    command.add_argument("entry", type=Path, metavar="ENTRY", help="the submission's folder")
    drawn = command.add_mutually_exclusive_group(required=True)
    drawn.add_argument("--group", help="a group's name, or the TOML file of a custom group")
    drawn.add_argument(
        "--salt", help="draw the group, protocol and run from this salt (gym-extensions ledger salt ENTRY)"
    )
    command.add_argument(
        "--groups",
        action="append",
        default=[],
        metavar="FILE",
        help="the custom group in this TOML file, which the salt may draw; may be repeated",
    )
    command.add_argument("--protocol", choices=PROTOCOLS, help="the protocol (default: sequential)")
    command.add_argument("--run", type=int, help="the training seed (default: 0)")
    command.add_argument(
        "--agent",
        help="the agent of the submission, as module:factory (default: the reference agent that the manifest "
        "names)",
    )
    command.add_argument("--jobs", type=int, default=1, help="worker processes (default: 1)")
    command.add_argument("--quiet", action="store_true", help="do not show the progress")
    return command


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Retrains, prints the comparison and returns the exit status."""
    options = parser().parse_args(argv)
    require_positive(options.jobs, "--jobs")
    group, protocol, run = chosen_run(options)
    result = reproduce(
        *(options.entry, with_custom(options.groups).get(group, group), protocol, run),
        agent=options.agent,
        jobs=options.jobs,
        progress=not options.quiet,
    )
    print(f"{options.entry} {group} {protocol} run {run}: {summary(result)}")
    return 0 if result.comparison.agrees else 1


def chosen_run(options: argparse.Namespace) -> LoggedRun:
    """The run that the options name, or that their salt draws."""
    if options.salt is None:
        run = 0 if options.run is None else options.run
        return LoggedRun(options.group, options.protocol or "sequential", run)
    if options.protocol is not None or options.run is not None:
        message = "The salt draws the protocol and the run."
        raise BenchError("conflicting-options", message, "--salt", "Leave out --protocol and --run.")
    return draw_run(options.entry, options.salt)


def summary(result: Reproduction) -> str:
    """What the comparison showed, in a few lines."""
    comparison = result.comparison
    if comparison.same_bytes:
        return "the same bytes."
    lines = [f"The first difference is at {comparison.first_difference}."]
    changed = [f"{name} {old} (installed: {new})" for name, (old, new) in result.versions.items()]
    if changed:
        lines.append(f"The submission was made with {', '.join(changed)}.")
    else:
        lines.append("The versions, the platform and the BLAS kernels are those of the submission.")
    if manifest.BLAS in result.versions:
        lines.append("OpenBLAS chooses its kernels by the variable OPENBLAS_CORETYPE, if it is set.")
    differing = [cell for cell in comparison.cells if not cell.agrees]
    for cell in differing:
        lines.append(
            f"Stage {cell.stage}, {cell.task}: mean return {cell.logged:.1f} in the log and "
            f"{cell.retrained:.1f} after retraining, p = {cell.p_value:.2g}."
        )
    if not comparison.agrees:
        verdict = f"{len(differing)} of {len(comparison.cells)} cells differ."
        if changed:
            lines.append(
                "With other versions or kernels it is another run of the agent, which refutes nothing."
            )
    else:
        verdict = f"the mean returns of all {len(comparison.cells)} cells agree within evaluation noise."
    return "\n".join([verdict, *lines])
