"""The scorecard: its fields, what is null and why, and that no score depends on other submissions."""

import math
from dataclasses import replace
from pathlib import Path
from shutil import rmtree

import msgspec
import numpy as np
import pytest
from scipy import stats

from gym_extensions.metrics.formulas import METRICS
from gym_extensions.metrics.values import MetricValue
from gym_extensions.references import Expert, Floor, Reference, References
from gym_extensions.scoring.group_score import GroupScore, ReferenceValue
from gym_extensions.scoring.pipeline import score_folder, score_folders
from gym_extensions.scoring.scorecard import ReferencesInfo
from gym_extensions.scoring.submission.suites import suite_scores
from gym_extensions.submissions.manifest import Observes
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import (
    Action,
    Decision,
    Review,
    read_review,
    write_review,
)
from gym_extensions.submissions.run import read_run, write_run

from ..conftest import GRAVITY, MANIFEST, VERSIONS, Write, trained_here, verification
from ..submissions.examples import edit, redigest

NAME, GROUP = "hopper-gravity", "hopper-gravity-v0"
pytestmark = pytest.mark.usefixtures("known")


def group_score(folder: Path, protocol: str = "sequential", known: References | None = None) -> GroupScore:
    """The scores of a submission on the one group of these tests."""
    return score_folder(folder, known).groups[GROUP][protocol]


def half_width(value: MetricValue) -> float:
    """Half the width of the interval."""
    assert value.mean is not None
    assert value.high is not None
    return value.high - value.mean


def value(folder: Path, metric: str, known: References | None = None) -> MetricValue:
    """A metric of the sequential runs."""
    return group_score(folder, known=known).metrics[metric]


def test_the_document_field_by_field(make_submission: Write) -> None:
    document = score_folders([make_submission(curves=12)])
    assert document.references == ReferencesInfo("synthetic", "0" * 64)
    (card,) = document.submissions
    assert (card.name, card.title, card.level, card.problems) == ("submission", "A submission", "claimed", ())
    assert card.manifest is not None
    assert card.manifest.observes == Observes(
        task_in_training=False, task_in_evaluation=False, boundaries=False
    )
    assert list(card.groups) == [GROUP]
    score, single = (card.groups[GROUP][protocol] for protocol in ("sequential", "single"))
    assert (score.budget, score.runs) == ("smoke", (0, 1))
    assert score.tasks[0] == "gym_extensions/HopperGravityHalf-v0"
    assert list(score.metrics) == [metric.name for metric in METRICS["sequential"]]
    assert score.reference["gym_extensions/Hopper-v0"] == ReferenceValue(0.0, 1000.0, False, 0.0, 0.0)
    assert np.shape(score.return_matrix) == (2, 6, 5)
    assert [(curve.run, len(curve.points)) for curve in score.curves] == [(0, 12)] * 5 + [(1, 12)] * 5
    assert tuple(curve.task for curve in score.curves[:5]) == score.tasks
    assert score.success_rates == ()  # Hopper defines no success
    first, second = score.provenance
    assert (first.run, second.run, first.policies, first.cpu_seconds) == (0, 1, True, None)
    assert first.versions["numpy"] == VERSIONS.numpy
    assert np.shape(single.return_matrix) == (2, 1, 5)
    assert single.return_matrix[1][0][2] == 100 + 10 * 3 + 1 + 0.5 + 1.1875
    assert (single.paper_table, single.paper_total) == ((), None)


def test_scores_by_hand(make_submission: Write) -> None:
    """R[s][j] = 100 s + 10 j + run + the mean of episode / 8, which is 1.1875; p is R / 1000."""
    score = group_score(make_submission())
    assert score.return_matrix[1][2][3] == 100 * 2 + 10 * 4 + 1 + 1.1875
    metrics = score.metrics
    assert metrics["final_performance"].runs == pytest.approx([0.5311875, 0.5321875])
    assert metrics["learning_performance"].runs == pytest.approx([0.3311875, 0.3321875])
    assert metrics["forgetting"].runs == pytest.approx([-0.25, -0.25])
    # Alone R = 100 + 10 j + run + .5 + …, at stage j 100 j + 10 j + run + …
    assert metrics["asymptotic_transfer"].mean == pytest.approx((100 + 200 + 300 + 400) / 4 / 1000 - 0.0005)
    final = metrics["final_performance"]
    assert final.mean == pytest.approx(0.5316875)
    assert half_width(final) == pytest.approx(12.7062047362 * 0.0005)
    fully_trained, _, first_step, single_env = score.paper_table[1].cells()
    assert fully_trained and first_step and single_env
    assert fully_trained.mean == pytest.approx(500 + 20 + 0.5 + 1.1875)
    assert first_step.mean == pytest.approx(100 + 20 + 0.5 + 1.1875)
    assert single_env.mean == pytest.approx(100 + 20 + 0.5 + 1.1875 + 0.5)
    deviation = math.sqrt(0.25 + sum((episode / 8 - 1.1875) ** 2 for episode in range(20)) / 20)
    assert fully_trained.std == pytest.approx(deviation)


def with_error(references: References, error: float) -> References:
    """The references with an error of the expert of Hopper, over 101 episodes."""
    reference = Reference(Floor(0.0), Expert(1000.0, error, 101))
    return References("x", {**references.tasks, "gym_extensions/Hopper-v0": reference})


def test_the_error_of_an_expert_enters_the_interval_of_a_score_by_the_tasks_share(
    make_submission: Write, references: References
) -> None:
    folder, known = make_submission(), with_error(references, 50.0)
    with_, without = value(folder, "final_performance", known), value(folder, "final_performance")
    # Hopper is task 3 of 5: p[5][3] is .5316875, and the error .05 of its span.
    assert with_.expert_errors == pytest.approx((0, 0, 0.5316875 * 0.05 / 5, 0, 0))
    assert (with_.mean, with_.runs, without.expert_errors) == (without.mean, without.runs, ())
    terms = [(0.0005**2, 1.0), (with_.expert_errors[2] ** 2, 100.0)]
    total = sum(square for square, _ in terms)
    df = total**2 / sum(square**2 / df for square, df in terms)
    assert half_width(with_) == pytest.approx(stats.t.ppf(0.975, df) * math.sqrt(total))
    # R rises by 100 per stage: forgetting is −.2 from stage 3 to stage 5, one of four terms.
    errors = value(folder, "forgetting", known).expert_errors
    assert errors == pytest.approx((0, 0, -0.2 * 0.05 / 4, 0, 0))


def test_the_error_of_an_expert_enters_the_interval_of_a_suite_once_per_group(
    make_submission: Write, references: References
) -> None:
    folder = make_submission(groups=GRAVITY, protocols=("single",))
    found = score_folder(folder, with_error(references, 500.0))
    whole = found.suites["gravity"]["single"].metrics["single_task_performance"]
    (error,) = filter(None, found.groups[GROUP]["single"].metrics["single_task_performance"].expert_errors)
    # The runs differ by .001, which is nothing beside the error of the expert.
    assert half_width(whole) == pytest.approx(stats.t.ppf(0.975, 100) * error / 4, rel=0.01)


@pytest.mark.parametrize(
    ("changes", "metric", "why"),
    [
        ({"protocols": ("sequential",)}, "forward_transfer_auc", "single-task runs and training curves"),
        ({}, "joint_gap", "It needs joint runs: there are none with these runs."),
        ({"curves": 9}, "forward_transfer_auc", "fewer than 10 points"),
    ],
)
def test_a_metric_without_its_input_is_null_and_says_why(
    changes: dict[str, object], metric: str, why: str, make_submission: Write
) -> None:
    found = value(make_submission(**changes), metric)
    assert (found, why in found.why) == (MetricValue(why=found.why), True)


def test_a_metric_of_two_protocols_is_over_the_runs_that_both_have(make_submission: Write) -> None:
    metrics = ("asymptotic_transfer", "forward_transfer_auc", "final_performance")
    expected = [value(make_submission(curves=20), metric) for metric in metrics]
    folder = make_submission(name="more", runs=(0, 1, 2), curves=20)
    for path in folder.glob(f"{NAME}/single/run2.*"):
        path.unlink()
    found = [value(folder, metric) for metric in metrics]
    assert found[:2] == expected[:2]
    assert [len(each.runs) for each in found] == [2, 2, 3]


def test_one_run_has_a_mean_and_no_interval_and_says_so(make_submission: Write) -> None:
    final = value(make_submission(runs=(0,)), "final_performance")
    assert final.mean == pytest.approx(0.5311875)
    assert final.runs == (final.mean,)
    assert (final.low, final.high, final.ends) == (None, None, None)
    assert final.why == "One run has no interval."


def test_without_references_every_normalised_metric_is_null_and_the_returns_stay(
    make_submission: Write,
) -> None:
    score = group_score(make_submission(), known=References("2", {}))
    (why,) = {value.why for value in score.metrics.values()}
    assert "5 of 5 tasks have no floor and expert in version 2" in why
    assert score.paper_table[0].fully_trained is not None
    assert score.paper_table[0].fully_trained.mean > 0
    assert (score.profile, score.iqm) == (None, None)


def test_a_suite_is_the_mean_over_its_groups_and_needs_them_all(make_submission: Write) -> None:
    whole = score_folder(make_submission(name="whole", groups=GRAVITY))
    assert sorted(whole.suites) == ["gravity"]
    final = whole.suites["gravity"]["sequential"].metrics["final_performance"]
    assert final.mean == pytest.approx(0.5316875)
    # Four groups of equal variance: SE² = 4 · .0005² / 16, with four degrees of freedom.
    assert half_width(final) == pytest.approx(2.7764451052 * 0.0005 / 2)
    part = score_folder(make_submission(name="part", groups=GRAVITY[:3]))
    assert part.suites == {}


def test_the_joint_gap_of_a_suite_is_the_mean_of_its_groups(make_submission: Write) -> None:
    protocols = ("sequential", "single", "joint")
    card = score_folder(make_submission(groups=GRAVITY, protocols=protocols))
    gaps = [card.groups[f"{body}-v0"]["sequential"].metrics["joint_gap"].mean for body in GRAVITY]
    gap = card.suites["gravity"]["sequential"].metrics["joint_gap"]
    # Joint and sequential runs have a squared error of .0005² each, and two groups' runs four degrees in all.
    assert gap.mean == pytest.approx(sum(mean for mean in gaps if mean is not None) / 4)
    assert half_width(gap) == pytest.approx(2.3060041352 * 0.0005 * math.sqrt(2) / 2)
    assert gap.why == ""


def test_a_suite_has_one_budget(make_submission: Write) -> None:
    groups = dict(score_folder(make_submission(groups=GRAVITY, protocols=("sequential", "joint"))).groups)
    logs = groups[GROUP]
    groups[GROUP] = logs | {"joint": replace(logs["joint"], budget="1M")}
    suites = suite_scores(groups)["gravity"]
    assert list(suites) == ["sequential"]
    assert GROUP in suites["sequential"].metrics["joint_gap"].why


def test_a_suite_names_the_groups_in_which_a_metric_has_no_value(make_submission: Write) -> None:
    folder = make_submission(groups=GRAVITY)
    for body in GRAVITY[1:3]:
        rmtree(folder / body / "single")
    metrics = score_folder(folder).suites["gravity"]["sequential"].metrics
    assert metrics["asymptotic_transfer"].why.endswith("walker2d-gravity-v0, halfcheetah-gravity-v0.")


def reviewed(folder: Path, *runs: str, **facts: object) -> None:
    """Adds a verification of these runs, as they are, to the review of a submission."""
    found, review = read(folder), read_review(folder)
    digests = {
        key: digest
        for submission in found.groups.values()
        for protocol in submission.logs
        for key, digest in submission.digests(protocol).items()
    }
    assert found.manifest is not None
    part = verification({key: digests[key] for key in runs or digests}, found.manifest.digest, **facts)
    write_review(folder, msgspec.structs.replace(review, verifications=[*review.verifications, part]))


@pytest.mark.parametrize(
    ("runs", "passed", "levels"),
    [
        pytest.param((), True, ("verified", "verified", "verified"), id="all"),
        pytest.param(("single/run0", "single/run1"), True, ("claimed", "claimed", "verified"), id="one log"),
        pytest.param(("sequential/run0",), True, ("claimed", "claimed", "claimed"), id="one run"),
        pytest.param((), False, ("claimed", "claimed", "claimed"), id="refused"),
    ],
)
def test_the_level_of_a_submission_is_the_lowest_of_its_logs(
    make_submission: Write, runs: tuple[str, ...], passed: bool, levels: tuple[str, str, str]
) -> None:
    folder = make_submission()
    reviewed(folder, *(f"{NAME}/{run}" for run in runs), passed=passed)
    card = score_folder(folder)
    logs = card.groups[GROUP]
    assert (card.level, logs["sequential"].level, logs["single"].level) == levels


def test_a_submission_whose_settings_change_is_claimed_again_and_a_change_of_prose_is_none(
    make_submission: Write,
) -> None:
    folder = make_submission()
    reviewed(folder)
    manifest = folder / "submission.toml"
    manifest.write_text(MANIFEST.replace("Made up by", "Written with"))
    assert score_folder(folder).level == "verified"
    for old, new in (("steps = 0\ntasks", "steps = 1\ntasks"), ("0.01", "0.02"), ('"formula"', '"ppo"')):
        manifest.write_text(MANIFEST.replace(old, new))
        log = score_folder(folder).groups[GROUP]["sequential"]
        assert (log.level, log.unverified) == ("claimed", (0, 1))
        assert log.why_claimed == "The settings in submission.toml changed after the verification."


def test_a_scorecard_has_what_the_review_says(make_submission: Write) -> None:
    folder = make_submission()
    found = {"episodes": 60, "repeated": 58, "difference": "run 0, stage 1: 1e-9", "p_value": 0.25}
    found |= {"runtime": "onnxruntime 1.32.0"}
    reviewed(folder, date="2026-01-02", retrained=[f"{NAME}/sequential/run1"], **found)
    card = score_folder(folder)
    (part,) = card.verifications
    assert (part.date, part.episodes, part.repeated, part.p_value) == ("2026-01-02", 60, 58, 0.25)
    assert (part.logs, part.runs, part.current) == ((f"{NAME}/sequential", f"{NAME}/single"), 4, 4)
    assert (part.difference, part.runtime) == ("run 0, stage 1: 1e-9", "onnxruntime 1.32.0")
    provenance = card.groups[GROUP]["sequential"].provenance
    assert [(run.run, run.reproduced) for run in provenance][:2] == [(0, False), (1, True)]


@pytest.mark.parametrize(
    ("actions", "state"),
    [
        ((), ("", False, 0)),
        (("accepted",), ("2026-01-01", False, 0)),
        (("accepted", "challenged"), ("2026-01-01", False, 1)),
        (("accepted", "challenged", "accepted"), ("2026-01-03", False, 0)),
        (("accepted", "withdrawn", "challenged"), ("2026-01-01", True, 1)),
        (("accepted", "withdrawn", "accepted"), ("2026-01-03", False, 0)),
    ],
)
def test_the_last_decision_holds(
    make_submission: Write, actions: tuple[Action, ...], state: tuple[str, bool, int]
) -> None:
    folder = make_submission(protocols=("joint",))
    dated = ((f"2026-01-0{day}", action) for day, action in enumerate(actions, 1))
    decisions = [Decision(action=action, by="M.", date=date, reason="") for date, action in dated]
    write_review(folder, Review(decisions=decisions))
    card = score_folder(folder)
    assert (card.accepted, card.withdrawn, len(card.challenges)) == state


def test_success_rates_are_shares_of_episodes(make_submission: Write) -> None:
    folder = make_submission(groups=("humanoid-standup-run",), protocols=("single",), runs=(0, 1))
    log = "humanoid-standup-run/single/run0.csv"
    five_of_20 = edit("false,false", "false,true", log, count=5)  # on the second task; the first has none
    redigest(five_of_20, log)(folder)
    score = score_folder(folder).groups["humanoid-standup-run-v0"]["single"]
    assert score.success_rates == (((None, 0.25, 0.0),), ((None, 0.0, 0.0),))


def test_a_log_that_is_claimed_says_why(make_submission: Write) -> None:
    def why(folder: Path) -> str:
        return score_folder(folder).groups[GROUP]["joint"].why_claimed

    folder = make_submission(protocols=("joint",))
    assert "run0 is not verified yet" in why(folder)
    bare = why(make_submission(name="bare", protocols=("joint",), policy=None))
    assert "0, 1" in bare and "policy()" in bare
    reviewed(make_submission(protocols=("joint",)))
    assert why(folder) == ""
    assert "changed" in why(make_submission(protocols=("joint",), value=lambda *key: float(sum(key[1:]))))
    assert [(each.runs, each.current) for each in score_folder(folder).verifications] == [(2, 0)]
    reviewed(folder, passed=False, date="2026-01-02")
    assert "2026-01-02 did not pass" in why(folder)


def test_no_number_moves_when_somebody_joins(make_submission: Write) -> None:
    first = make_submission(name="a")
    second = make_submission(name="b", value=lambda p, r, s, j, e: 5.0 * s + j + r)
    alone, (again, other) = score_folder(first), score_folders([second, first]).submissions
    assert (again, other.name) == (alone, "b")


def test_code_alone_has_the_scores_of_what_was_trained_of_it(make_submission: Write) -> None:
    folder = make_submission()
    expected = value(folder, "final_performance")
    trained_here(folder)
    rmtree(folder / NAME)
    card = score_folder(folder)
    log = card.groups[GROUP]["sequential"]
    assert (card.level, log.level, log.metrics["final_performance"]) == (*["trained here"] * 2, expected)
    assert card.own == {}
    assert card.training is not None
    assert (card.training.attempts, card.training.outdated) == (1, False)


def test_a_training_is_finished_on_the_day_of_its_last_run(make_submission: Write) -> None:
    folder = make_submission()
    for run in (0, 1):
        path = folder / NAME / f"sequential/run{run}.json"
        write_run(path, msgspec.structs.replace(read_run(path), date=f"2026-01-0{4 + run}"))
    trained_here(folder)
    training = score_folder(folder).training
    assert training is not None
    assert (training.date, training.finished) == ("2026-01-02", "2026-01-05")


def test_a_training_here_without_run_0_leaves_the_other_groups_as_they_are(make_submission: Write) -> None:
    folder = make_submission(manifest=MANIFEST.replace('"smoke"', '"100k"'))
    before = score_folder(folder).groups
    made = trained_here(folder) / NAME / "sequential"
    for path in made.glob("run0.*"):
        path.unlink()
    card = score_folder(folder)
    assert (card.problems, card.groups, card.own) == ((), before, {})
    rmtree(folder / NAME)
    code = score_folder(folder)
    assert (code.problems, code.groups, code.level) == ((), {}, "claimed")
    rmtree(made.parents[1])  # as long as no run has finished
    assert (score_folder(folder).problems, score_folder(folder).groups) == ((), {})


def test_runs_that_were_trained_here_take_the_place_of_an_authors_own(make_submission: Write) -> None:
    folder = make_submission(manifest=MANIFEST.replace('"smoke"', '"100k"'))
    before = score_folder(folder).groups[GROUP]
    trained_here(folder, version=2)
    card = score_folder(folder)
    found = card.groups[GROUP]
    assert (found["sequential"].level, card.own[GROUP].level) == ("trained here", "claimed")
    assert card.own == {GROUP: before["sequential"]}
    assert {name: log for name, log in found.items() if name != "sequential"} == {
        name: log for name, log in before.items() if name != "sequential"
    }
    assert found["sequential"].stages, "as of the author's runs"
    assert card.training is not None
    assert card.training.attempts == 2


def test_a_run_that_is_not_in_the_record_was_not_trained_here(make_submission: Write) -> None:
    folder = make_submission()
    trained_here(folder, runs={f"{NAME}/sequential/run0": "0" * 64})
    log = score_folder(folder).groups[GROUP]["sequential"]
    assert (log.level, log.why_claimed) == ("claimed", "The record of its training has other runs.")


def test_what_a_trained_agent_observes_is_not_what_its_author_states(make_submission: Write) -> None:
    folder = make_submission()
    manifest = trained_here(folder) / "submission.toml"
    text = manifest.read_text(encoding="utf-8")
    sees = text.replace("task_in_evaluation = false", "task_in_evaluation = true")
    manifest.write_text(sees, encoding="utf-8")
    card = score_folder(folder)
    assert card.manifest is not None
    assert card.manifest.observes.task_in_evaluation


def test_a_problem_of_what_was_trained_is_one_of_the_submission(make_submission: Write) -> None:
    folder = make_submission()
    log = trained_here(folder) / NAME / "sequential/run1.csv"
    log.write_bytes(log.read_bytes() + b"x\n")
    assert "trained/1/hopper-gravity/sequential/run1.csv" in read(folder).problems[0].where
