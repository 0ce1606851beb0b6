"""``gym-extensions envs``: lists, shows and checks the environments."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.groups import GROUPS, group
from gym_extensions.catalog.registry import TASKS, task
from gym_extensions.catalog.task import Task
from gym_extensions.errors import reports_mistakes


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="gym-extensions envs", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    listing = commands.add_parser("list", help="every group with its tasks, in training order")
    listing.add_argument("group", nargs="*", help="only these groups")
    showing = commands.add_parser("show", help="what a task is, in numbers")
    showing.add_argument("task", help="an id or a bare name")
    checking = commands.add_parser("check", help="compares every task with its published fingerprint")
    checking.add_argument("task", nargs="*", help="only these tasks")
    writing = commands.add_parser("fingerprint", help="publishes the fingerprints of new tasks")
    writing.add_argument("--replace", action="store_true", help="also of tasks that no longer hold theirs")
    documenting = commands.add_parser("docs", help="writes the pages that describe every environment")
    documenting.add_argument("--out", type=Path, default=Path("docs/environments"), help="%(default)s")
    documenting.add_argument("--pictures", action="store_true", help="render the pictures too (needs OpenGL)")
    return parser


def _list(names: list[str]) -> int:
    for row in [group(name) for name in names] or list(GROUPS.values()):
        print(f"{row.id} ({len(row.tasks)} tasks)")
        for member in row.tasks:
            print(f"  {member.id}")
    grouped = {member.id for row in GROUPS.values() for member in row.tasks}
    alone = [] if names else [task_id for task_id in TASKS if task_id not in grouped]
    if alone:
        print(f"in no group ({len(alone)} tasks)")
        for task_id in alone:
            print(f"  {task_id}")
    return 0


def _show(row: Task) -> int:
    from gym_extensions.envs.docgen.summary import sheet

    print(sheet(row))
    return 0


def _check(names: list[str]) -> int:
    from gym_extensions.envs import fingerprint

    chosen = [task(name) for name in names]
    differences = fingerprint.check(chosen or None)
    for difference in differences:
        print(difference, file=sys.stderr)
    count = len(chosen or TASKS)
    if differences:
        tasks = len({difference.task for difference in differences})
        print(f"{len(differences)} differences in {tasks} of {count} tasks.", file=sys.stderr)
        print("A task that changes needs a new version number.", file=sys.stderr)
        return 1
    print(f"{count} tasks are as published.")
    return 0


def _write(replace: bool) -> int:
    from gym_extensions.atomic import write_text
    from gym_extensions.envs import fingerprint

    table, changed = fingerprint.renewed(replace)
    write_text(fingerprints.PATH, fingerprint.text(table))
    for task_id in changed:
        print(f"{task_id} {table['tasks'][task_id]['fingerprint']}")
    print(f"{len(changed)} fingerprints written, {len(table['tasks']) - len(changed)} kept.")
    return 0


def _docs(out: Path, with_pictures: bool) -> int:
    from gym_extensions.atomic import write_bytes, write_text
    from gym_extensions.envs.docgen.pages import pages
    from gym_extensions.envs.docgen.thumbnails import pictures

    texts, images = pages(), pictures() if with_pictures else {}
    for name, text in texts.items():
        write_text(out / name, text)
    for name, image in images.items():
        write_bytes(out / "pictures" / name, image)
    print(f"{len(texts)} pages and {len(images)} pictures written to {out}.")
    return 0


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs one of the commands; 0 fine, 1 tasks that are not as published, 2 usage."""
    given = _parser().parse_args(argv)
    if given.command == "list":
        return _list(given.group)
    if given.command == "show":
        return _show(task(given.task))
    if given.command == "docs":
        return _docs(given.out, given.pictures)
    return _check(given.task) if given.command == "check" else _write(given.replace)
