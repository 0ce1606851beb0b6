"""The gym-extensions command: the last station of the arrow; each sub-command is imported when called."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from importlib.metadata import version

from gym_extensions.errors import BenchError, did_you_mean, reports_mistakes

COMMANDS = {
    "envs": ("gym_extensions.envs.cli", "list, show and check the environments"),
    "train": ("gym_extensions.baselines.cli", "run an agent through a protocol and write a submission"),
    "reference": ("gym_extensions.baselines.references.cli", "measure floors and ceilings"),
    "score": ("gym_extensions.scoring.cli", "check and score submissions"),
    "site": ("gym_extensions.site.cli", "build the leaderboard's pages"),
}


def usage() -> str:
    """The list of sub-commands, a line each."""
    rows = "\n".join(f"  {name:<11}{what}" for name, (_, what) in COMMANDS.items())
    return f"usage: gym-extensions COMMAND …\n\n{rows}\n\n`gym-extensions COMMAND --help` tells more."


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs the named sub-command with the remaining arguments and gives its exit status."""
    words = sys.argv[1:] if argv is None else argv
    if not words or words[0] in {"-h", "--help"}:
        print(usage())
        return 0 if words else 2
    if words[0] == "--version":
        print(version("gym-extensions"))
        return 0
    if words[0] not in COMMANDS:
        hint = did_you_mean(words[0], COMMANDS)
        raise BenchError("unknown-command", f"There is no command {words[0]!r}.", hint=hint)
    command: Callable[[list[str]], int] = importlib.import_module(COMMANDS[words[0]][0]).main
    return command(words[1:])


if __name__ == "__main__":
    sys.exit(main())
