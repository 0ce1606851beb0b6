"""Rules that compare submission.toml with the folder."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from gym_extensions.catalog.published import REPORTS
from gym_extensions.rollouts.auditing.digests import merkle_root
from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.layout import MANIFEST
from gym_extensions.rollouts.problem import Finding, quote
from gym_extensions.rollouts.rules.rule import rule


@dataclass(frozen=True)
class ManifestInFolder:
    """A folder, and the tables of its submission.toml."""

    folder: Folder
    tables: dict[str, Any]


@dataclass(frozen=True)
class CommittedTraces:
    """The root in [traces], None without one, and the digests of the traces of every log in order."""

    root: str | None
    logs: tuple[list[str], ...]


@rule("manifest in folder")
def no_groups(manifest: ManifestInFolder) -> Iterator[Finding]:
    """A submission contains at least one group folder, unless it is a reported entry."""
    if "reported" not in manifest.tables and all(item.kind == "file" for item in manifest.folder.items):
        hint = "Add group folders, as described in docs/rollout-log.md."
        yield Finding(manifest.folder.name, "The submission contains no group folder.", hint)


@rule("manifest in folder")
def logs_of_a_reported_entry(manifest: ManifestInFolder) -> Iterator[Finding]:
    """A reported entry is a published table and contains no logs."""
    for item in manifest.folder.items if "reported" in manifest.tables else ():
        if item.kind == "folder" and "/" not in item.path:
            hint = "Remove the key 'reported' from submission.toml, or remove the folder."
            yield Finding(item.path, "A reported entry cannot contain a group folder.", hint)


@rule("manifest in folder")
def foreign_report(manifest: ManifestInFolder) -> Iterator[Finding]:
    """Each published table has one entry, with a fixed folder name, budget and algorithm."""
    table, protocol = manifest.tables.get("reported"), manifest.tables.get("protocol")
    report = REPORTS.get(table) if isinstance(table, str) else None
    if report is None:
        return
    if manifest.folder.name != report.entry:
        message = f"The table {table!r} belongs to the folder {report.entry!r}."
        hint = "Remove the key 'reported', and submit the logs of your own runs."
        yield Finding(manifest.folder.name, message, hint)
    for name in ("budget", "algorithm"):
        value = protocol.get(name) if isinstance(protocol, dict) else None
        expected = getattr(report, name)
        if isinstance(value, str) and value != expected:
            message = f"The value is {quote(value)}; expected {expected!r} for the table {table!r}."
            yield Finding(f"{MANIFEST}, [protocol] {name}", message, f"Write {expected!r}.")


@rule("traces")
def different_root(traces: CommittedTraces) -> Iterator[Finding]:
    """[traces] root is the Merkle root of the column `trace` of all logs, and all logs have this column or
    none has."""
    where = f"{MANIFEST}, [traces] root"
    with_digests = [digests for digests in traces.logs if digests]
    if with_digests and len(with_digests) < len(traces.logs):
        message = "Some logs of the submission have the column `trace`, and others do not."
        yield Finding(where, message, "Record all logs with the same version of gym-extensions.")
        return
    expected = merkle_root([digest for digests in traces.logs for digest in digests])
    if traces.root is not None and not with_digests:
        yield Finding(where, "No log has the column `trace`.", "Remove the section [traces].")
    elif with_digests and traces.root != expected:
        actual = "missing" if traces.root is None else quote(traces.root)
        message = f"The root is {actual}; the logs have the root {expected}."
        yield Finding(
            where, message, "Write the root when the logs are written, and do not change them later."
        )
