"""The pages of findings: verdicts are those of the corrected test, and every number comes from the runs."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from gym_extensions.catalog.groups import CORES
from gym_extensions.metrics.statistics import Interval
from gym_extensions.scoring.group_score import PaperCell, PaperRow
from gym_extensions.scoring.pipeline import score_folder

pytest.importorskip("matplotlib", reason="the figures need matplotlib: the extra `plot`")

from tools.findings import claims, findings, paper_statements, reproduction, tables
from tools.findings.figures import write_picture

from ..conftest import MANIFEST, Write

ROOT = Path(__file__).resolve().parents[2]
PAGES = ("docs/findings.md", "docs/reproduction.md")


def core_row(name: str) -> dict[str, object]:
    scores = {f"{metric}{end}": 0.5 for metric in tables.COLUMNS for end in ("", "_low", "_high")}
    return {"name": name, "ranked": True, "rank_first": 1, "rank_last": 2, **scores}


@pytest.mark.parametrize(("first", "second", "sign"), [("trpo", "cloning", -1), ("cloning", "trpo", 1)])
def test_a_method_is_compared_with_fine_tuning_in_this_direction(first: str, second: str, sign: int) -> None:
    facts = {"first": first, "second": second, "verdict": "separated", "exploratory": True, "p_value": 0.01}
    pair = SimpleNamespace(**facts, mean=0.2, low=0.1, high=0.4)
    pairs = {(tables.FINAL, frozenset((first, second))): pair}
    board: Any = SimpleNamespace(pair=lambda metric, *names: pairs.get((metric, frozenset(names))))
    trpo, cloning = tables.methods(pd.DataFrame([core_row("trpo"), core_row("cloning")]), board)
    expected = (0.2, 0.1, 0.4) if sign == 1 else (-0.2, -0.4, -0.1)
    assert cloning.against == {tables.FINAL: tables.Against(tables.Value(*expected), "separated", True, 0.01)}
    assert trpo.against == {}
    assert cloning.rank == "1–2"


@pytest.mark.parametrize(
    ("verdict", "exploratory", "edition", "said"),
    [
        ("separated", True, 1, "significant"),
        ("open", True, 1, "not significant"),
        ("separated", False, 2, "**significant**"),
        ("open", False, 2, "not significant"),
        ("separated", True, 2, "significant, exploratory"),
        ("equivalent", True, 2, "equivalent, exploratory"),
    ],
)
def test_bold_is_what_the_plan_names_alone(verdict: str, exploratory: bool, edition: int, said: str) -> None:
    assert tables.Against(tables.Value(0.2, 0.1, 0.3), verdict, exploratory, 0.01).said(edition) == said


def test_only_what_the_plan_tested_is_in_bold() -> None:
    readme, *pages = ((ROOT / name).read_text("utf-8") for name in ("README.md", *PAGES))
    results = readme.partition("Results so far")[2].partition("\n\n|")[0]
    tested = {"significant", "confirmed", "contradicted", "open"} if "| H1 |" in pages[0] else set()
    assert {bold for text in (results, *pages) for bold in re.findall(r"\*\*(.*?)\*\*", text)} <= tested


def forgetting(groups: dict[str, Sequence[float]]) -> dict[str, bool]:
    """Whether the corrected test finds forgetting, by group; all groups are learned."""
    frame = [
        {
            "name": "trpo",
            "group": f"{name}-v0",
            "protocol": "sequential",
            "budget": "300k",
            "runs": len(groups[name]),
        }
        | {"metric": metric, "mean": 0.5, "low": 0.4, "high": 0.6}
        for name in groups
        for metric in tables.COLUMNS
    ]
    runs = {f"{name}-v0": values for name, values in groups.items()}
    return {row.group.name: row.significant for row in tables.fine_tuning(pd.DataFrame(frame), runs)}


def test_forgetting_is_significant_from_0_after_a_correction_for_the_groups() -> None:
    # The p value of the first, .01696, is above .05 / 3 and below .05 / 2.
    weak, strong, none = (0.1, 0.2, 0.02, 0.2, 0.2), (1.0, 1.1, 1.2, 1.1, 1.0), (0.1, -0.1, 0.2, -0.2, 0.1)
    found = forgetting({"hopper-wall": weak, "walker2d-wall": strong, "hopper-body": none})
    assert found == {"hopper-wall": True, "walker2d-wall": True, "hopper-body": False}
    found = forgetting({"hopper-wall": weak, "walker2d-wall": none, "hopper-body": none})
    assert found == {"hopper-wall": False, "walker2d-wall": False, "hopper-body": False}
    found = forgetting({"hopper-wall": weak, "pusher": none, "pusher-tracking": none})
    assert found["hopper-wall"], "groups beyond the core are another family"


def test_a_group_with_fewer_runs_than_a_look_is_tested_over_all_of_them() -> None:
    found = forgetting({"hopper-wall": (1.0, 1.1, 1.2, 1.1, 1.0), "pusher": (1.0, 1.1, 1.2)})
    assert found == {"hopper-wall": True, "pusher": True}


def test_replay_needs_five_runs_of_both_kinds() -> None:
    kept, emptied = (0.0, 0.1, 0.2, 0.1, 0.1), (1.0, 1.1, 1.2, 1.1, 1.1)
    runs: dict[str, dict[str, Sequence[float]]] = {
        "sac": {"hopper-gravity-v0": kept},
        "sac-fresh-buffer": {"hopper-gravity-v0": emptied},
    }
    ((group, gap, p_value),) = tables.replay(runs)
    assert group == "hopper-gravity"
    assert gap.mean == pytest.approx(-1.0)
    assert p_value < 1e-4
    assert tables.replay(runs | {"sac": {"hopper-gravity-v0": kept[:4]}}) == []


def test_the_expected_best_of_equal_variants_is_that_of_normal_values() -> None:
    assert claims.best_of(1) == pytest.approx(0.0, abs=1e-9)
    assert claims.best_of(2) == pytest.approx(math.pi**-0.5)
    draws = np.random.default_rng(0).normal(size=(20_000, 10)).max(axis=1)
    assert claims.best_of(10) == pytest.approx(draws.mean(), abs=0.02)


def test_a_correlation_has_fishers_interval() -> None:
    first, second = np.random.default_rng(0).normal(size=(2, 7)).tolist()
    expected = stats.pearsonr(first, second)
    found = claims.correlation(first, second)
    assert found == pytest.approx((expected.statistic, *expected.confidence_interval()))


def test_a_difference_over_groups_needs_runs_in_all_of_them() -> None:
    first, second = {"a": (1.0, 2.0), "b": (4.0, 4.0)}, {"a": (0.0, 1.0), "b": (1.0, 1.0)}
    assert claims.minus(first, second, ("a", "b")).mean == pytest.approx(2.0)
    assert math.isnan(claims.minus(first, {"a": (0.0, 1.0)}, ("a", "b")).mean)


@pytest.mark.usefixtures("known")
def test_a_method_without_all_groups_of_the_core_has_no_gains(make_submission: Write) -> None:
    """As while its runs are trained here, one group after the other."""
    manifest = MANIFEST.replace("smoke", "300k")
    card = score_folder(make_submission(runs=tuple(range(5)), manifest=manifest))
    log = replace(card.groups["hopper-gravity-v0"]["sequential"], level="verified", unverified=())
    whole = replace(card, groups={name: {"sequential": log} for name in CORES["core-v1"]})
    part = replace(card, groups={"hopper-gravity-v0": {"sequential": log}})
    rows, correlated = claims.gains({"trpo": whole, "cloning": part}, "cloning")
    assert (rows, correlated.is_known) == ([], False)


def test_what_is_said_of_a_decline_and_of_an_interval() -> None:
    assert paper_statements.falling([259.0, 414.0, 300.0]) == "300 < 414 > 259"
    assert paper_statements.rises([1.0, 2.0, 3.0]) and not paper_statements.rises([1.0, 3.0, 2.0])
    up, down = paper_statements.steps([(0.0, 1.0, 0.9), (0.0, 1.2, 0.8), (0.1, 1.1, 0.9)])
    assert [up.mean, down.mean] == pytest.approx([3.2 / 3, -0.7 / 3])
    assert paper_statements.found(up) == "holds"
    above, around, below = (tables.Value(mean, mean - 1, mean + 1) for mean in (2.0, 0.0, -2.0))
    said = [paper_statements.found(above, each) for each in (above, around, below)]
    assert said == ["holds", "not found", "fails"]
    assert str(tables.Value.of(Interval(0.1, 0.0, 0.2))) == "0.10 (0.00 to 0.20)"
    assert str(tables.Value.of(Interval(0.1))) == "0.10 (one run)"


def test_the_numbers_and_words_of_the_readme_are_in_the_findings() -> None:
    paths = ("README.md", "docs/findings.md", "docs/findings/first-edition.md")
    readme, text, first = ((ROOT / path).read_text("utf-8") for path in paths)
    (section,) = findings.RESULTS.findall(readme)
    numbers = set(re.findall(r"−?\d\.\d\d", section))
    assert len(numbers) >= 8
    assert [number for number in numbers if number not in text + first] == []
    assert "lies above 0 on: none" in first


def test_without_joint_runs_the_readme_says_nothing_of_them() -> None:
    """As when the runs of the first edition have left the tree."""
    names: dict[str, Any] = {
        "edition": 2,
        "cloning": "cloning-tuned",
        "packnet": "packnet-tuned",
        "hypotheses": [],
    }
    section = findings.jinja().get_template("readme.md.jinja")
    row = pd.Series(
        {"name": "joint", "look": 5, tables.FINAL: 0.5, f"{tables.FINAL}_low": 0.4}
        | {f"{tables.FINAL}_high": 0.6}
    )
    texts = [section.render(names, known={}, other_ways=ways) for ways in ([], [tables.Method(row, {})])]
    assert ["all tasks at once" in text for text in texts] == [False, True]


@pytest.mark.committed
def test_the_landscape_of_the_readme_is_that_of_the_committed_submission(tmp_path: Path) -> None:
    (axis,) = findings.landscape(ROOT / "submissions", "cloning-tuned", "cloning").axes
    write_picture(axis.large, "landscape", tmp_path / "landscape.svg")
    committed, drawn = ((each / "landscape.svg").read_text("utf-8") for each in (findings.IMAGES, tmp_path))
    # Later submissions may change the best return, and with it tints and scale; the submission's own returns
    # stay.
    own = [re.findall(r"[\d.]+ at [\d.]+ g", text) for text in (committed, drawn)]
    assert own[0] == own[1], "run `make findings`"
    assert len(own[0]) == 7
    assert "best of all submissions" in committed


CELL = PaperCell(1000.0, 100.0)


def paper_rows(*final: float) -> list[PaperRow]:
    """Tasks with a return of 1,000 ± 100 after training on each and these at the end."""
    others: dict[str, Any] = {"after_env_training": CELL, "first_step": CELL, "single_env": CELL}
    return [
        PaperRow(f"gym_extensions/Hopper{index}-v0", fully_trained=PaperCell(value, 100.0), **others)
        for index, value in enumerate(final)
    ]


def test_an_earlier_task_of_the_paper_ends_lower_if_the_corrected_test_separates_it() -> None:
    table = reproduction.table(paper_rows(500.0, 990.0, 1500.0, 0.0))
    found = [(each.is_significant, each.is_lower) for each in table.changes]
    assert found == [(True, True), (False, False), (True, False)]
    assert table.forgotten == 1
    assert table.kept == pytest.approx(100 * 2990 / 3000)


def test_the_intervals_of_the_reproduction_are_those_of_welch_over_episodes() -> None:
    (change,) = reproduction.table(paper_rows(900.0, 1000.0)).changes
    # Two means of 20 episodes with s² = 100² · 20/19 and 38 degrees of freedom.
    error = (2 * 100.0**2 / 19) ** 0.5
    assert change.gap.high is not None
    assert change.gap.mean == pytest.approx(-100.0)
    assert change.gap.high - change.gap.mean == pytest.approx(2.0244 * error, rel=1e-4)


@pytest.mark.parametrize(
    ("is_forgotten", "final", "answer"),
    [
        (True, 500.0, "yes: 1 of 1 earlier tasks end lower, 50 % kept"),
        (True, 1000.0, "no: 0 of 1 earlier tasks end lower, 100 % kept"),
        (False, 500.0, "no: 1 of 1 earlier tasks end lower, 50 % kept"),
        (False, 1000.0, "not contradicted: 0 of 1 earlier tasks end lower, 100 % kept"),
    ],
)
def test_a_finding_of_the_paper_holds_by_the_number_of_tasks_that_end_lower(
    is_forgotten: bool, final: float, answer: str
) -> None:
    shown = reproduction.table(paper_rows(final, 1000.0))
    group = reproduction.Group("hopper-gravity", is_forgotten, "a-submission", shown, shown, shown)
    assert reproduction.verdict(group, shown) == answer
