"""The ``score`` command: what it prints, its exit status, and that nobody ever reads a traceback."""

import io
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest

from gym_extensions.errors import working
from gym_extensions.metrics.formulas import METRICS, TABLE
from gym_extensions.scoring import cli
from gym_extensions.scoring.output.screen import console, show
from gym_extensions.scoring.scorecard import CoreScore, Scorecard
from gym_extensions.submissions.review import Decision, Review, read_review, write_review

from ..conftest import GRAVITY, MANIFEST, Write, trained_here
from .made_submissions import Command

GROUP_SCREEN = """\
submission  A submission  (claimed)
  claimed: hopper-gravity/sequential/run0 is not verified yet.

hopper-gravity-v0, sequential, budget smoke, 2 runs, claimed
metric                 mean   95 % interval
Final performance     1.117  1.110 to 1.123
Learning performance  3.001  2.995 to 3.008
Forgetting            2.356  2.356 to 2.356
Asymptotic transfer   2.356  2.356 to 2.356
Joint gap: none. It needs joint runs: there are none with these runs.
                                  Fully  After Env     First       Single
task, mean ± deviation          Trained   Training      Step          Env
HopperGravityHalf               178 ± 1   3001 ± 1  1501 ± 1     3001 ± 1
HopperGravityThreeQuarters      301 ± 1   3001 ± 1  1501 ± 1     1501 ± 1
Hopper                          601 ± 1   3001 ± 1  1501 ± 1      601 ± 1
HopperGravityOneAndQuarter     1501 ± 1   3001 ± 1  1501 ± 1      301 ± 1
HopperGravityOneAndHalf        3001 ± 1   3001 ± 1  1501 ± 1      178 ± 1
total                       1117 ± 1050   3001 ± 1  1501 ± 1  1117 ± 1050
· forgets HopperGravityHalf most: 3001 → 178
· earlier tasks help HopperGravityOneAndHalf most: 178 alone, 3001 after them

hopper-gravity-v0, single, budget smoke, 2 runs, claimed
metric                    mean   95 % interval
Single-task performance  1.117  1.110 to 1.123
All metrics: --json or --csv.
"""


def test_a_submission_with_one_group_is_shown_in_full(make_submission: Write, score: Command) -> None:
    folder = make_submission(value=lambda p, run, stage, j, e: 3000.0 / (1 + (stage - j) ** 2) + run + e / 10)
    status, out, _ = score(folder)
    # Somebody may add a metric to the table that is declared for the screen; any other line is a fault.
    added = [each.title for each in TABLE if "screen" in each.shown and each.title not in GROUP_SCREEN]
    is_added = tuple(f"{title} " for title in added)
    shown = [line.rstrip() for line in out.splitlines() if not line.startswith(is_added)]
    assert (status, shown) == (0, [*GROUP_SCREEN.splitlines(), ""])


def test_a_submission_with_many_groups_is_one_screen_and_group_shows_one(
    make_submission: Write, score: Command
) -> None:
    folder = make_submission(groups=GRAVITY)
    shown = score(folder).out
    assert len(shown.splitlines()) <= 24
    assert "suite gravity" in shown
    assert ["sequential", "single"] in map(str.split, shown.splitlines())  # the protocols that have runs
    assert "--group hopper-gravity-v0" in shown
    for name in ("walker2d-gravity", "walker2d-gravity-v0"):
        shown = score(folder, "--group", name).out
        assert "walker2d-gravity-v0, sequential" in shown
        assert "hopper-gravity" not in shown
    status, _, said = score(folder, "--group", "walker-gravity")
    assert (status, "walker2d-gravity" in said) == (2, True)


def test_the_core_score_is_printed_with_its_interval(capsys: pytest.CaptureFixture[str]) -> None:
    made = {"parent": "a", "look": 5, "next_look": 10, "groups": {}, "cost": {}, "trained_here": True}
    kept = {"final_performance": {"mean": 0.5, "low": 0.4, "high": 0.6}}
    core = msgspec.convert({**made, "metrics": kept}, CoreScore)
    card = Scorecard(name="a", title="A", level="verified", manifest=None, groups={}, suites={}, core=core)
    show(console(), card, chosen=True)
    shown = capsys.readouterr().out
    assert "core, runs 0 to 4 of every group, trained here\n" in shown
    assert re.search(r"Final performance +0\.500  0\.400 to 0\.600", shown)


def test_a_group_shows_the_runs_that_were_trained_here(make_submission: Write, score: Command) -> None:
    folder = make_submission(manifest=MANIFEST.replace('"smoke"', '"100k"'), protocols=("sequential",))
    trained_here(folder)
    lines = [line for line in score(folder).out.splitlines() if line.startswith("hopper-gravity-v0")]
    assert [line.rpartition(", ")[2] for line in lines] == ["trained here"]


def test_code_without_runs_waits_for_the_merge(tmp_path: Path, score: Command) -> None:
    (tmp_path / "agent").mkdir()
    (tmp_path / "agent/agent.py").write_text("make = None\n", encoding="utf-8")
    manifest = f'{MANIFEST}\n[agent]\nentry = "agent.py:make"\n'
    (tmp_path / "submission.toml").write_text(manifest, encoding="utf-8")
    status, out, _ = score(tmp_path)
    assert (status, "the project trains its code after the merge" in out) == (0, True)


def test_the_review_is_told(make_submission: Write, score: Command) -> None:
    folder = make_submission(verified=True, protocols=("joint",))
    review = read_review(folder)
    doubt = Decision(action="challenged", by="M.", date="2026-01-02", reason="Too good.")
    write_review(folder, Review(verifications=review.verifications, decisions=[doubt]))
    lines = score(folder).out.splitlines()
    assert lines[0] == "submission  A submission  (verified)"
    assert "agrees on new seeds (p = 0.5)" in lines[1]
    assert lines[2].endswith("challenged on 2026-01-02: Too good.")
    slow = msgspec.structs.replace(review.verifications[0], passed=False, undecided="undecided: too slow")
    write_review(folder, Review(verifications=[slow]))
    told = score(folder).out.splitlines()[1]
    assert told == "  verification of 2026-11-26: 2 runs, undecided: too slow"
    write_review(folder, Review(decisions=[doubt, msgspec.structs.replace(doubt, action="withdrawn")]))
    assert "withdrawn from all boards on 2026-01-02: Too good." in score(folder).out.splitlines()[1]


def test_problems_are_told_with_rule_place_and_what_to_do(make_submission: Write, score: Command) -> None:
    folder = make_submission()
    (folder / "notes.txt").write_text("")
    status, out, _ = score(folder)
    head, problem, hint, _ = out.splitlines()
    assert (status, head) == (1, "submission  A submission  (1 problem)")
    assert problem == "  unexpected-name  notes.txt: Unexpected file."
    assert hint.startswith("    Remove it, or rename it")


def test_json_is_the_document_and_csv_has_a_row_for_every_metric(
    make_submission: Write, known: None, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    folder = str(make_submission())
    assert cli.main([folder, "--json"]) == 0
    assert json.loads(capfdbinary.readouterr().out)["submissions"][0]["level"] == "claimed"
    assert cli.main([folder, "--csv"]) == 0
    rows = capfdbinary.readouterr().out.decode().splitlines()
    assert rows[0] == "name,level,group,protocol,budget,runs,metric,mean,low,high,why"
    assert len(rows) == 1 + len(METRICS["sequential"]) + 1


def test_a_folder_of_submissions_gives_a_line_each(
    make_submission: Write, tmp_path: Path, score: Command
) -> None:
    for name in "dcba":
        make_submission(name=name, protocols=("single",))
    (tmp_path / "README.md").write_text("not a submission")
    lines = "".join(f"{name}  A submission  (claimed)\n" for name in "abcd")
    assert score(tmp_path) == (0, lines, "")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ("", "name at least one FOLDER, or two with --compare"),
        ("x --jobs 0", "--jobs takes a number from 1"),
        ("x --json --csv", "argument --csv: not allowed with argument --json"),
        ("--compare a b --csv", "--compare takes two submissions"),
        ("x --compare a b", "--compare takes two submissions"),
        ("x --group hopper-gravity --out y", "--out writes whole submissions"),
    ],
)
def test_misuse_exits_2(arguments: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(arguments.split())
    assert stopped.value.code == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["nowhere"], ["--compare", ".", "nowhere"], ["nowhere", "--json"]])
def test_a_path_that_does_not_exist_exits_2(
    arguments: list[str], make_submission: Write, monkeypatch: pytest.MonkeyPatch, score: Command
) -> None:
    monkeypatch.chdir(make_submission())
    status, out, said = score(*arguments)
    assert (status, out, said[:16]) == (2, "", "error: nowhere: ")


@pytest.mark.parametrize(("place", "told"), [("notes/out", "notes"), ("", "The folder is a submission.")])
def test_a_place_that_cannot_be_written_or_is_a_submission_is_told(
    place: str, told: str, make_submission: Write, score: Command
) -> None:
    folder = make_submission()
    (folder.parent / "notes").write_text("")
    out = folder.parent / place if place else folder
    status, _, said = score(folder, "--out", out)
    assert (status, told in said, "Traceback" in said) == (2, True, False)
    assert not (folder / "boards.json").exists()


NASTY = {
    "a picture": b"\x89PNG\r\n\x1a\n" + bytes(range(256)),
    "half a surrogate": b"\xed\xa0\x80\n\xed\xa0\x80\n",
    "huge numbers": b"stage,task,episode,seed,length,return,terminated,success\n" + b"9" * 10_000 + b"\n",
    "deep": b"[" * 100_000,
}
RUN = "hopper-gravity/single/run0"


@pytest.mark.parametrize("name", ["submission.toml", "review.toml", f"{RUN}.csv", f"{RUN}.json"])
@pytest.mark.parametrize("nasty", NASTY)
def test_no_input_gives_a_traceback_or_passes(
    name: str, nasty: str, good: Callable[[str, Path], Path], tmp_path: Path, score: Command
) -> None:
    folder = good("hopper-gravity", tmp_path)
    (folder / name).write_bytes(NASTY[nasty])
    status, out, said = score(folder)
    assert (status, "problem" in out, "Traceback" in out + said) == (1, True, False)


def test_out_writes_scorecards_and_boards_and_holds_nothing_older(
    make_submission: Write, score: Command, tmp_path: Path
) -> None:
    folders, out = [make_submission(name=name) for name in "ab"], tmp_path / "out"
    assert score(*folders, "--out", out).status == 0
    assert [path.name for path in sorted((out / "scorecards").iterdir())] == ["a.json", "b.json"]
    assert json.loads((out / "boards.json").read_text())["boards"] == []
    score(folders[1], "--out", out)
    assert [path.name for path in (out / "scorecards").iterdir()] == ["b.json"]


def test_what_strangers_write_is_shown_literally(make_submission: Write, score: Command) -> None:
    odd = ":rocket: [bold]x[/bold] [/] C:\\"
    folder = make_submission(manifest=MANIFEST.replace("A submission", odd.replace("\\", "\\\\")))
    assert score(folder).out.splitlines()[0] == f"submission  {odd}  (claimed)"


def test_large_returns_are_told_in_thousands_at_80_columns(
    make_submission: Write, score: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    def value(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
        return 1e5 * stage + 2e3 * episode + run if position == 2 else 9.0 + run

    monkeypatch.setenv("COLUMNS", "80")
    shown = score(make_submission(groups=("humanoid-standup-run",), value=value)).out
    rows = [re.split(r"  +", line.rstrip()) for line in shown.splitlines()]
    # After the last stage 300000 + 19000 ± 11533, before any training 19000 ± 11533.
    found = next(row[1:] for row in rows if row[0] == "HumanoidStandup")
    assert found == ["319k ± 12k", "219k ± 12k", "119k ± 12k", "119k ± 12k"]


def test_a_terminal_that_knows_no_unicode_gets_no_traceback(make_submission: Write) -> None:
    code = "import sys; from gym_extensions.scoring.cli import main; sys.exit(main())"
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "LC_ALL": "C"}
    command = [sys.executable, "-c", code, str(make_submission())]
    found = subprocess.run(command, env=environment, capture_output=True, check=False)
    assert (found.returncode, found.stderr) == (0, b"")


@pytest.mark.parametrize("is_terminal", [True, False])
def test_a_command_that_works_shows_it_on_a_terminal(
    is_terminal: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    errors = io.StringIO()
    monkeypatch.setattr(errors, "isatty", lambda: is_terminal)
    monkeypatch.setattr(sys, "stderr", errors)
    with working("scoring mine"):
        pass
    assert ("scoring mine" in errors.getvalue()) == is_terminal
