"""The command line of the environments."""

import argparse
import sys
from itertools import groupby
from operator import attrgetter

from gym_extensions import errors
from gym_extensions.catalog import descriptions, groups
from gym_extensions.catalog.tasks import TASKS, task


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="gym-extensions envs", description="List, describe and check the environments."
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    listing = commands.add_parser("list", help="list the groups and their tasks, in training order")
    listing.add_argument("group", nargs="*", help="group names, or core (default: all groups)")
    showing = commands.add_parser("show", help="describe one task")
    showing.add_argument("task", help="task id or bare name, for example HopperGravityHalf")
    checking = commands.add_parser("check", help="compare tasks with their published fingerprints")
    which = "task ids or bare names, for all differences (default: all tasks, the first difference of each)"
    checking.add_argument("task", nargs="*", help=which)
    return parser


CHANGED = "A changed task needs a new version number (CONTRIBUTING.md)."
OTHER = "Results on them are not comparable with published results, and score refuses them."


def _check(names: list[str]) -> int:
    from gym_extensions.envs import fingerprinting

    chosen = [task(name) for name in names]
    if engine := fingerprinting.other_engine():
        print(f"{engine} is installed, which is not the published engine.", file=sys.stderr)
    if other := fingerprinting.other_platform():
        print(f"{other} Logged episodes may not be repeated here.", file=sys.stderr)
    with errors.working("comparing seeded episodes with the published ones"):
        found = fingerprinting.check(chosen or None)
    firsts = [next(values) for _, values in groupby(found, attrgetter("task"))]
    for difference in found if names else firsts:
        print(difference, file=sys.stderr)
    count = len(chosen or TASKS)
    if firsts:
        hint = f"{OTHER} {fingerprinting.install()}" if engine else CHANGED
        print(f"{len(firsts)} of {_tasks(count)} differ, in {len(found):,} values. {hint}", file=sys.stderr)
        return 1
    verb = "matches its published fingerprint" if count == 1 else "match their published fingerprints"
    print(f"{_tasks(count)} {verb}.")
    return 0


def _tasks(count: int) -> str:
    return "1 task" if count == 1 else f"{count} tasks"


@errors.reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs one command. The exit status is 0 for success, 1 for tasks that differ, 2 for wrong usage."""
    args = _parser().parse_args(argv)
    if args.command == "show":
        print(descriptions.summary(task(args.task)))
    elif args.command == "list":
        listed = {each.id: each.task_ids for name in args.group for each in groups.groups_named(name)}
        if not listed:
            listed = {each.id: each.task_ids for each in groups.GROUPS.values()}
            grouped = {task_id for ids in listed.values() for task_id in ids}
            listed["in no group"] = tuple(task_id for task_id in TASKS if task_id not in grouped)
        for title, ids in listed.items():
            print(f"{title} ({_tasks(len(ids))})", *ids, sep="\n  ")
    else:
        return _check(args.task)
    return 0
