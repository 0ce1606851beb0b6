"""Rules about submission.toml and the folder together: whether the one says what the other holds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from gym_extensions.catalog.published import REPORTS
from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.layout import MANIFEST
from gym_extensions.rollouts.problem import Finding, shown
from gym_extensions.rollouts.rules.rule import rule


@dataclass(frozen=True)
class Said:
    """A folder, and the tables of the submission.toml in it."""

    folder: Folder
    tables: dict[str, Any]


@rule("said")
def no_groups(said: Said) -> Iterator[Finding]:
    """A submission has the folder of at least one group, unless it is a reported entry."""
    if "reported" not in said.tables and all(one.kind == "file" for one in said.folder.entries):
        hint = "Add the folders of the groups, as docs/rollout-log.md says."
        yield Finding(said.folder.name, "There is no group's folder in it.", hint)


@rule("said")
def logs_of_a_reported_entry(said: Said) -> Iterator[Finding]:
    """A reported entry is a published table alone; whoever has logs leaves out the key ``reported``."""
    for entry in said.folder.entries if "reported" in said.tables else ():
        if entry.kind == "folder" and "/" not in entry.path:
            hint = "Remove the key 'reported' from submission.toml, or the folder."
            yield Finding(entry.path, "A reported entry has no logs.", hint)


@rule("said")
def foreign_report(said: Said) -> Iterator[Finding]:
    """A published table is one entry: in the folder of its own name, with its own budget and algorithm."""
    table, protocol = said.tables.get("reported"), said.tables.get("protocol")
    report = REPORTS.get(table) if isinstance(table, str) else None
    if report is None:
        return
    if said.folder.name != report.entry:
        found = f"The table {table!r} stands in the folder {report.entry!r}."
        hint = "Leave out the key 'reported', and write the logs of your own runs."
        yield Finding(said.folder.name, found, hint)
    for name in ("budget", "algorithm"):
        given, own = protocol.get(name) if isinstance(protocol, dict) else None, getattr(report, name)
        if isinstance(given, str) and given != own:
            found = f"The value is {shown(given)}; the table {table!r} has {own!r}."
            yield Finding(f"{MANIFEST}, [protocol] {name}", found, f"Write {own!r}.")
