"""A scorecard document of small matrices of returns."""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.metrics.statistics import interval
from gym_extensions.metrics.values import MetricValue
from gym_extensions.references import Expert, Floor, Reference, References
from gym_extensions.scoring.submission.normalization import GroupReturns
from gym_extensions.scoring.submission.scorer import score_group
from gym_extensions.site.build import build_site
from gym_extensions.site.pages import PAGES
from gym_extensions.site.pages.page import Render

from .browser import references_of, typed

Document = dict[str, Any]
Make = Callable[..., Document]


FIVE = (-0.02, -0.01, 0.0, 0.01, 0.02)
"""Offsets of five runs from their mean: standard deviation .0158, interval ± .0196."""


def around(mean: float, runs: int = 5, wide: float = 1.0) -> list[float]:
    """Values of runs around a mean."""
    return [mean + wide * spread for spread in FIVE[:runs]]


def estimate(runs: list[float]) -> Document:
    """A metric with its interval."""
    found: Document = msgspec.to_builtins(MetricValue.of(interval(runs), runs))
    return found


def missing(why: str) -> Document:
    """A metric without a value."""
    return {"mean": None, "low": None, "high": None, "runs": [], "why": why}


def scored(
    group_name: str, returns: list[list[list[float]]], budget: str = "100k", protocol: str = "sequential"
) -> Document:
    """Scores of ``returns[run][stage][task]``, where the floor of every task is 0 and its expert 1000."""
    members, runs = group(group_name), tuple(range(len(returns)))
    ends = References("made up", dict.fromkeys(members.task_ids, Reference(Floor(0.0), Expert(1000.0))))
    cells = [[[[cell] for cell in stage] for stage in run] for run in returns]
    found = GroupReturns(members, 1, {protocol: runs}, {protocol: cells})
    card = score_group(found, ends, protocol, budget, level="verified")
    document: Document = msgspec.json.decode(msgspec.json.encode(card))
    return document


def learner(strength: float, keeps: float, runs: int) -> list[list[list[float]]]:
    """Matrices of an agent that reaches a share of the reference and retains a share of that per stage."""

    def reached(run: int, stage: int, j: int) -> float:
        wobble = 1 + 0.06 * ((run * 7) % 5 - 2)
        return 1000 * strength * wobble * (keeps ** (stage - 1 - j) if j < stage else 0.12 * stage)

    return [
        [[12.0 + run] * 5, *([reached(run, stage, j) for j in range(5)] for stage in range(1, 6))]
        for run in range(runs)
    ]


def blind(runs: int) -> list[list[list[float]]]:
    """Matrices of an agent that stays near the floor, above it in one run and below it in the next."""
    return [[[(10.0 + task) * (-1) ** run for task in range(5)] for _ in range(6)] for run in range(runs)]


MADE: Document = {
    "run": 0, "command": "", "commit": "", "by": "", "date": None, "versions": {}, "processor": "",
    "steps": 1_500_000, "cpu_seconds": None, "peak_memory_mb": None, "policies": True, "reproduced": False,
    "memory": {"stored_steps": 2000, "parameters_first": 1, "parameters_last": 1},
}  # fmt: skip
"""How a run was trained."""


def make_submission(name: str, groups: Document, title: str = "", **manifest: Any) -> Document:
    """A submission without problems."""
    facts = {
        "authors": ["A. Researcher"],
        "description": "An agent for the tests.",
        "code": {"url": "https://example.org/agent", "commit": "0123abc"},
        "protocol": {"budget": "100k", "algorithm": name, "evaluation": "sampled"},
        "hyperparameters": {"step_size": 0.01, "layers": [100, 50, 25]},
        "observes": {"task_in_training": False, "task_in_evaluation": False, "boundaries": True},
        "tuning": {"steps": 0, "tasks": []},
        "memory": {"stored_steps": 2000, "parameters_first": 12345, "parameters_last": 12345},
    }
    facts.update(manifest)
    return {
        "name": name,
        "title": title or name,
        "level": "verified",
        "problems": [],
        "manifest": facts,
        "notes": [],
        "groups": groups,
        "suites": {},
    }


def everything() -> Document:
    """Two learners, a blind agent, a task-conditioned one, one with a test budget and a refused one."""
    conditioned = {"task_in_training": True, "task_in_evaluation": True, "boundaries": True}

    def on_hopper(matrices: list[list[list[float]]], budget: str = "100k") -> Document:
        return {"hopper-gravity-v0": {"sequential": scored("hopper-gravity", matrices, budget)}}

    hopper, walker = on_hopper(learner(0.9, 0.75, 5)), scored("walker2d-gravity", learner(0.5, 0.9, 1))
    alone = scored("hopper-gravity", [[[900.0, 850.0, 1010.0, 700.0, 640.0]]] * 5, protocol="single")
    hopper["hopper-gravity-v0"]["single"] = alone
    keeper = on_hopper(learner(0.7, 0.97, 2)) | {"walker2d-gravity-v0": {"sequential": walker}}
    problem = {
        "rule": "missing-cell",
        "where": "hopper-gravity/sequential.csv, row 7",
        "message": "Run 0, stage 2 has no episode of gym_extensions/Hopper-v0.",
        "hint": "Evaluate every task after every stage.",
    }
    broken = {"level": None, "problems": [problem], "manifest": None}
    return {
        "format": 1,
        "references": {"version": "provisional", "sha256": "0f" * 32},
        "submissions": [
            make_submission("agile", hopper, "Agile"),
            make_submission("keeper", keeper, "Keeper"),
            make_submission("zero", on_hopper(blind(2)), "Zero action"),
            make_submission("oracle", copy.deepcopy(hopper), "Oracle", observes=conditioned),
            make_submission("trial", on_hopper(learner(0.9, 1, 1), budget="smoke")),
            make_submission("broken", {}, "Broken") | broken,
        ],
    }


def scores_of(document: Document, submission: int = 0) -> Document:
    """The sequential scores of a submission on the Hopper gravity group."""
    found: Document = document["submissions"][submission]["groups"]["hopper-gravity-v0"]["sequential"]
    return found


def build(document: Document, out: Path) -> None:
    """Builds the site that shows these JSON values."""
    whole = typed(document)
    build_site(whole.submissions, Render(references_of(whole), PAGES), out)


def contents(folder: Path) -> dict[str, bytes]:
    """Every file below the folder by its path."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def document() -> Document:
    """A new copy of the document of ``everything`` per test."""
    return everything()


@pytest.fixture
def make_card(document: Document) -> Make:
    """Makes a scorecard with one sequential log on hopper-gravity from the values of its runs."""
    pattern = document["submissions"][0]

    def make(
        name: str, final: list[float] | None, learning: list[float] | None = None, **facts: Any
    ) -> Document:
        card: Document = copy.deepcopy(pattern)
        card.update(name=name, title=name.title(), level=facts.pop("level", "verified"))
        budget = facts.pop("budget", "100k")
        card["manifest"].update(facts)
        scores = scores_of({"submissions": [card]})
        card["groups"] = {"hopper-gravity-v0": {"sequential": scores}}
        runs = final or [0.0] * 5
        scores.update(level=card["level"], budget=budget, runs=list(range(len(runs))))
        scores["return_matrix"] = scores["return_matrix"][:1] * len(runs)
        scores["episode_sketches"] = [[repr(value)] for value in final or []]
        scores["metrics"] |= {
            "final_performance": estimate(final) if final else missing("Every task is open."),
            "learning_performance": estimate(learning or around(0.9, len(runs))),
            "forgetting": estimate(around(0.1, len(runs))),
        }
        return card

    return make
