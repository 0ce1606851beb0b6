"""The tuning of the methods: no trial is repeated or half written, and scores are those worked by hand."""

import json
from collections.abc import Callable
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import msgspec
import pytest

from gym_extensions.catalog.tasks import task
from gym_extensions.references import load_references
from tools.tuning import tune
from tools.tuning.tune import Plan, Trial

Run = Callable[..., tuple[int, str]]
PLANS = sorted(tune.HERE.glob("*.jsonl"))
PLAN = Plan(
    method="l2",
    settings=[{"coefficient": 0.1}, {"coefficient": 1.0}],
    bodies=["Hopper", "HalfCheetah"],
    gravities=[0.6, 0.9],
    steps=200,
    batch_steps=100,
    num_envs=2,
    seed=2000,
    references="2",
    rule="the best",
)
PAIRS = [(0, "Hopper"), (0, "HalfCheetah"), (1, "Hopper"), (1, "HalfCheetah")]


def trial(setting: int, body: str, end_score: float = 0.5) -> Trial:
    return Trial(setting, body, [[1.0, 2.0], [3.0, 4.0]], end_score, 0.25, 7.5, "abc")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A file with the plan and no trial."""
    path = tmp_path / "l2.jsonl"
    path.write_text(json.dumps(msgspec.to_builtins(PLAN)) + "\n", "utf-8")
    return path


@pytest.fixture
def trained(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, str]]:
    """The trials that are run; the third one is interrupted when it is run first."""
    calls: list[tuple[int, str]] = []

    def run(_: Plan, setting: int, body: str) -> Trial:
        calls.append((setting, body))
        if len(calls) == 3:
            raise KeyboardInterrupt
        return trial(setting, body)

    monkeypatch.setattr(tune, "run_in_new_process", run)
    return calls


@pytest.fixture
def run(file: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """Runs the command: its exit status, and what it says."""

    def command(*names: str, commit: str = "0" * 40) -> tuple[int, str]:
        monkeypatch.setattr(tune, "commit_of", lambda _: commit)
        monkeypatch.setattr(tune, "HERE", file.parent)
        status = tune.main([*names])
        return status, "".join(capsys.readouterr())

    return command


def test_an_interrupted_command_continues_and_repeats_no_finished_trial(
    file: Path, run: Run, trained: list[tuple[int, str]]
) -> None:
    with pytest.raises(KeyboardInterrupt):
        run("l2")
    assert tune.read(file) == (PLAN, [trial(*pair) for pair in PAIRS[:2]])
    assert run("l2")[0] == 0
    assert trained == [*PAIRS[:3], *PAIRS[2:]]
    assert tune.read(file) == (PLAN, [trial(*pair) for pair in PAIRS])
    tune.tune(file)
    assert len(trained) == 5


def test_an_interrupted_append_leaves_the_file_as_it_was(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tune.append(file, trial(0, "Hopper"))
    before = file.read_bytes()

    def fails(self: Path, content: bytes) -> int:
        with self.open("wb") as out:
            out.write(content[:-9])
        raise OSError("disk full")

    monkeypatch.setattr(Path, "write_bytes", fails)
    with pytest.raises(OSError, match="disk full"):
        tune.append(file, trial(0, "HalfCheetah"))
    assert file.read_bytes() == before
    assert tune.read(file) == (PLAN, [trial(0, "Hopper")])
    assert list(file.parent.iterdir()) == [file]


def test_scores_are_means_of_normalized_returns() -> None:
    reference = load_references("2").tasks[task("Hopper").id]
    assert reference.expert is not None
    floor, span = reference.floor.mean, reference.expert.mean - reference.floor.mean
    returns = [[floor + 0.8 * span, floor + 0.1 * span], [floor + 0.4 * span, floor + 0.6 * span]]
    end, learned = tune.scores(PLAN, "Hopper", returns)
    assert end == pytest.approx((0.4 + 0.6) / 2)
    assert learned == pytest.approx((0.8 + 0.6) / 2)


def test_the_report_chooses_the_setting_with_the_best_mean_over_bodies(file: Path) -> None:
    for pair, score in zip(PAIRS[:3], (0.9, 0.1, 0.45), strict=True):
        tune.append(file, trial(*pair, end_score=score))
    assert "chosen" not in tune.report(file)
    tune.append(file, trial(*PAIRS[3], end_score=0.65))
    header, _, first, second, chosen = tune.report(file).splitlines()
    assert header == "l2: 4 of 4 trials"
    assert first.split() == ["coefficient=0.1", "0.500", "0.900", "0.100", "0.250"]
    assert second.split() == ["coefficient=1.0", "0.550", "0.450", "0.650", "0.250"]
    assert chosen == "chosen: coefficient=1.0"


def test_a_trial_has_a_row_of_returns_per_learned_task(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tools.tuning.measure_learners.EVALUATION_SEEDS", range(2))
    clock = SimpleNamespace(process_time=count().__next__)  # training takes a second per task
    monkeypatch.setattr("tools.tuning.measure_learners.time", clock)
    result = tune.run_trial(PLAN, 1, "Hopper")
    assert (result.setting, result.body) == (1, "Hopper")
    assert [len(row) for row in result.returns] == [2, 2]
    assert (result.end_score, result.learned_score) == tune.scores(PLAN, "Hopper", result.returns)
    assert result.cpu_seconds == 2


@pytest.mark.parametrize("path", PLANS, ids=lambda path: path.stem)
def test_each_method_has_eight_settings_and_the_same_tasks_and_steps(path: Path) -> None:
    plan, trials = tune.read(path)
    first, _ = tune.read(PLANS[0])
    assert plan.method == path.stem
    assert len(plan.settings) == (1 if plan.method == "trpo" else 8)  # trpo is there to compare
    assert plan == msgspec.structs.replace(first, method=plan.method, settings=plan.settings)
    assert len({(trial.setting, trial.body) for trial in trials}) == len(trials)
    for each in trials:
        assert (each.end_score, each.learned_score) == tune.scores(plan, each.body, each.returns)
