"""The scorecard: what it holds, what is null and why, and that a score moves for nobody else."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.pipeline.score import score_folders, text
from gym_extensions.scoring.references import Reference, References, load_references, parse_references

GROUP = "hopper-gravity-v0"
Write = Callable[..., Path]


def test_the_document_key_by_key(submission: Write, references: References) -> None:
    document = score_folders([submission(curves=12)], references)
    assert list(document) == ["format", "references", "submissions"]
    assert document["format"] == 1
    assert document["references"] == {"version": "synthetic", "provisional": True, "sha256": "0" * 64}
    (card,) = document["submissions"]
    assert (card["name"], card["title"], card["trust"], card["problems"]) == (
        "entry",
        "An entry",
        "well-formed",
        [],
    )
    assert list(card["groups"]) == [GROUP]
    scored = card["groups"][GROUP]["sequential"]
    assert scored["budget"] == "smoke"
    assert scored["runs"] == [0, 1]
    assert scored["tasks"][0] == "gym_extensions/HopperGravityHalf-v0"
    assert list(scored["metrics"]) == [metric.name for metric in METRICS["sequential"]]
    assert scored["reference"]["gym_extensions/Hopper-v0"] == {"floor": 0.0, "ceiling": 1000.0, "open": False}
    assert len(scored["matrix"]) == 2
    assert len(scored["matrix"][0]) == 6
    assert len(scored["matrix"][0][0]) == 5
    assert [(one["run"], len(one["points"])) for one in scored["curves"]] == [(0, 12)] * 5 + [(1, 12)] * 5
    assert [one["task"] for one in scored["curves"][:5]] == scored["tasks"]


def test_scores_by_hand(submission: Write, references: References) -> None:
    """R[s][j] = 100 s + 10 j + run + the mean of episode / 8, which is 1.1875; p is R / 1000."""
    scored = score_folders([submission()], references)["submissions"][0]["groups"][GROUP]["sequential"]
    assert scored["matrix"][1][2][3] == 100 * 2 + 10 * 4 + 1 + 1.1875
    metrics = scored["metrics"]
    assert metrics["final_performance"]["runs"] == pytest.approx([0.5311875, 0.5321875])
    assert metrics["learning_performance"]["runs"] == pytest.approx([0.3311875, 0.3321875])
    assert metrics["forgetting"]["runs"] == pytest.approx([-0.25, -0.25])
    # In single.csv R = 100 + 10 j + run + .5 + …, at stage j in sequential.csv 100 j + 10 j + run + …
    assert metrics["forward_transfer"]["mean"] == pytest.approx((100 + 200 + 300 + 400) / 4 / 1000 - 0.0005)
    final = metrics["final_performance"]
    assert final["mean"] == pytest.approx(0.5316875)
    assert final["high"] - final["mean"] == pytest.approx(12.7062047362 * 0.0005)
    row = scored["table"][1]
    assert row["fully_trained"]["mean"] == pytest.approx(500 + 20 + 0.5 + 1.1875)
    assert row["first_step"]["mean"] == pytest.approx(100 + 20 + 0.5 + 1.1875)
    assert row["single_env"]["mean"] == pytest.approx(100 + 20 + 0.5 + 1.1875 + 0.5)
    deviation = math.sqrt(0.25 + sum((episode / 8 - 1.1875) ** 2 for episode in range(20)) / 20)
    assert row["fully_trained"]["std"] == pytest.approx(deviation)


def test_learning_is_final_plus_forgetting_of_all_but_the_last(
    submission: Write, references: References
) -> None:
    folder = submission(
        value=lambda p, run, stage, j, e: float((run * 37 + stage * 101 + j * 59 + e * 7) % 300)
    )
    metrics = score_folders([folder], references)["submissions"][0]["groups"][GROUP]["sequential"]["metrics"]
    for learning, final, forgetting in zip(
        *(metrics[name]["runs"] for name in ("learning_performance", "final_performance", "forgetting")),
        strict=True,
    ):
        assert learning - final == pytest.approx(forgetting * 4 / 5, abs=1e-12)


@pytest.mark.parametrize(
    ("changes", "metric", "why"),
    [
        (
            {"protocols": ("sequential",)},
            "forward_transfer",
            "It needs single.csv, which this entry lacks.",
        ),
        (
            {"protocols": ("sequential",)},
            "learning_speed_transfer",
            "It needs single.csv and curves.csv, which this entry lacks.",
        ),
        ({}, "joint_gap", "It needs joint.csv, which this entry lacks."),
        (
            {"curves": 9},
            "learning_speed_transfer",
            "A training curve that it needs is missing from curves.csv or has fewer than 10 points.",
        ),
    ],
)
def test_a_metric_without_its_input_is_null_and_says_why(
    changes: dict[str, object], metric: str, why: str, submission: Write, references: References
) -> None:
    card = score_folders([submission(**changes)], references)["submissions"][0]
    assert card["groups"][GROUP]["sequential"]["metrics"][metric] == {
        "mean": None,
        "low": None,
        "high": None,
        "runs": [],
        "why": why,
    }


def test_one_run_has_a_mean_and_no_interval_and_says_so(submission: Write, references: References) -> None:
    scored = score_folders([submission(runs=(3,))], references)["submissions"][0]["groups"][GROUP][
        "sequential"
    ]
    assert scored["metrics"]["final_performance"] == {
        "mean": pytest.approx(0.5341875),
        "low": None,
        "high": None,
        "runs": [pytest.approx(0.5341875)],
        "why": "One run has no interval.",
    }


def test_without_references_every_normalised_metric_is_null_and_the_returns_stay(submission: Write) -> None:
    nothing = References("provisional", True, {})
    scored = score_folders([submission()], nothing)["submissions"][0]["groups"][GROUP]["sequential"]
    assert {score["why"] for score in scored["metrics"].values()} == {
        "Benchmark version 'provisional' has no reference for 5 of 5 tasks, "
        "gym_extensions/HopperGravityHalf-v0 among them."
    }
    assert scored["table"][0]["fully_trained"]["mean"] > 0
    assert scored["profile"] is None
    assert scored["iqm"] is None


def test_a_submission_with_problems_has_no_score(submission: Write, references: References) -> None:
    folder = submission()
    (folder / "notes.txt").write_text("")
    (card,) = score_folders([folder], references)["submissions"]
    assert card["trust"] is None
    assert card["groups"] == {}
    assert card["problems"] == [
        {
            "rule": "unexpected-name",
            "where": "notes.txt",
            "message": "Unexpected file.",
            "hint": "Remove it, or rename it as described in docs/rollout-log.md.",
        }
    ]


def test_no_number_moves_when_somebody_joins(submission: Write, references: References) -> None:
    first, second = submission(name="a"), submission(name="b", value=lambda p, r, s, j, e: 5.0 * s + j + r)
    alone = score_folders([first], references)["submissions"][0]
    together = score_folders([second, first], references)["submissions"]
    assert [card["name"] for card in together] == ["a", "b"]
    assert together[0] == alone


def test_a_suite_is_the_mean_over_its_groups_and_needs_them_all(
    submission: Write, references: References
) -> None:
    bodies = tuple(f"{body}-gravity" for body in ("hopper", "walker2d", "halfcheetah", "humanoid"))
    whole = score_folders([submission(name="whole", groups=bodies)], references)["submissions"][0]
    assert sorted(whole["suites"]) == ["gravity"]
    final = whole["suites"]["gravity"]["sequential"]["metrics"]["final_performance"]
    assert final["mean"] == pytest.approx(0.5316875)
    # Four groups of equal variance: SE² = 4 · .0005² / 16, with four degrees of freedom.
    assert final["high"] - final["mean"] == pytest.approx(2.7764451052 * 0.0005 / 2)
    part = score_folders([submission(name="part", groups=bodies[:3])], references)["submissions"][0]
    assert part["suites"] == {}


def test_the_joint_gap_of_a_suite_is_the_mean_of_its_groups(
    submission: Write, references: References
) -> None:
    bodies = tuple(f"{body}-gravity" for body in ("hopper", "walker2d", "halfcheetah", "humanoid"))
    protocols = ("sequential", "single", "joint")
    card = score_folders([submission(groups=bodies, protocols=protocols)], references)["submissions"][0]
    gaps = [card["groups"][f"{body}-v0"]["sequential"]["metrics"]["joint_gap"] for body in bodies]
    whole = card["suites"]["gravity"]["sequential"]["metrics"]["joint_gap"]
    # Joint and sequential runs have a squared error of .0005² each, and two groups' runs four degrees in all.
    assert whole["mean"] == pytest.approx(sum(gap["mean"] for gap in gaps) / 4)
    assert whole["high"] - whole["mean"] == pytest.approx(2.3060041352 * 0.0005 * math.sqrt(2) / 2)
    assert "why" not in whole


def test_a_suite_names_the_groups_in_which_a_metric_has_no_value(
    submission: Write, references: References
) -> None:
    bodies = tuple(f"{body}-gravity" for body in ("hopper", "walker2d", "halfcheetah", "humanoid"))
    folder = submission(groups=bodies)
    for body in bodies[1:3]:
        (folder / body / "single.csv").unlink()
    found = score_folders([folder], references)["submissions"][0]["suites"]["gravity"]["sequential"][
        "metrics"
    ]
    assert (
        found["forward_transfer"]["why"] == "It has no value in walker2d-gravity-v0, halfcheetah-gravity-v0."
    )


def test_the_text_is_json_without_nan_and_with_sorted_keys(submission: Write, references: References) -> None:
    written = text(score_folders([submission()], references))
    assert written.endswith("}\n")
    assert json.loads(written) == score_folders([submission()], references)
    assert text(json.loads(written)) == written
    keys = [line.split('"')[1] for line in written.splitlines() if line.startswith('              "')]
    assert keys[:3] == ["average_over_training", "final_performance", "forgetting"]
    with pytest.raises(ValueError, match="JSON"):
        text({"mean": math.nan})


def test_references_are_read_and_pinned_by_their_bytes() -> None:
    data = json.dumps(
        {
            "format": 1,
            "version": "v1",
            "provisional": False,
            "tasks": {
                "gym_extensions/Hopper-v0": {
                    "floor": {"mean": 10},
                    "ceiling": {"mean": 30.5},
                    "open": False,
                },
                "gym_extensions/Humanoid-v0": {"floor": {"mean": 1}, "ceiling": None, "open": True},
            },
        }
    ).encode()
    found = parse_references(data)
    assert (found.version, found.provisional) == ("v1", False)
    assert found.tasks["gym_extensions/Hopper-v0"] == Reference(10.0, 30.5, False)
    assert found.tasks["gym_extensions/Humanoid-v0"] == Reference(1.0, None, True)
    assert found.digest != parse_references(data + b"\n").digest


@pytest.mark.parametrize(
    "reference", [(0.0, 0.0, False), (0.0, None, False), (0.0, 1.0, True), (math.nan, 1.0, False)]
)
def test_a_reference_without_a_span_is_our_own_mistake(reference: tuple[float, float | None, bool]) -> None:
    with pytest.raises(ValueError, match="reference"):
        Reference(*reference)


def test_the_current_references_can_be_loaded() -> None:
    assert load_references().version == "provisional"
