"""Folders of submissions -> the scorecard, a JSON document described key by key in docs/scorecard.md."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.scoring.distribution import iqm, profile
from gym_extensions.scoring.entry import Submission
from gym_extensions.scoring.folder import submission_folders
from gym_extensions.scoring.normal import matrix, normalised
from gym_extensions.scoring.normalise import References, load_references
from gym_extensions.scoring.results import Results, results
from gym_extensions.scoring.scores import no_reference, scores
from gym_extensions.scoring.submission import read
from gym_extensions.scoring.table import table_rows, table_total

FORMAT = 1
WELL_FORMED = "well-formed"

Document = dict[str, Any]


def _reference(results: Results, references: References) -> Document:
    known = references.tasks
    return {
        task: {"floor": known[task].floor, "ceiling": known[task].ceiling, "open": known[task].open}
        if task in known
        else {"floor": None, "ceiling": None, "open": None}
        for task in results.group.task_ids
    }


def missing(results: Results, protocol: str) -> list[str]:
    """What a full, ranked entry of this group would still need."""
    runs = len(results.runs[protocol])
    lacking = [f"{FULL_ENTRY_RUNS - runs} more runs"] if runs < FULL_ENTRY_RUNS else []
    if protocol == "sequential":
        there = {*results.runs, *(["curves"] if results.curves else [])}
        lacking += [f"{name}.csv" for name in ("single", "joint", "curves") if name not in there]
    return lacking


def score_group(results: Results, references: References, protocol: str, budget: str) -> Document:
    """One group and protocol: metrics, the paper's table, references, the matrix of raw returns."""
    scored = not no_reference(results, references)
    last = (
        [[run.p(run.T, j) for j in run.scored] for run in normalised(results, references, protocol)]
        if scored
        else []
    )
    means = matrix(results, protocol)
    document: Document = {
        "budget": budget,
        "runs": list(results.runs[protocol]),
        "tasks": list(results.group.task_ids),
        "metrics": {name: score.as_dict() for name, score in scores(results, references, protocol).items()},
        "profile": profile(last),
        "iqm": iqm(last),
        "reference": _reference(results, references),
        "matrix": means if protocol == "sequential" else [run[0] for run in means],
        "missing": missing(results, protocol),
    }
    if protocol == "sequential":
        document |= {"table": table_rows(results), "total": table_total(results)}
    return document


def score(submission: Submission, references: References) -> Document:
    """The scorecard of one submission; with problems it has no trust and no groups."""
    document: Document = {
        "name": submission.name,
        "title": submission.manifest.title if submission.manifest else submission.name,
        "trust": None if submission.problems else WELL_FORMED,
        "problems": [problem.as_dict() for problem in submission.problems],
        "manifest": submission.manifest.as_dict() if submission.manifest else None,
        "notes": [f"{name}: {note}" for name, entry in submission.groups.items() for note in entry.notes],
        "groups": {},
    }
    if submission.problems or submission.manifest is None:
        return document
    budget = submission.manifest.budget
    for name, entry in submission.groups.items():
        returns = results(entry, budget)
        document["groups"][name] = {
            protocol: score_group(returns, references, protocol, budget) for protocol in returns.runs
        }
    return document


def document(cards: Sequence[Document], references: References) -> Document:
    """The whole document around the scorecards."""
    return {
        "format": FORMAT,
        "references": {
            "version": references.version,
            "provisional": references.provisional,
            "sha256": references.digest,
        },
        "submissions": list(cards),
    }


def score_folders(folders: Sequence[Path], references: References | None = None) -> Document:
    """The JSON document of all submissions in the folders, sorted by name.

    Args:
        folders: submissions, or folders that hold submissions.
        references: floors and ceilings; the current benchmark version's where None.
    """
    known = load_references() if references is None else references
    return document([score(read(folder), known) for folder in submission_folders(list(folders))], known)


def text(document: Document) -> str:
    """The document as JSON: sorted keys, two spaces, floats by ``repr``, no NaN."""
    return json.dumps(document, sort_keys=True, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
