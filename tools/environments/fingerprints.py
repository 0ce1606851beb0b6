"""Publishes the fingerprints of new tasks."""

import json
from collections.abc import Mapping
from typing import Any

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.envs import fingerprinting
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.files import write_text
from tools import argument_parser


def updated(replace: bool = False) -> tuple[dict[str, Any], list[str]]:
    """Returns the table with a row for every new task, and the ids of the new rows.

    Published rows stay byte for byte; with ``replace``, rows that differ from their task are computed again.

    Raises:
        BenchError: the installed physics engine is not that of the published rows, or a published task is not
            in the catalog, and ``replace`` is false.
    """
    old, engine = fingerprints.table(), fingerprinting.engine()
    if old["engine"] != engine and not replace:
        message = f"The published fingerprints are of {old['engine']}; installed is {engine}."
        raise BenchError("other-engine", message, hint="Install that engine, or replace all fingerprints.")
    if (lost := sorted(old["tasks"].keys() - TASKS.keys())) and not replace:
        hint = "Restore it; a changed task is added as a new version."
        raise BenchError("lost-task", "It is published and not in the catalog any more.", lost[0], hint)
    rows, changed = dict[str, Any](), []
    for task in TASKS.values():
        rows[task.id] = published = old["tasks"].get(task.id)
        if published is None or (replace and fingerprinting.check([task])):
            rows[task.id] = fingerprinting.row(task)
            changed.append(task.id)
    return {"format": fingerprints.FORMAT, "engine": engine, "tasks": rows}, changed


def text(table: Mapping[str, Any]) -> str:
    """Returns the table as JSON with one line per task, so that a diff shows which tasks changed."""
    lines = ",\n".join(f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in table["tasks"].items())
    head = f'"format": {table["format"]},\n "engine": {json.dumps(table["engine"])}'
    return f'{{{head},\n "tasks": {{\n{lines}\n }}}}\n'


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Writes the table and prints the new fingerprints."""
    parser = argument_parser("tools.environments.fingerprints", __doc__)
    parser.add_argument("--replace", action="store_true", help="also replace fingerprints that have changed")
    table, changed = updated(parser.parse_args(argv).replace)
    write_text(fingerprints.PATH, text(table))
    for task in changed:
        print(f"{task} {table['tasks'][task]['fingerprint']}")
    print(f"{len(changed)} fingerprints written, {len(table['tasks']) - len(changed)} unchanged.")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
