"""The ``gym-extensions`` command. Each sub-command is imported when it is called."""

import importlib
import sys
from collections.abc import Callable
from importlib.metadata import version

from gym_extensions.errors import reports_mistakes, require_known

COMMANDS = {
    "envs": ("gym_extensions.envs.cli:main", "list, describe and check the environments"),
    "train": (
        "gym_extensions.baselines.cli:main",
        "train an agent through a protocol and write a submission",
    ),
    "score": ("gym_extensions.scoring.cli:main", "check and score submissions"),
    "verify": ("gym_extensions.verification.cli:main", "run the policies of submissions on new seeds"),
    "export": ("gym_extensions.export.cli:main", "write results in the formats of other projects"),
    "site": ("gym_extensions.site.cli:main", "build the pages of the leaderboard"),
    "check-pr": ("gym_extensions.curation.cli:check_pr", "check a pull request with a submission"),
    "maintain": (
        "gym_extensions.curation.cli:maintain",
        "for maintainers: train merged code, store decisions, measure landscapes, …",
    ),
}
"""The module and function of each sub-command, and what it does."""


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
    require_known("command", arguments[0], COMMANDS)
    module, _, function = COMMANDS[arguments[0]][0].partition(":")
    command: Callable[[list[str]], int] = getattr(importlib.import_module(module), function)
    return command(arguments[1:])


if __name__ == "__main__":
    sys.exit(main())
