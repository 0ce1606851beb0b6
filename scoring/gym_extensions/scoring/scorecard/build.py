"""One submission -> its scorecard, the part of docs/scorecard.md under ``submissions``."""

from __future__ import annotations

from typing import Any

from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.rollouts.submission import Submission
from gym_extensions.scoring.metrics.aggregates import iqm, profile
from gym_extensions.scoring.metrics.evaluate import no_reference, scores
from gym_extensions.scoring.metrics.normalization import normalised
from gym_extensions.scoring.metrics.paper_table import table
from gym_extensions.scoring.metrics.returns import Results, results
from gym_extensions.scoring.published.scorecard import reported_groups
from gym_extensions.scoring.references import References
from gym_extensions.scoring.scorecard.suites import suite_scores

WELL_FORMED = "well-formed"
REPORTED = "reported"

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
    more = FULL_ENTRY_RUNS - runs
    lacking = [f"{more} more run{'s' if more > 1 else ''}"] if more > 0 else []
    there = {*results.runs, *(["curves"] if results.curves else [])}
    wanted = ("single", "joint", "curves") if protocol == "sequential" else ("sequential",)
    return lacking + [f"{name}.csv" for name in wanted if name not in there]


def score_group(results: Results, references: References, protocol: str, budget: str) -> Document:
    """One group and protocol: metrics, the paper's table, references, the matrix of raw returns."""
    runs = [] if no_reference(results, references) else normalised(results, references, protocol)
    last = [[run.p(run.T, j) for j in run.scored] for run in runs]
    found = scores(results, references, protocol, runs)
    means = results.means[protocol]
    document: Document = {
        "budget": budget,
        "runs": list(results.runs[protocol]),
        "tasks": list(results.group.task_ids),
        "metrics": {name: one.as_dict() for name, one in found.items()},
        "profile": profile(last),
        "iqm": iqm(last),
        "reference": _reference(results, references),
        "matrix": means if protocol == "sequential" else [run[0] for run in means],
        "curves": [
            {"run": run, "task": task, "points": list(map(list, zip(steps, values, strict=True)))}
            for (name, run, task), (steps, values) in results.curves.items()
            if name == protocol and run in results.runs[protocol]
        ],
        "missing": missing(results, protocol),
    }
    if protocol == "sequential":
        rows, total = table(results)
        document |= {"table": rows, "total": total}
    return document


def _trust(submission: Submission) -> str | None:
    """The level of trust; None with problems."""
    if submission.problems or submission.manifest is None:
        return None
    return REPORTED if submission.manifest.reported else WELL_FORMED


def score(submission: Submission, references: References) -> Document:
    """The scorecard of one submission; with problems it has no trust and no groups."""
    document: Document = {
        "name": submission.name,
        "title": submission.manifest.title if submission.manifest else submission.name,
        "trust": _trust(submission),
        "problems": [problem.as_dict() for problem in submission.problems],
        "manifest": submission.manifest.as_dict() if submission.manifest else None,
        "notes": [f"{name}: {note}" for name, entry in submission.groups.items() for note in entry.notes],
        "groups": {},
        "suites": {},
    }
    if submission.problems or submission.manifest is None:
        return document
    budget = submission.manifest.protocol.budget
    if submission.manifest.reported:
        document["groups"] = reported_groups(submission.manifest.reported, budget)
        return document
    for name, entry in submission.groups.items():
        returns = results(entry, budget)
        document["groups"][name] = {
            protocol: score_group(returns, references, protocol, budget) for protocol in returns.runs
        }
    document["suites"] = suite_scores(document["groups"])
    return document
