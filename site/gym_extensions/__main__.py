"""The ``gym-extensions`` command. Each sub-command is imported when it is called."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from importlib.metadata import version

from gym_extensions.errors import BenchError, did_you_mean, reports_mistakes

COMMANDS = {
    "envs": ("gym_extensions.envs.cli", "list, describe and check the environments"),
    "train": ("gym_extensions.baselines.cli", "train an agent through a protocol and write a submission"),
    "merge": ("gym_extensions.baselines.submission.cli", "join submissions of one agent with other runs"),
    "trace": ("gym_extensions.baselines.tracing.cli", "write the traces of a submission's audit sample"),
    "repeat": (
        "gym_extensions.scoring.repetition.cli",
        "repeat all episodes of a submission with its policies",
    ),
    "reproduce": (
        "gym_extensions.baselines.reproduction.cli",
        "retrain a run of a submission and compare it with the log",
    ),
    "reference": ("gym_extensions.baselines.references.cli", "measure the floors and ceilings of tasks"),
    "score": ("gym_extensions.scoring.cli", "check and score submissions"),
    "ledger": ("gym_extensions.curation.ledger.cli", "verify and extend the ledger of submissions"),
    "check-pr": ("gym_extensions.curation.gate.cli", "check a pull request with a submission"),
    "reevaluate": (
        "gym_extensions.scoring.reevaluation.cli",
        "evaluate policies on new seeds, for the pages of entries",
    ),
    "watch": ("gym_extensions.scoring.replay.cli", "replay audited episodes for the pages of entries"),
    "site": ("gym_extensions.site.cli", "build the pages of the leaderboard"),
}


def usage() -> str:
    """The list of sub-commands, one line each."""
    rows = "\n".join(f"  {name:<11}{summary}" for name, (_, summary) in COMMANDS.items())
    return (
        f"usage: gym-extensions COMMAND …\n\n{rows}\n\n`gym-extensions COMMAND --help` describes a command."
    )


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs the named sub-command with the remaining arguments and returns its exit status."""
    arguments = sys.argv[1:] if argv is None else argv
    if not arguments or arguments[0] in {"-h", "--help"}:
        print(usage())
        return 0 if arguments else 2
    if arguments[0] == "--version":
        print(version("gym-extensions"))
        return 0
    if arguments[0] not in COMMANDS:
        hint = did_you_mean(arguments[0], COMMANDS)
        raise BenchError("unknown-command", f"Unknown command {arguments[0]!r}.", hint=hint)
    command: Callable[[list[str]], int] = importlib.import_module(COMMANDS[arguments[0]][0]).main
    return command(arguments[1:])


if __name__ == "__main__":
    sys.exit(main())
