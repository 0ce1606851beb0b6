"""``score --compare``: two submissions side by side, with the interval of their difference."""

from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.references import References
from gym_extensions.scoring import cli
from gym_extensions.scoring.pipeline import score_folder
from gym_extensions.scoring.ranking.boards import compare

from ...conftest import refused

Write = Callable[..., Path]


def test_compare_gives_the_interval_of_the_difference(
    make_submission: Write, known: None, capsys: pytest.CaptureFixture[str]
) -> None:
    better = lambda p, run, stage, j, e: 100.0 * stage + 10 * j + run + e / 8 + 50  # noqa: E731
    first, second = (
        make_submission(name="a", value=better, protocols=("sequential",)),
        make_submission(name="b"),
    )
    assert cli.main(["--compare", str(first), str(second)]) == 0
    assert [line.rstrip() for line in capsys.readouterr().out.splitlines()][:4] == [
        "hopper-gravity-v0, sequential, budget smoke",
        "metric                               a       b  difference    95 % interval",
        "Final performance                0.582   0.532       0.050   0.047 to 0.053",
        "Learning performance             0.382   0.332       0.050   0.047 to 0.053",
    ]


def test_compare_tells_the_problems_of_a_submission_that_has_some(
    make_submission: Write, known: None, capsys: pytest.CaptureFixture[str]
) -> None:
    first, second = make_submission(name="a"), make_submission(name="b")
    (second / "notes.txt").write_text("")
    assert cli.main(["--compare", str(first), str(second)]) == 1
    assert "notes.txt: Unexpected file." in capsys.readouterr().out


def test_compare_has_suites_and_the_joint_gap(
    make_submission: Write, known: None, capsys: pytest.CaptureFixture[str]
) -> None:
    bodies = tuple(f"{body}-gravity" for body in ("hopper", "walker2d", "halfcheetah", "humanoid"))
    pair = [make_submission(name=name, groups=bodies, protocols=("sequential", "joint")) for name in "ab"]
    assert cli.main(["--compare", *map(str, pair)]) == 0
    lines = capsys.readouterr().out.splitlines()
    at = lines.index("suite gravity, sequential, budget smoke")
    gaps = [line.split() for line in lines[at:] if line.startswith("Joint gap")]
    assert gaps[0][4:] == ["0.000", "-0.001", "to", "0.001"]


def test_submissions_without_a_common_group_cannot_be_compared(
    make_submission: Write, references: References
) -> None:
    first, second = make_submission(name="a"), make_submission(name="b", groups=("humanoid-gravity",))
    cards = [score_folder(folder, references) for folder in (first, second)]
    with refused("nothing-to-compare"):
        compare(*cards)


def test_a_comparison_by_hand(make_submission: Write, references: References) -> None:
    # With the expert 1000, p[5][j] is (500 + run) / 1000, and .05 less in b.
    higher = make_submission(name="a", value=lambda p, run, stage, j, e: 100.0 * stage + run)
    lower = make_submission(name="b", value=lambda p, run, stage, j, e: 100.0 * stage + run - 50)
    sequential, single = compare(*(score_folder(folder, references) for folder in (higher, lower)))
    assert (sequential.name, sequential.protocol, sequential.budget) == (
        "hopper-gravity-v0",
        "sequential",
        "smoke",
    )
    assert single.protocol == "single"
    first, second, difference = sequential.metrics["final_performance"]
    assert (first, second) == pytest.approx((0.5005, 0.4505))
    # Both have the runs ±.0005: s² = 5e-7, SE² = 5e-7, 2 degrees of freedom, t = 4.302653.
    half_width = 4.302653 * 5e-7**0.5
    assert difference.mean == pytest.approx(0.05)
    assert difference.low == pytest.approx(0.05 - half_width, rel=1e-6)
    assert difference.high == pytest.approx(0.05 + half_width, rel=1e-6)
