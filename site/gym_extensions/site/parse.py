"""The scorecard's JSON, key by key, to typed values (``document.py``)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.scoring.metrics.paper_table import COLUMNS as TABLE
from gym_extensions.site.document import (
    FORMAT,
    Curve,
    Entry,
    Estimate,
    Json,
    Problem,
    Profile,
    Reference,
    Spread,
    Trial,
    Version,
)


def entries(document: Json) -> tuple[Entry, ...]:
    """Every submission of the document, by name.

    Raises:
        ValueError: the document is of another format.
    """
    if document.get("format") != FORMAT:
        raise ValueError(f"scorecard format {document.get('format')!r}, expected {FORMAT}")
    return tuple(sorted(map(_entry, document["submissions"]), key=lambda entry: entry.name))


def version(document: Json) -> Version:
    """The references' version."""
    row = document["references"]
    return Version(str(row["version"]), bool(row["provisional"]), str(row["sha256"]))


def _entry(row: Json) -> Entry:
    problems = tuple(
        Problem(*(str(problem.get(key) or "") for key in ("rule", "where", "message", "hint")))
        for problem in row["problems"]
    )
    trials, suites = _trials(row["groups"]), _trials(row.get("suites") or {})
    notes = tuple(map(str, row.get("notes") or ()))
    title = str(row.get("title") or row["name"])
    trust = str(row.get("trust") or "refused")
    return Entry(row["name"], title, trust, problems, row["manifest"] or {}, trials, notes, suites)


def _trials(groups: Json) -> tuple[Trial, ...]:
    found = (
        _trial(group, protocol, scores)
        for group, protocols in groups.items()
        for protocol, scores in protocols.items()
    )
    return tuple(sorted(found, key=lambda trial: (place(trial.group), PROTOCOLS.index(trial.protocol))))


def place(group_id: str) -> tuple[int, str]:
    """Where a group stands among the others: in the catalog's order."""
    ids = [group.id for group in GROUPS.values()]
    return (ids.index(group_id) if group_id in ids else len(ids), group_id)


def _trial(group: str, protocol: str, scores: Json) -> Trial:
    matrix, staged = scores.get("matrix") or (), protocol == "sequential"
    return Trial(
        group=group,
        protocol=protocol,
        budget=scores["budget"],
        runs=tuple(scores.get("runs") or ()),
        tasks=tuple(scores.get("tasks") or ()),
        metrics={name: _estimate(value) for name, value in scores["metrics"].items()},
        table=tuple((row["task"], _spreads(row)) for row in scores.get("table") or ()),
        total=_spreads(scores.get("total") or {}),
        printed=_spreads(scores["printed_total"]) if scores.get("printed_total") else {},
        notes=tuple(map(str, scores.get("notes") or ())),
        references={
            task: Reference(row["floor"], row["ceiling"], bool(row["open"]))
            for task, row in (scores.get("reference") or {}).items()
        },
        matrix=tuple(tuple(map(tuple, run)) for run in matrix) if staged else (),
        returns=() if staged else tuple(map(tuple, matrix)),
        curves=tuple(_curve(row) for row in scores.get("curves") or ()),
        missing=tuple(scores.get("missing") or ()),
        profile=_profile(scores.get("profile")),
        iqm=scores.get("iqm"),
    )


def _estimate(value: Mapping[str, Any]) -> Estimate:
    if value.get("mean") is None:
        return Estimate(why=str(value.get("why") or "no reason given"))
    runs = tuple(float(run) for run in value.get("runs") or () if run is not None)
    return Estimate(value["mean"], value.get("low"), value.get("high"), runs, str(value.get("why") or ""))


def _spreads(row: Json) -> dict[str, Spread | None]:
    return {
        column: Spread(cell["mean"], cell["std"]) if (cell := row.get(column)) else None for column in TABLE
    }


def _profile(value: Json | None) -> Profile:
    return tuple(zip(value["tau"], value["fraction"], strict=True)) if value else ()


def _curve(row: Json) -> Curve:
    return Curve(row["run"], row["task"], tuple((float(step), float(value)) for step, value in row["points"]))
