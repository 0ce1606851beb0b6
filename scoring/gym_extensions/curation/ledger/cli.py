"""``gym-extensions ledger``: verifies the ledger, appends lines, and rebuilds old boards."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from gym_extensions.curation.ledger import append, rebuild
from gym_extensions.curation.ledger.chain import FILE, read
from gym_extensions.curation.ledger.history import check_history
from gym_extensions.curation.ledger.line import EVENTS, LedgerLine
from gym_extensions.curation.ledger.verify import active_states, check_evidence, check_folders
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.rollouts.problem import Problem


def _author_options(command: argparse.ArgumentParser, reason_required: bool) -> None:
    today = datetime.now(UTC).date().isoformat()
    command.add_argument("--reason", required=reason_required, help="one sentence, shown on the entry's page")
    command.add_argument("--date", default=today, metavar="YYYY-MM-DD", help="default: today (UTC)")
    command.add_argument(
        "--value",
        default="",
        metavar="HEX",
        help="derive the salt of the audit sample from this number, such as a beacon's randomness; `merge` "
        "stands for the commit that fixed the entry; without it, the sample has no salt",
    )


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    command = argparse.ArgumentParser(
        prog="gym-extensions ledger",
        description="Verify the ledger of submissions, append lines to it, and rebuild old boards.",
        epilog="Exit status: 0 success, 1 problems, 2 the ledger is broken or wrong usage.",
    )
    command.add_argument(
        "--submissions",
        type=Path,
        default=Path("submissions"),
        metavar="DIR",
        help="folder with the ledger (default: submissions)",
    )
    actions = command.add_subparsers(dest="action", required=True, metavar="ACTION")
    verify = actions.add_parser("verify", help="check the chain, the git history and the entries' digests")
    verify.add_argument("--replay", action="store_true", help="also replay every entry as its line states")
    verify.add_argument("--no-history", action="store_true", help="do not compare with the git history")
    add = actions.add_parser("add", help="append one line; accepted and rescored replay the entry first")
    add.add_argument("event", choices=EVENTS)
    add.add_argument("entry", help="name of the entry's folder")
    add.add_argument("--level", choices=("re-evaluated", "reproduced"), help="level that was proven besides")
    _author_options(add, reason_required=True)
    record = actions.add_parser(
        "record", help="append the lines that make the ledger agree with the folder: new, changed, removed"
    )
    _author_options(record, reason_required=True)
    salt = actions.add_parser("salt", help="print the salt that follows from the commit that fixed an entry")
    salt.add_argument("entry", help="name of the entry's folder")
    salt.add_argument(
        "--value", default=append.MERGE, metavar="HEX", help="a later number instead of the commit"
    )
    board = actions.add_parser("board", help="rebuild the boards as of an old line, from git")
    board.add_argument("--lines", type=int, required=True, metavar="N", help="number of lines to use")
    board.add_argument("--out", type=Path, required=True, metavar="FILE", help="boards.json to write")
    return command


def _show(problems: Sequence[Problem]) -> None:
    for problem in problems:
        print(f"{problem.where}: {problem.rule}: {problem.message} {problem.hint}")


def _verify(options: argparse.Namespace) -> int:
    folder: Path = options.submissions
    lines = read(folder)
    if not lines:
        raise BenchError("no-ledger", "There is no ledger.", str(folder / FILE), "Name the folder.")
    print(f"chain: {len(lines)} lines, last {lines[-1].sha256}")
    if not options.no_history:
        print(f"git history: {check_history(folder)} versions, lines were only appended")
    problems = check_folders(folder)
    _show(problems)
    print(
        f"digests: {len(active_states(folder)) - len(problems)} of {len(active_states(folder))} entries agree"
    )
    if options.replay and not problems:
        for name, differences in check_evidence(folder):
            _show(differences)
            problems += differences
            print(f"replay: {name}: {'differs' if differences else 'as stated'}", flush=True)
    return 1 if problems else 0


def _describe(line: LedgerLine) -> str:
    return f"{line.event} {line.entry}: {line.level}, {line.replayed} of {line.episodes} episodes"


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs the command and returns the exit status."""
    options = parser().parse_args(argv)
    if options.action == "verify":
        return _verify(options)
    if options.action == "salt":
        print(append.salt_of(append.entry_folder(options.submissions, options.entry), options.value))
        return 0
    if options.action == "board":
        rebuild.write_board(options.submissions, options.lines, options.out)
        return 0
    if not options.reason.strip():
        raise BenchError("no-reason", "The reason is empty.", "--reason", "Give one sentence.")
    author = append.Author(options.date, options.reason, options.value)
    if options.action == "add":
        lines: Sequence[LedgerLine] = (
            append.add(options.submissions, options.entry, options.event, author, options.level),
        )
    else:
        lines = append.record(options.submissions, author)
    for line in lines:
        print(_describe(line))
    if not lines:
        print("The ledger agrees with the folder.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
