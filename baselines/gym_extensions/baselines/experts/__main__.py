"""``python -m gym_extensions.baselines.experts``: trains, measures, publishes, checks experts."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable
from pathlib import Path

from gym_extensions import experts
from gym_extensions.baselines.experts import checking, measuring, training
from gym_extensions.baselines.experts.measuring import QUICK, Workplace, mujoco_tasks
from gym_extensions.baselines.experts.recipes import FAMILIES, recipe
from gym_extensions.catalog.tasks import Task
from gym_extensions.catalog.tasks import task as published_task
from gym_extensions.errors import reports_mistakes
from gym_extensions.experts.references import CURRENT, REFERENCES

MARKER = "<!-- tables -->"
"""What the tables follow in the documentation."""
PROGRAM = "python -m gym_extensions.baselines.experts"


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs a command."""
    args = _parser().parse_args(argv)
    work = Workplace(args.work, args.submissions)
    if args.command == "harvest":
        for family in args.families or sorted(set(FAMILIES.values())):
            _print(measuring.harvest(work, args.submissions, family, args.own, args.general))
    elif args.command == "train":
        for name in args.recipes:
            row = recipe(name)
            parent = work.resolved(args.parent or row.parent)
            origin = f" --from {parent}" if parent else ""
            command = f"{PROGRAM} train {name} --seed {args.seed}{origin}"
            _print(training.train(work, row, args.seed, parent, command))
    elif args.command == "screen":
        rows = _tasks(args.tasks)
        candidates = [work.resolved(name) or "" for name in args.candidates]
        _print(measuring.screen(work, [(row, name) for row in rows for name in candidates]))
    elif args.command == "select":
        _print(measuring.select(work, _tasks(args.tasks), args.episodes, args.rivals))
    elif args.command == "publish":
        for task in _tasks(args.tasks):
            card = measuring.publish(work, task, args.episodes, args.folder)
            print(task.name, card and f"{card.measurement.mean:.1f} {card.provisional}", flush=True)
    elif args.command == "check":
        return _check(args.tasks or experts.names(args.folder), args.episodes, args.folder)
    elif args.command == "challenge":
        names, cells = {row.name for row in _tasks(args.tasks)}, measuring.stored_candidates(args.submissions)
        cells = {name: ranked for name, ranked in cells.items() if name in names}
        _print(checking.challenge(work, cells, args.references, args.threshold, args.episodes))
    elif args.command == "tables":
        prose = args.page.read_text(encoding="utf-8").split(MARKER)[0]
        lines = measuring.tables(work, args.folder, args.references)
        args.page.write_text(f"{prose}{MARKER}\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=PROGRAM, description=__doc__)
    parser.add_argument("--work", type=Path, default=Path("experts-work"), help="folder of unfinished pieces")
    parser.add_argument("--submissions", type=Path, default=Path("submissions"))
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("harvest", help="see the stored policies of entries on all tasks of a body")
    command.add_argument("families", nargs="*")
    command.add_argument("--own", type=int, default=3, help="policies per task, by its logs")
    command.add_argument("--general", type=int, default=4, help="policies that every task of the body sees")
    command = commands.add_parser("train", help="train runs that are not finished")
    command.add_argument("recipes", nargs="+")
    command.add_argument("--seed", type=int, default=0)
    command.add_argument("--from", dest="parent", help="candidate to start from; by default the recipe's")
    command = commands.add_parser("screen", help="see candidates on tasks")
    command.add_argument("candidates", nargs="+")
    command.add_argument("--tasks", nargs="+", default=[], help="names or regular expressions")
    command = commands.add_parser("select", help="give the best candidates their selection episodes")
    command.add_argument("tasks", nargs="*", help="names or regular expressions; all by default")
    command.add_argument("--episodes", type=int, default=QUICK)
    command.add_argument("--rivals", type=int, default=2, help="candidates beside the best")
    command = commands.add_parser("publish", help="measure the selected policies and write them with cards")
    command.add_argument("tasks", nargs="*", help="names or regular expressions; all by default")
    command.add_argument("--episodes", type=int, default=QUICK)
    command.add_argument("--folder", type=Path, default=experts.DATA)
    command = commands.add_parser("check", help="measure published policies again from their files")
    command.add_argument("tasks", nargs="*")
    command.add_argument("--episodes", type=int, default=QUICK)
    command.add_argument("--folder", type=Path, default=experts.DATA)
    command = commands.add_parser(
        "challenge", help="evaluate cells of entries above the expert on fresh seeds"
    )
    command.add_argument("tasks", nargs="*", help="names or regular expressions; all by default")
    command.add_argument("--threshold", type=float, default=1.05, help="normalized return of a cell's log")
    command.add_argument("--episodes", type=int, default=experts.EPISODES)
    command.add_argument("--references", type=Path, default=REFERENCES / f"{CURRENT}.json")
    command = commands.add_parser("tables", help="write the tables of docs/experts.md")
    command.add_argument("--page", type=Path, default=Path("docs/experts.md"))
    command.add_argument("--references", type=Path, default=REFERENCES / f"{CURRENT}.json")
    command.add_argument("--folder", type=Path, default=experts.DATA)
    return parser


def _tasks(patterns: list[str]) -> list[Task]:
    rows = mujoco_tasks().values()
    return [row for row in rows if not patterns or re.fullmatch("|".join(patterns), row.name)]


def _print(lines: Iterable[str]) -> None:
    for line in lines:
        print(line, flush=True)


def _check(tasks: list[str], count: int, folder: Path) -> int:
    """Measures experts again; 1 if one differs from its card by more than three standard errors."""
    different = 0
    for name in tasks:
        mean, stated, differs = checking.measured_again(published_task(name), count, folder)
        different += differs
        print(f"{name}: {mean:.2f}, the card says {stated:.2f}{' (differs)' if differs else ''}", flush=True)
    return int(different > 0)


if __name__ == "__main__":
    raise SystemExit(main())
