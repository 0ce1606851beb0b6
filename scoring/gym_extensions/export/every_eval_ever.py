"""Scorecards as records of Every Eval Ever, one JSON file per submission, in version 0.3.0 of its schema.

The schema is at https://github.com/evaleval/every_eval_ever. Its records were made for language models: what
has no place there (protocol, budget, level) is in the ``additional_details``, whose values are texts.
"""

from __future__ import annotations

import hashlib
import json
import re
import time
import uuid
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gym_extensions.errors import BenchError
from gym_extensions.files import write_text
from gym_extensions.metrics.formulas import BOARD_METRICS, NOT_RANKED, Metric
from gym_extensions.metrics.values import MetricValue
from gym_extensions.references import References
from gym_extensions.scoring.output.board_frames import scores
from gym_extensions.scoring.pipeline import make_scorer, valid_scorecards
from gym_extensions.scoring.scorecard import GroupScore, Scorecard, SuiteScore
from gym_extensions.submissions.review import REPORTED
from gym_extensions.versions import version

SCHEMA = "0.3.0"
NAME = "gym-extensions"


def write_records(folder: Path, submissions: Sequence[Path], groups: Sequence[str] = ()) -> int:
    """Writes ``data/gym-extensions/DEVELOPER/SUBMISSION/UUID.json`` for every submission with a metric.

    All groups are exported if none is named. Returns the number of records.

    Raises:
        BenchError: a path or group does not exist, a submission has problems, or none has a metric.
    """
    scorer = make_scorer(only=groups)
    count = 0
    for card in valid_scorecards(submissions, scorer).values():
        if content := record(card, scorer.references, int(time.time())):
            developer, _, name = content["model_info"]["id"].partition("/")
            digest = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).digest()
            file = f"{uuid.UUID(bytes=digest[:16], version=4)}.json"  # depends on the content alone
            target = folder / "data" / NAME / developer / name / file
            write_text(target, json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
            count += 1
    if not count:
        raise BenchError(
            "nothing-to-export", "No submission has a metric.", str(submissions[0]), "See score."
        )
    return count


def record(card: Scorecard, references: References, now: int) -> dict[str, Any] | None:
    """The record of a valid scorecard, or None if it has no value; ``now`` is in seconds since 1970."""
    results = [
        _result(name, protocol, score, metric, value)
        for name, protocol, score in scores(card)
        for metric in BOARD_METRICS[protocol]
        if (value := score.metrics[metric.name]).mean is not None and metric.better != NOT_RANKED
    ]
    if not results or card.manifest is None:
        return None
    authors = card.manifest.authors
    name = authors[0] if authors else NAME
    developer = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-") or "unknown"
    reported = card.level == REPORTED
    runs = [run for group in card.groups.values() for score in group.values() for run in score.provenance]
    doubts = {"decisions": "\n".join(card.doubts)} if card.doubts else {}
    is_open = bool(runs) and all(run.policies for run in runs)
    return {
        "schema_version": SCHEMA,
        "evaluation_id": f"{NAME}/{developer}/{card.name}/{now}",
        "retrieved_timestamp": str(now),
        "source_metadata": {
            "source_name": NAME,
            "source_type": "documentation" if reported else "evaluation_run",
            "source_organization_name": NAME,
            "evaluator_relationship": "other" if reported else "first_party",
            "additional_details": {"level": str(card.level), "references": references.version, **doubts},
        },
        "eval_library": {"name": NAME, "version": version(NAME)},
        "model_info": {
            "name": card.title,
            "id": f"{developer}/{card.name}",
            "developer": name,
            "additional_details": {
                "deployment_type": "self_deployed",
                "model_availability": "open_weights" if is_open else "unknown",
                "authors": ", ".join(authors),
                "algorithm": card.manifest.protocol.algorithm,
                "code": f"{card.manifest.code.url} {card.manifest.code.commit}".strip(),
            },
        },
        "evaluation_results": results,
    }


def _result(
    name: str, protocol: str, score: GroupScore | SuiteScore, metric: Metric, value: MetricValue
) -> dict[str, Any]:
    details: dict[str, Any] = {"score": value.mean}
    if value.ends is not None:
        low, high = value.ends
        interval = {"lower": low, "upper": high, "confidence_level": 0.95, "method": "Student's t over runs"}
        details["uncertainty"] = {"confidence_interval": interval}
        if value.runs:
            details["uncertainty"]["num_samples"] = len(value.runs)
    tasks = score.tasks if isinstance(score, GroupScore) else score.groups
    return {
        "evaluation_result_id": f"{name}/{protocol}/{metric.name}",
        "evaluation_name": f"{name}, {protocol}",
        "source_data": {
            "dataset_name": name,
            "source_type": "other",
            "additional_details": {"tasks": ", ".join(tasks), "protocol": protocol, "budget": score.budget},
        },
        "metric_config": {
            "evaluation_description": metric.formula,
            "metric_id": f"gym_extensions.{metric.name}",
            "metric_name": metric.title,
            "metric_unit": "normalized return: 0 = floor, 1 = expert",
            "lower_is_better": metric.better == "lower",
            "score_type": "continuous",
            "min_score": "-Infinity",
            "max_score": "Infinity",
        },
        "score_details": details,
    }
