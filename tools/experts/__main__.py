"""Trains, selects, measures, publishes and checks the experts, and writes their motion and their tables."""

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

from gym_extensions.catalog.tasks import mujoco_tasks
from gym_extensions.errors import BenchError, did_you_mean, reports_mistakes, require_known
from gym_extensions.references import experts, load_references
from tools import argument_parser
from tools.experts import candidates, published, training
from tools.experts.candidates import QUICK, Workplace
from tools.experts.recipes import FAMILIES, recipe

PAGE, MARKER = Path("docs/experts.md"), "<!-- tables -->"
"""The page with the tables, and what they follow there."""
PROGRAM = "python -m tools.experts"


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs a command."""
    args = _parser().parse_args(argv)
    if args.command == "tables":
        prose = PAGE.read_text(encoding="utf-8").split(MARKER)[0]
        PAGE.write_text(f"{prose}{MARKER}\n" + "\n".join(published.tables()) + "\n", encoding="utf-8")
        return 0
    differs = False
    for line in _lines(args):
        print(line, flush=True)
        differs |= line.endswith(published.DIFFERS)
    return int(differs)


def _lines(args: argparse.Namespace) -> Iterator[str]:
    """Runs a command; yields its output as it arises."""
    work = Workplace(args.work, args.submissions)
    patterns = getattr(args, "tasks", None) or [".*"]
    try:
        tasks = [task for task in mujoco_tasks() if re.fullmatch("|".join(patterns), task.name)]
    except re.error as error:
        message = f"{error.pattern!r} is not a regular expression: {error}."
        raise BenchError("bad-pattern", message, "tasks", "Name tasks.") from error
    if not tasks:
        hint = did_you_mean(patterns[0], [task.name for task in mujoco_tasks()])
        raise BenchError("unknown-task", f"No task has the name {' or '.join(patterns)}.", hint=hint)
    with_expert = [task for task in tasks if task.bare_name in experts.names()]
    if args.command == "harvest":
        families = sorted(set(FAMILIES.values()))
        for family in args.families or families:
            require_known("family", family, families, "harvest")
            yield from candidates.harvest(work, family)
    elif args.command == "train":
        for name in args.recipes:
            row = recipe(name)
            parent = work.resolved(args.parent or row.parent)
            origin = f" --from {parent}" if parent else ""
            command = f"{PROGRAM} train {name} --seed {args.seed}{origin}"
            yield from training.train(work, row, args.seed, parent, command)
    elif args.command == "select":
        yield from candidates.select(work, tasks, args.episodes)
    elif args.command == "publish":
        yield from (published.publish(work, task, args.episodes) for task in tasks)
    elif args.command == "check":
        yield from published.check(with_expert, args.episodes)
    elif args.command == "poses":
        yield from published.write_poses([task.bare_name for task in with_expert])
    else:
        ranked = candidates.stored_candidates(work.submissions)
        cells = {task.bare_name: ranked.get(task.bare_name, []) for task in tasks}
        yield from candidates.challenge(work, cells, args.episodes, load_references().tasks)


def _parser() -> argparse.ArgumentParser:
    parser = argument_parser("tools.experts", __doc__)
    parser.add_argument("--work", type=Path, default=Path("experts-work"), help="folder of unfinished pieces")
    parser.add_argument("--submissions", type=Path, default=Path("submissions"))
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser(
        "harvest", help="see the stored policies of submissions on all tasks of a body"
    )
    command.add_argument("families", nargs="*")
    command = commands.add_parser("train", help="train runs that are not finished")
    command.add_argument("recipes", nargs="+")
    command.add_argument("--seed", type=int, default=0)
    command.add_argument("--from", dest="parent", help="candidate to start from; by default the recipe's")
    command = commands.add_parser("poses", help="write the motion of published policies, which pages show")
    command.add_argument("tasks", nargs="*", help="names or regular expressions; all by default")
    for name, text, episodes in (
        ("select", "give the best candidates their selection episodes", QUICK),
        ("publish", "measure the selected policies and write them with cards", QUICK),
        ("check", "measure published policies again from their files", QUICK),
        ("challenge", "evaluate cells of submissions above the expert on fresh seeds", experts.EPISODES),
    ):
        command = commands.add_parser(name, help=text)
        command.add_argument("tasks", nargs="*", help="names or regular expressions; all by default")
        command.add_argument("--episodes", type=int, default=episodes)
    commands.add_parser("tables", help=f"write the tables of {PAGE}")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
