"""The page of findings: verdicts are those of the corrected test, and every number comes from the runs."""

from __future__ import annotations

import sys
from pathlib import Path

import pandas as pd
import pytest

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.scoring import score_folder
from gym_extensions.scoring.references import load_references
from gym_extensions.scoring.statistics.intervals import Interval, interval

from .findings_script import findings_script

ROOT = Path(__file__).resolve().parent.parent


build, comparison, costs, groups, page, retention, space, suites = map(
    findings_script, ("build", "comparison", "costs", "groups", "page", "retention", "space", "suites")
)


def rows() -> tuple[object, ...]:
    """Fine-tuning, a method that is far above it, and one that equals it."""
    low, high = (0.1, 0.2, 0.3, 0.2, 0.1), (1.1, 1.2, 1.3, 1.2, 1.1)
    table = [
        comparison.Row("trpo", "TRPO", False, (high, low, high)),
        comparison.Row("cloning", "TRPO + cloning", False, (high, high, low)),
        comparison.Row("multi-head", "TRPO + multi-head", True, (high, low, high)),
    ]
    result: tuple[object, ...] = (table[0], *comparison.with_verdicts(table[0], table[1:]))
    return result


def test_a_method_is_separated_if_the_corrected_test_rejects_equality() -> None:
    first, cloning, heads = rows()
    assert (first.final_verdict, first.forgetting_verdict) == (None, None)  # type: ignore[attr-defined]
    assert cloning.final_verdict.is_separated  # type: ignore[attr-defined]
    assert cloning.final_verdict.gap.mean == pytest.approx(1.0)  # type: ignore[attr-defined]
    assert not heads.final_verdict.is_separated  # type: ignore[attr-defined]


def test_the_page_shows_means_intervals_and_verdicts() -> None:
    text = page.render([groups.Group("hopper-gravity", rows())])
    assert "| `trpo` | 5 | 1.18 (1.08 to 1.28) | 0.18 (0.08 to 0.28) | 1.18 (1.08 to 1.28) |  |  |" in text
    assert "1.00 (0.88 to 1.12), **separated** | −1.00 (−1.12 to −0.88), **separated** |" in text
    assert "| `multi-head` (observes the task) |" in text
    assert "0.00 (−0.12 to 0.12), tie | 0.00 (−0.12 to 0.12), tie |" in text
    assert "in forgetting: 2. Separated with a higher value: 0, with a lower\none: 1. Ties: 1." in text


def test_other_learners_have_a_table_and_a_correction_of_their_own() -> None:
    low, high = (0.1, 0.2, 0.3, 0.2, 0.1), (1.1, 1.2, 1.3, 1.2, 1.1)
    names = ("trpo", "cloning", "sac", "sac-fresh-buffer", "ppo")
    table = [
        comparison.Row(name, name, False, (high, low if name == "trpo" else high, high)) for name in names
    ]
    group = groups.group_of("hopper-gravity", table)
    assert [row.name for row in group.rows] == ["trpo", "cloning"]
    assert [row.name for row in group.learners] == ["sac", "sac-fresh-buffer", "ppo"]
    methods, learners = page.render([group]).split("## Other learners")
    assert "final performance: 1. Separated with a higher value: 1" in methods
    assert "| hopper-gravity | `ppo` | 5 | 1.18 (1.08 to 1.28) |" in learners
    assert "| hopper-gravity | 0.00 (−0.12 to 0.12), tie | 0.00 (−0.12 to 0.12), tie |" in learners


def test_a_method_is_not_corrected_for_the_other_learners() -> None:
    low, higher = (0.0, 0.1, 0.2, 0.3, 0.4), (0.25, 0.35, 0.45, 0.55, 0.65)
    values = {"trpo": low, "cloning": higher, "sac": low, "sac-fresh-buffer": low, "ppo": low}
    table = [comparison.Row(name, name, False, (runs,) * 3) for name, runs in values.items()]
    assert groups.group_of("hopper-gravity", table).rows[1].final_verdict.is_separated
    assert not comparison.with_verdicts(table[0], table[1:])[0].final_verdict.is_separated


def test_without_both_kinds_of_sac_replay_is_not_compared() -> None:
    values = ((1.1, 1.2, 1.3, 1.2, 1.1),) * 3
    table = [comparison.Row(name, name, False, values) for name in ("trpo", "sac")]
    group = groups.group_of("hopper-gravity", table)
    assert group.replay is None
    assert "## Other learners" in page.render([group])
    assert "A replay buffer kept or emptied" not in page.render([group])
    assert not group.is_compared


def test_the_page_names_what_has_not_been_trained() -> None:
    text = page.render([groups.Group("hopper-gravity", rows())])
    table = text.partition("## What has not been trained yet")[2].splitlines()
    (missing,) = [line for line in table if line.startswith("| hopper-gravity |")]
    assert "`packnet`" in missing
    assert "`cloning`" not in missing
    assert "| walker2d-gravity | any agent | 0.30 |" in table


def test_the_cost_of_an_entry_is_that_of_its_training_steps() -> None:
    # 8 tasks × 300,000 steps × 5 runs, in millions, × 108 seconds.
    assert costs.hours("hopper-body") == "0.36"
    assert costs.hours("nav-image") == "212"
    for group in GROUPS.values():
        assert float(costs.hours(group.name)) > 0


def test_a_group_without_another_method_has_no_table_of_its_own() -> None:
    text = page.render([groups.Group("hopper-wall", rows()[:1])])
    assert "| hopper-wall | 5 | 1.18 (1.08 to 1.28) |" in text
    assert "### hopper-wall" not in text
    assert "| hopper-wall | any method beside `trpo` | 0.09 |" in text


def test_forgetting_is_separated_from_0_after_a_correction_for_the_groups() -> None:
    # The p value of the first, .01696, is above .05 / 3 and below .05 / 2.
    weak, strong, none = (0.1, 0.2, 0.02, 0.2, 0.2), (1.0, 1.1, 1.2, 1.1, 1.0), (0.1, -0.1, 0.2, -0.2, 0.1)
    separated = comparison.separated_from_zero
    assert separated({"weak": weak, "strong": strong, "none": none}) == {"strong", "weak"}
    assert separated({"weak": weak, "none": none, "other": none}) == set()
    text = page.render([groups.Group("hopper-gravity", rows())])
    assert (
        "| hopper-gravity | 5 | 1.18 (1.08 to 1.28) | 0.18 (0.08 to 0.28) | 1.18 (1.08 to 1.28) | yes | yes |"
        in text
    )


def test_a_group_whose_tasks_are_all_unsolved_is_trained_and_has_no_score() -> None:
    text = page.render([groups.Group("hopper-gravity", rows())], ["striker"])
    assert "No score, because the reference agent learned no task of the group: striker." in text
    assert "| striker | any agent |" not in text


def test_a_group_that_fine_tuning_does_not_learn_is_named_outside_the_table() -> None:
    low, high = (-1.1, -1.2, -1.0, -1.2, 0.1), (1.1, 1.2, 1.3, 1.2, 1.1)
    unlearned = groups.Group("nav-state", (comparison.Row("trpo", "TRPO", False, (low, low, high)),))
    learned = groups.Group("hopper-gravity", rows())
    text = page.render([unlearned, learned])
    assert "Fine-tuning does not learn nav-state: its score is −0.88 (−1.57 to −0.19) right after" in text
    assert "| nav-state |" not in text.split("## What has not been trained")[0]
    assert "does not learn hopper-gravity" not in text


def test_transfers_are_shown_where_they_have_a_value() -> None:
    module = sys.modules["transfer"]
    value = interval((0.5, 0.6, 0.7))
    transfers = [
        module.Transfer("pusher", (None,) * 5),
        module.Transfer("hopper-wall", (value, None, None, None, None)),
        module.Transfer("hopper-gravity", (value, value, value, None, None)),
    ]
    text = page.render([groups.Group("hopper-gravity", rows())], transfers=transfers)
    table = text.split("## Whether earlier tasks help")[1].split("\n\n")[2]
    assert table.splitlines()[2:] == [
        "| hopper-gravity | 0.60 (0.35 to 0.85) | 0.60 (0.35 to 0.85) | 0.60 (0.35 to 0.85) | – | – |",
        "| hopper-wall | 0.60 (0.35 to 0.85) | – | – | – | – |",
    ]
    assert "Whether earlier tasks help" not in page.render([groups.Group("pusher", rows())])


def test_the_figure_shows_the_groups_whose_intervals_lie_farthest_above_0() -> None:
    lows = {"hopper-gravity": 0.2, "pusher": -0.1, "hopper-wall": 0.1, "striker": 0.4, "a": 0.3, "b": 0.5}
    intervals = {name: Interval(1.0, low, 2.0) for name, low in lows.items()}
    one_run = {"walker2d-wall": Interval(3.0, None, None)}
    assert retention.most_forgotten(intervals | one_run) == ["hopper-gravity", "striker", "a", "b"]
    assert retention.most_forgotten(one_run) == []


def test_the_figure_has_scores_of_the_tasks_that_have_one() -> None:
    references = load_references().tasks
    hopper, wall = (f"gym_extensions/{name}-v0" for name in ("Hopper", "HalfCheetahWall"))
    assert references[wall].unsolved
    floor, reference = references[hopper].floor, references[hopper].ceiling
    frame = pd.DataFrame({"task": [hopper, wall, hopper], "return": [floor, 5.0, reference]})
    scores = retention.as_scores(frame, references)
    assert scores.to_dict("list") == {"task": [hopper, hopper], "return": [0.0, 1.0]}


def test_names_in_a_legend_are_cut_between_words() -> None:
    cut = sys.modules["figures"]._without_common_words
    assert cut(["HopperWithSensor", "HopperWall"]) == ["WithSensor", "Wall"]
    assert cut(["HalfCheetahGravityHalf", "HalfCheetah"]) == ["GravityHalf", "HalfCheetah"]


def test_without_an_entry_of_fine_tuning_the_page_says_so() -> None:
    assert "No group has an entry of `trpo` with five runs at 300k yet." in page.render([])


def test_a_folder_that_does_not_exist_is_refused_and_the_page_stays(tmp_path: Path) -> None:
    page = build.PAGE.read_bytes()
    with pytest.raises(SystemExit, match="absent: no such folder"):
        build.main(tmp_path / "absent")
    assert build.PAGE.read_bytes() == page


def test_a_group_names_its_unsolved_tasks() -> None:
    text = page.render([groups.Group("hopper-gravity", rows())], unsolved={"hopper-gravity": ["Hopper"]})
    assert "Scores of hopper-gravity leave out Hopper, which the reference agent did not learn." in text


def test_the_unsolved_tasks_are_those_of_the_references() -> None:
    tasks = groups.unsolved_tasks()
    assert tasks["halfcheetah-wall"] == ["HalfCheetahWall"]
    assert "hopper-gravity" not in tasks


def test_only_reference_agents_that_learn_with_todays_settings_are_compared() -> None:
    assert {"trpo", "cloning", "sac"} <= groups.COMPARED
    assert not {"random", "zero", "trpo-2017"} & groups.COMPARED


def test_the_page_says_what_the_entries_take() -> None:
    taken = space.Space(200, 183.25, ("hopper-gravity", 3.14), ("halfcheetah-gravity", 9.26))
    text = page.render([groups.Group("hopper-gravity", rows())], space=taken)
    assert "they have 183.2 MB." in text
    assert "take\nfrom 3.1 MB (hopper-gravity) to 9.3 MB (halfcheetah-gravity)." in text


def test_suites_of_fine_tuning_have_a_table() -> None:
    values = (Interval(1.5, 1.0, 2.0), Interval(1.25, 1.0, 1.5), Interval(0.25, 0.125, 0.375))
    suite = suites.Suite("gravity", ("hopper-gravity", "humanoid-gravity"), values)
    text = page.render([groups.Group("hopper-gravity", rows())], suites=[suite])
    row = "| gravity | hopper-gravity, humanoid-gravity | 1.50 (1.00 to 2.00) | 1.25 (1.00 to 1.50) |"
    assert row in text
    assert "| suite |" not in page.render([groups.Group("hopper-gravity", rows())])


def test_a_suite_at_another_budget_or_without_a_score_is_left_out() -> None:
    card = score_folder(ROOT / "submissions" / "trpo")
    found = {suite.name: suite for suite in suites.suites_of(card, "300k")}
    assert {"gravity", "wall"} <= set(found)
    assert "arm" not in found  # Striker is unsolved
    assert found["gravity"].groups[-1] == "humanoid-gravity"
    assert list(suites.suites_of(card, "1M")) == []
