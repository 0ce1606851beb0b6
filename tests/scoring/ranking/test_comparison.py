"""``score --compare``: two submissions side by side, with the interval of their difference."""

from dataclasses import replace

import pytest

from gym_extensions.references import References
from gym_extensions.scoring.output.screen import console, show_comparison
from gym_extensions.scoring.pipeline import score_folder
from gym_extensions.scoring.ranking.boards import compare
from gym_extensions.scoring.submission.core_score import core_score

from ...conftest import GRAVITY, MANIFEST, Write, refused
from ..made_submissions import Command
from .conftest import FINAL, GROUPS, OnCore


def test_groups_and_suites_are_compared_by_every_metric_of_both(
    make_submission: Write, score: Command
) -> None:
    better = lambda p, run, stage, j, e: 100.0 * stage + 10 * j + run + e / 8 + 50  # noqa: E731
    options = {"groups": GRAVITY, "protocols": ("sequential", "joint")}
    pair = make_submission(name="a", value=better, **options), make_submission(name="b", **options)
    status, out, _ = score("--compare", *pair)
    lines = [line.rstrip() for line in out.splitlines()]
    assert (status, lines[0]) == (0, "hopper-gravity-v0, sequential, budget smoke")
    assert lines[2].split() == ["Final", "performance", "0.582", "0.532", "0.050", "0.047", "to", "0.053"]
    at = lines.index("suite gravity, sequential, budget smoke")
    gaps = [line.split() for line in lines[at:] if line.startswith("Joint gap")]
    assert gaps[0][4:] == ["0.000", "-0.001", "to", "0.001"]
    chosen = score("--compare", *pair, "--group", "hopper-gravity").out
    titles = [line for line in chosen.splitlines() if ", budget " in line]
    assert titles == [f"hopper-gravity-v0, {protocol}, budget smoke" for protocol in options["protocols"]]


def test_the_problems_of_a_submission_that_has_some_are_told(make_submission: Write, score: Command) -> None:
    first, second = make_submission(name="a"), make_submission(name="b")
    (second / "notes.txt").write_text("")
    status, out, _ = score("--compare", first, second)
    assert (status, "notes.txt: Unexpected file." in out) == (1, True)


@pytest.mark.parametrize(
    "other", [{"groups": ("humanoid-gravity",)}, {"manifest": MANIFEST.replace('"smoke"', '"100k"')}]
)
def test_submissions_without_a_common_group_and_budget_cannot_be_compared(
    other: dict[str, object], make_submission: Write, references: References
) -> None:
    folders = make_submission(name="a"), make_submission(name="b", **other)
    with refused("nothing-to-compare"):
        compare(*(score_folder(folder, references) for folder in folders))


def test_a_comparison_by_hand(make_submission: Write, references: References) -> None:
    # With the expert 1000, p[5][j] is (500 + run) / 1000, and .05 less in b.
    higher = make_submission(name="a", value=lambda p, run, stage, j, e: 100.0 * stage + run)
    lower = make_submission(name="b", value=lambda p, run, stage, j, e: 100.0 * stage + run - 50)
    sequential, single = compare(*(score_folder(folder, references) for folder in (higher, lower)))
    assert (sequential.name, sequential.budget) == ("hopper-gravity-v0", "smoke")
    assert (sequential.protocol, single.protocol) == ("sequential", "single")
    first, second, difference = sequential.metrics["final_performance"]
    assert (first, second) == pytest.approx((0.5005, 0.4505))
    # Both have the runs ±.0005: s² = 5e-7, SE² = 5e-7, 2 degrees of freedom, t = 4.302653.
    half_width = 4.302653 * 5e-7**0.5
    assert difference.mean == pytest.approx(0.05)
    assert difference.ends == pytest.approx((0.05 - half_width, 0.05 + half_width), rel=1e-6)


def test_the_core_is_compared_first_over_the_runs_that_both_have(
    on_core: OnCore, capsys: pytest.CaptureFixture[str]
) -> None:
    higher = on_core("a", dict.fromkeys(GROUPS, (0.2, 0.3, 0.4, 0.5, 0.6)))
    lower = on_core("b", dict.fromkeys(GROUPS, (0.1, 0.2, 0.3, 0.4, 0.5, 9.0, 9.0, 9.0, 9.0, 9.0)))
    core, *rest = compare(*(replace(card, core=core_score(card)) for card in (higher, lower)))
    assert (core.name, core.protocol, core.budget, core.look) == ("core-v1", "sequential", "300k", 5)
    assert [each.name for each in rest[: len(GROUPS)]] == list(GROUPS)
    first, second, difference = core.metrics[FINAL]
    # s² = .025 in every group, SE² = .025 / 5 / 7 of each, 28 degrees of freedom of each, t(56) = 2.003241.
    half_width = 2.003241 * (2 * 0.025 / 5 / 7) ** 0.5
    assert (first, second, difference.mean) == pytest.approx((0.4, 0.3, 0.1))
    assert difference.ends == pytest.approx((0.1 - half_width, 0.1 + half_width), rel=1e-6)
    show_comparison(console(), "a", "b", [core])
    assert "core-v1, sequential, budget 300k, runs 0 to 4 of every group\n" in capsys.readouterr().out


def test_without_a_complete_look_of_both_the_core_is_not_compared(on_core: OnCore) -> None:
    first, second = (on_core("a", dict.fromkeys(GROUPS, (0.5,) * runs)) for runs in (5, 4))
    found = compare(*(replace(card, core=core_score(card)) for card in (first, second)))
    assert {each.look for each in found} == {0}
