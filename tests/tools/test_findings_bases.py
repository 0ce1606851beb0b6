"""The part of the findings on additions to other learners: it claims nothing of agents without runs."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from gym_extensions.metrics.statistics import subtract, summary, zero_mean_p
from tools.findings import bases, findings
from tools.findings.bases import GROUPS, base_by_addition, equal_means_p, submission


def runs(*means: float) -> dict[str, list[float]]:
    """Two runs of each group, .1 above and below its mean."""
    return {group: [mean - 0.1, mean + 0.1] for group, mean in zip(GROUPS, means, strict=True)}


TRPO = {
    "trpo": runs(0.3, 0.4, 0.5),
    "reset": runs(0.1, 0.1, 0.1),
    "cloning-tuned": runs(0.6, 0.6, 0.6),
}
PPO = {
    "ppo-tuned": runs(0.2, 0.2, 0.2),
    "ppo-reset-tuned": runs(0.4, 0.4, 0.4),
    "ppo-cloning-tuned": runs(0.3, 0.3, 0.3),
}


def test_a_submission_has_the_name_of_its_base_and_addition() -> None:
    pairs = (("trpo",), ("trpo", "reset"), ("trpo", "cloning"), ("ppo",), ("ppo", "reset"))
    names = ["trpo", "reset", "cloning-tuned", "ppo-tuned", "ppo-reset-tuned"]
    assert [submission(*each) for each in pairs] == names


def test_an_effect_is_the_mean_difference_from_the_base_over_the_groups() -> None:
    table = base_by_addition(TRPO | PPO | {"online-ewc-tuned": {GROUPS[0]: [0.5, 0.5]}})
    assert table.ends["trpo"].mean == pytest.approx(0.4)
    assert table.effects["cloning"]["trpo"].mean == pytest.approx(0.2)
    # Each mean of two runs has the standard error .1; a difference .1 √2, a mean over three .1 √(2 / 3).
    half = table.effects["cloning"]["trpo"].high - 0.2
    assert half == pytest.approx(0.1 * math.sqrt(2 / 3) * 2.447, rel=1e-3)  # t(.975, 6)
    assert table.effects["reset"]["ppo"].mean == pytest.approx(0.2)
    assert table.smallest("reset") == ("TRPO", table.effects["reset"]["trpo"], ["TRPO", "PPO"])
    assert table.smallest("cloning") == ("PPO", table.effects["cloning"]["ppo"], ["TRPO", "PPO"])
    assert base_by_addition(TRPO).smallest("cloning") is None
    assert [table.addition(name) for name in ("cloning-tuned", "ppo-reset-tuned")] == ["cloning", None]
    # Effects of reset differ by .5, of cloning by .1: t of 12 degrees of freedom, standard error .1 √(4 / 3).
    assert table.same == pytest.approx({"reset": 2 * 0.0009785, "cloning": 0.40346}, rel=1e-3)
    # TRPO: reset < none < cloning; PPO: none < cloning < reset. One pair of three has the same order.
    assert table.agreement == pytest.approx({("trpo", "ppo"): -1 / 3})
    assert {"online-ewc-tuned", "packnet-tuned", "ppo-snapshots-tuned"} < set(table.missing)
    assert not {"trpo", "ppo-reset-tuned"} & set(table.missing)


def test_equal_means_of_two_are_tested_by_welch_s_t_test_and_of_more_by_his_analysis_of_variance() -> None:
    rng = np.random.default_rng(4)
    groups = [rng.normal(mean, width, size) for mean, width, size in ((0, 1, 8), (1, 3, 12), (0.5, 0.3, 5))]
    estimates = [summary(each.tolist()) for each in groups]
    assert equal_means_p(estimates[:2]) == pytest.approx(zero_mean_p(subtract(*estimates[:2])), rel=1e-9)
    assert equal_means_p(estimates) == pytest.approx(
        stats.f_oneway(*groups, equal_var=False).pvalue, rel=1e-9
    )


def test_means_without_variance_are_equal_or_not() -> None:
    constant, other = summary([1.0, 1.0]), summary([1.0, 3.0])
    assert equal_means_p([constant, constant]) == 1
    assert equal_means_p([constant, summary([2.0, 2.0])]) == 0
    assert equal_means_p([constant, other]) == pytest.approx(zero_mean_p(subtract(constant, other)))
    assert equal_means_p([constant, constant, summary([2.0, 2.0]), other]) == pytest.approx(0, abs=1e-9)


def test_the_section_names_what_has_no_runs_and_claims_nothing_of_it() -> None:
    text = (Path(findings.__file__).parent / "page.md.jinja").read_text(encoding="utf-8")
    part = text[text.index("### The same additions") : text.index("### What choosing")]
    page, names = findings.jinja().from_string(part), {"BASES": bases.BASES, "BASE_GROUPS": ["a"]}
    one, two = (page.render(bases=base_by_addition(each), **names) for each in (TRPO, TRPO | PPO))
    rows = [line for line in one.splitlines() if line.startswith("|")]
    assert {line.count("|") for line in rows} == {5}
    assert rows[3].endswith("| – | – |")
    assert "`ppo-cloning-tuned`" in one
    assert "τ" not in one
    assert "Kendall's τ between the orders of the additions on TRPO and PPO" in two
    assert "`ppo-cloning-tuned`" not in two
