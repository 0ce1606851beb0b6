"""Checks that an archive has the traces of all episodes to which the logs of a submission commit."""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.digests import DIGITS, merkle_root, trace_digest
from gym_extensions.rollouts.layout import MAX_FILE_BYTES
from gym_extensions.rollouts.problem import Problem, escape
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.safe_npz import ERRORS, bounded
from gym_extensions.rollouts.safe_npz import read as read_arrays
from gym_extensions.rollouts.trace_reader import TraceRequest, all_requests
from gym_extensions.scoring.scorecard.model import REPORTED, Scorecard

ARCHIVE_DIFFERS = "archive-differs"
LISTED = 3
"""Traces that are named in the message."""
HINT = (
    "Publish the zip file of all traces that were recorded with the logs, with the paths GROUP/traces/NAME."
)


def check_archive(
    submission: Path, archive: Path, groups: Mapping[str, TaskGroup] = GROUPS
) -> tuple[Problem, ...]:
    """The problems of an archive; none if its traces have the root in the manifest.

    Args:
        submission: the submission's folder.
        archive: a zip file with the paths ``<group>/traces/<name>.npz``.
        groups: the groups that the submission may contain, by name.

    Raises:
        BenchError: the archive is not a zip file or cannot be read.
    """
    content = read(submission, groups, merge_runs=False)
    if content.problems or content.manifest is None:
        return content.problems
    where, manifest = escape(archive.name), content.manifest
    if manifest.traces is None:
        message = "The logs do not commit to traces."
        return (Problem(ARCHIVE_DIFFERS, where, message, "Record the runs again with this version."),)
    requests = [
        request
        for group in sorted(content.groups.values(), key=lambda group: group.group.name)
        for log in group.logs.values()
        for request in all_requests(log)
    ]
    try:
        stated = manifest.archive.sha256 if manifest.archive else ""
        if stated and hashlib.sha256(archive.read_bytes()).hexdigest() != stated:
            message = "Its SHA-256 is not the one in [archive]."
            return (Problem(ARCHIVE_DIFFERS, where, message, HINT),)
        with zipfile.ZipFile(archive) as members:
            digests = list(_digests(members, requests))
    except ERRORS as error:
        message, hint = f"The archive cannot be read: {type(error).__name__}.", "Name a zip file of traces."
        raise BenchError("bad-archive", message, str(archive), hint) from error
    root = merkle_root(digests)
    if root == manifest.traces.root:
        return ()
    pairs = zip(requests, digests, strict=True)
    differing = [request.path for request, digest in pairs if digest != request.digest]
    more = f" and {len(differing) - LISTED} more" if len(differing) > LISTED else ""
    message = (
        f"Its root is {root}, and [traces] root is {manifest.traces.root}. Missing or different: "
        f"{', '.join(differing[:LISTED])}{more}."
    )
    return (Problem(ARCHIVE_DIFFERS, where, message, HINT),)


def _digests(archive: zipfile.ZipFile, requests: list[TraceRequest]) -> Iterator[str]:
    """The digest of each trace; zeros where it is missing, too large or malformed."""
    members = {info.filename: info for info in archive.infolist()}
    for request in requests:
        info = members.get(request.path)
        is_readable = info is not None and info.file_size <= MAX_FILE_BYTES[".npz"]
        arrays = read_arrays(bounded(archive, info)) if info and is_readable else None
        outcome = (request.length, request.return_, request.terminated, request.success)
        yield "0" * DIGITS if arrays is None else trace_digest(arrays, *outcome)


def with_archive(card: Scorecard, path: Path, archive: Path, groups: Mapping[str, TaskGroup]) -> Scorecard:
    """The scorecard, with the problems of the archive of all traces if it has any.

    Args:
        card: the scorecard of the submission.
        path: the submission's folder.
        archive: a zip file with the traces of all episodes.
        groups: the groups that the submission may contain, by name.
    """
    if card.problems or card.trust == REPORTED:
        return card
    problems = check_archive(path, archive, groups)
    return replace(card, trust=None, problems=problems, groups={}, suites={}) if problems else card
