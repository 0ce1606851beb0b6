"""Lists the runs that would help the core board most: those that complete the next look of a submission.

    python -m tools.wanted [SUBMISSION …]

Those come first that would decide most comparisons per processor hour. Each is one command, and one pull
request may bring any of them; what is trained here, maintainers train. The site has the same list.
"""

from collections.abc import Sequence
from pathlib import Path

from gym_extensions.baselines import algorithms
from gym_extensions.errors import reports_mistakes
from gym_extensions.scoring.pipeline import find_submissions, make_scorer, scorecards
from gym_extensions.scoring.ranking.core_board import core_board
from gym_extensions.scoring.ranking.wanted import wanted
from tools import argument_parser


def lines(folders: Sequence[Path]) -> list[str]:
    """A line for each submission, and the commands that train its missing runs below it."""
    cards = list(scorecards(folders, make_scorer(only=("core",))))
    paths = {card.name: str(folder) for folder, card in zip(folders, cards, strict=True)}
    found = []
    for each in wanted(cards, core_board(cards), algorithms.names()):
        more = "" if each.hours is None else f" ({each.hours:.1f} h on one core)"
        more += "" if each.decides is None else f" and should decide about {each.decides:.1f} open pairs"
        found.append(f"{each.name}: {each.count} runs complete its look at {each.look} runs{more}.")
        found += [f"  {command}" for command in each.commands(paths[each.name])]
    return found or ["No submission of a reference agent needs runs for its next look."]


@reports_mistakes
def main(argv: Sequence[str] | None = None) -> int:
    """Prints the runs that submissions need."""
    parser = argument_parser("tools.wanted", __doc__)
    help_ = "all submissions of the board (default: submissions)"
    parser.add_argument("submissions", nargs="*", type=Path, default=[Path("submissions")], help=help_)
    options = parser.parse_args(argv)
    print("\n".join(lines(find_submissions(options.submissions))))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
