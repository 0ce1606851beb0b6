"""The pages of findings: verdicts are those of the corrected test, and every number comes from the runs."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pandas as pd
import pytest

from gym_extensions.scoring.references import load_references
from gym_extensions.scoring.statistics import Interval

pytest.importorskip("matplotlib", reason="the figures need matplotlib: the extra `plot`")
ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "findings"


def findings_script(name: str) -> ModuleType:
    """The module of ``docs/findings/<name>.py``."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))
        spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        patch.setitem(sys.modules, name, module)
        spec.loader.exec_module(module)
    return module


build, comparison, costs, groups, page, retention, transfer, reproduction = map(
    findings_script,
    ("build", "comparison", "costs", "groups", "page", "retention", "transfer", "reproduction"),
)
LOW, HIGH = (0.1, 0.2, 0.3, 0.2, 0.1), (1.1, 1.2, 1.3, 1.2, 1.1)


def rows(*names: str) -> list[object]:
    """Entries that learn and forget; cloning does not forget."""
    return [
        comparison.Row(name, name, False, (HIGH, HIGH if name != "trpo" else LOW, HIGH)) for name in names
    ]


def test_a_method_is_separated_if_the_corrected_test_rejects_equality() -> None:
    first = comparison.Row("trpo", "TRPO", False, (HIGH, LOW, HIGH))
    better = comparison.Row("cloning", "TRPO + cloning", False, (HIGH, HIGH, LOW))
    cloning, equal = comparison.with_verdicts(first, [better, first])
    assert cloning.final_verdict.is_separated
    assert cloning.final_verdict.gap.mean == pytest.approx(1.0)
    assert not equal.final_verdict.is_separated


def test_methods_and_other_learners_are_two_families_of_tests() -> None:
    low, higher = (0.0, 0.1, 0.2, 0.3, 0.4), (0.25, 0.35, 0.45, 0.55, 0.65)
    values = {"trpo": low, "cloning": higher, "sac": low, "sac-fresh-buffer": low, "ppo": low}
    table = [comparison.Row(name, name, False, (runs,) * 3) for name, runs in values.items()]
    group = groups.group_of("hopper-gravity", table)
    assert [row.name for row in group.rows] == ["trpo", "cloning"]
    assert [row.name for row in group.learners] == ["sac", "sac-fresh-buffer", "ppo"]
    assert group.rows[1].final_verdict.is_separated
    assert not comparison.with_verdicts(table[0], table[1:])[0].final_verdict.is_separated


def test_without_both_kinds_of_sac_replay_is_not_compared() -> None:
    assert groups.group_of("hopper-gravity", rows("trpo", "sac")).replay is None
    assert groups.group_of("hopper-gravity", rows("trpo", "sac", "sac-fresh-buffer")).replay is not None


def test_forgetting_is_separated_from_0_after_a_correction_for_the_groups() -> None:
    # The p value of the first, .01696, is above .05 / 3 and below .05 / 2.
    weak, strong, none = (0.1, 0.2, 0.02, 0.2, 0.2), (1.0, 1.1, 1.2, 1.1, 1.0), (0.1, -0.1, 0.2, -0.2, 0.1)
    separated = comparison.separated_from_zero
    assert separated({"weak": weak, "strong": strong, "none": none}) == {"strong", "weak"}
    assert separated({"weak": weak, "none": none, "other": none}) == set()


def test_the_page_shows_means_intervals_verdicts_and_what_is_missing() -> None:
    text = page.render([groups.group_of("hopper-gravity", rows("trpo", "cloning"))], ["striker"])
    assert "| `trpo` | 5 | 1.18 (1.08 to 1.28) | 0.18 (0.08 to 0.28) | 1.18 (1.08 to 1.28) |  |  |" in text
    assert "1.00 (0.88 to 1.12), **separated** |" in text
    table = text.partition("## What has not been trained yet")[2].splitlines()
    (missing,) = [line for line in table if line.startswith("| hopper-gravity |")]
    assert "`packnet`" in missing
    assert "`cloning`" not in missing
    assert "every task of the group is open: striker." in text


def test_a_group_that_fine_tuning_does_not_learn_is_named_outside_the_table() -> None:
    low = (-1.1, -1.2, -1.0, -1.2, 0.1)
    unlearned = groups.Group("nav-state", (comparison.Row("trpo", "TRPO", False, (low, low, HIGH)),))
    text = page.render([unlearned, groups.group_of("hopper-gravity", rows("trpo"))])
    assert "Fine-tuning does not learn nav-state: its score is −0.88 (−1.57 to −0.19)" in text
    assert "| nav-state |" not in text.split("## What has not been trained")[0]


def test_without_an_entry_of_fine_tuning_the_page_says_so() -> None:
    assert "No group has an entry of `trpo` with five runs at 300k yet." in page.render([])


def test_the_cost_of_an_entry_is_that_of_its_training_steps() -> None:
    # 8 tasks × 300,000 steps × 5 runs, in millions, × 108 seconds.
    assert costs.hours("hopper-body") == "0.36"


def test_the_figure_shows_the_groups_whose_intervals_lie_farthest_above_0() -> None:
    lows = {"hopper-gravity": 0.2, "pusher": -0.1, "hopper-wall": 0.1, "striker": 0.4, "a": 0.3, "b": 0.5}
    intervals = {name: Interval(1.0, low, 2.0) for name, low in lows.items()}
    one_run = {"walker2d-wall": Interval(3.0, None, None)}
    assert retention.most_forgotten(intervals | one_run) == ["hopper-gravity", "striker", "a", "b"]


def test_the_figure_has_scores_of_the_tasks_that_have_one() -> None:
    references = load_references().tasks
    hopper, striker = (f"gym_extensions/{name}-v0" for name in ("Hopper", "Striker"))
    assert references[striker].open
    floor, expert = references[hopper].floor, references[hopper].expert
    frame = pd.DataFrame({"task": [hopper, striker, hopper], "return": [floor, 5.0, expert]})
    assert retention.as_scores(frame, references)["return"].to_list() == [0.0, 1.0]


def test_what_the_readme_says_is_separated_in_the_findings() -> None:
    """The README has no numbers; its words are verdicts of this page."""
    text = (ROOT / "docs/findings.md").read_text("utf-8")

    def line(heading: str, name: str) -> list[str]:
        section = text.partition(f"{heading}\n")[2]
        (found,) = re.findall(rf"^\| {re.escape(name)} \|.*$", section.partition("\n## ")[0], re.MULTILINE)[
            :1
        ]
        return [cell.strip() for cell in found.strip("|").split("|")]

    forgetting = re.findall(r"^\| (\S+) \| \d+ \|.* (yes|no) \| (yes|no) \|$", text, re.MULTILINE)
    assert [group for group, _, separated in forgetting if separated == "yes"] == [
        "hopper-gravity",
        "hopper-noisy-wall",
    ]
    assert sum(excludes == "no" for _, excludes, _ in forgetting) > len(forgetting) / 2
    assert "**separated**" in line("### hopper-gravity", "`cloning`")[5]
    for group in ("halfcheetah-gravity", "halfcheetah-wall"):
        section = re.split(r"\n##+ ", text.partition(f"### {group}\n")[2])[0]
        verdicts = [row.split("|")[6] for row in re.findall(r"^\| `.*$", section, re.MULTILINE)]
        assert not any("separated" in verdict for verdict in verdicts)
    for group in ("hopper-gravity", "halfcheetah-gravity"):
        _, final, lost = line("### A replay buffer kept or emptied", group)
        assert "tie" in final
        assert lost.startswith("−") and "**separated**" in lost


CELL = reproduction.PaperCell(1000.0, 100.0)


def paper_rows(*final: float) -> list[object]:
    """Tasks with a return of 1,000 ± 100 after training on each and these at the end."""
    return [
        reproduction.PaperRow(
            f"gym_extensions/Hopper{index}-v0",
            fully_trained=reproduction.PaperCell(value, 100.0),
            after_env_training=CELL,
            first_step=CELL,
            single_env=CELL,
        )
        for index, value in enumerate(final)
    ]


def test_an_earlier_task_of_the_paper_ends_lower_if_the_corrected_test_separates_it() -> None:
    table = reproduction.table(paper_rows(500.0, 990.0, 1500.0, 0.0))
    assert [(each.is_separated, each.is_lower) for each in table.changes] == [
        (True, True),
        (False, False),
        (True, False),
    ]
    assert (table.forgotten, table.kept) == (1, pytest.approx(100 * 2990 / 3000))


def test_the_intervals_of_the_reproduction_are_those_of_welch_over_episodes() -> None:
    (change,) = reproduction.table(paper_rows(900.0, 1000.0)).changes
    # Two means of 20 episodes with s² = 100² · 20/19 and 38 degrees of freedom.
    error = (2 * 100.0**2 / 19) ** 0.5
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
    group = reproduction.Group("hopper-gravity", is_forgotten, "an-entry", shown, shown)
    assert reproduction.verdict(group, shown) == answer
