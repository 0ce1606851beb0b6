"""The ``score`` command: what it prints, its exit status, and that nobody ever reads a traceback."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import pytest

from gym_extensions.scoring import cli

Write = Callable[..., Path]


def test_a_good_submission_exits_0_and_a_bad_one_1(submission: Write, known: None) -> None:
    folder = submission()
    assert cli.main([str(folder)]) == 0
    (folder / "notes.txt").write_text("")
    assert cli.main([str(folder)]) == 1


SCREEN = """\
entry  An entry  (validated)
  provisional references 'synthetic': fewer runs or a smaller budget

hopper-gravity-v0, sequential, budget smoke, 2 runs
metric                 mean   95 % interval
Final performance     1.117  1.110 to 1.123
Learning performance  3.001  2.995 to 3.008
Forgetting            2.356  2.356 to 2.356
Asymptotic transfer   2.356  2.356 to 2.356
Joint gap: none. It needs joint.csv, which this entry lacks.
                                  Fully  After Env     First       Single
task                            Trained   Training      Step          Env
HopperGravityHalf               178 ± 1   3001 ± 1  1501 ± 1     3001 ± 1
HopperGravityThreeQuarters      301 ± 1   3001 ± 1  1501 ± 1     1501 ± 1
Hopper                          601 ± 1   3001 ± 1  1501 ± 1      601 ± 1
HopperGravityOneAndQuarter     1501 ± 1   3001 ± 1  1501 ± 1      301 ± 1
HopperGravityOneAndHalf        3001 ± 1   3001 ± 1  1501 ± 1      178 ± 1
total                       1117 ± 1050   3001 ± 1  1501 ± 1  1117 ± 1050
· forgets HopperGravityHalf most: 3001 → 178
· earlier tasks help HopperGravityOneAndHalf most: 178 alone, 3001 after them
! no rank: The log does not commit to traces.
missing for a full entry: 3 more runs, joint.csv, curves.csv

hopper-gravity-v0, single, budget smoke, 2 runs
metric                    mean   95 % interval
Single-task performance  1.117  1.110 to 1.123
! no rank: The log does not commit to traces.
missing for a full entry: 3 more runs

"""


def test_one_screen_word_by_word(submission: Write, known: None, capsys: pytest.CaptureFixture[str]) -> None:
    folder = submission(value=lambda p, run, stage, j, e: 3000.0 / (1 + (stage - j) ** 2) + run + e / 10)
    assert cli.main([str(folder)]) == 0
    shown = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    assert shown == SCREEN.splitlines()


def test_problems_are_told_with_rule_place_and_what_to_do(
    submission: Write, known: None, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = submission()
    (folder / "notes.txt").write_text("")
    assert cli.main([str(folder)]) == 1
    assert capsys.readouterr().out == (
        "entry  An entry  (1 problem)\n"
        "  unexpected-name  notes.txt: Unexpected file.\n"
        "    Remove it, or rename it as described in docs/rollout-log.md.\n"
        "\n"
    )


def test_json_is_the_document(
    submission: Write, known: None, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    assert cli.main([str(submission()), "--json"]) == 0
    assert json.loads(capfdbinary.readouterr().out)["submissions"][0]["trust"] == "validated"


def test_csv_has_a_row_for_every_metric(
    submission: Write, known: None, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    assert cli.main([str(submission()), "--csv"]) == 0
    rows = capfdbinary.readouterr().out.decode().splitlines()
    assert rows[0] == "name,trust,group,protocol,budget,runs,metric,mean,low,high,why"
    assert len(rows) == 1 + 13 + 1
    joint = "It needs joint.csv, which this entry lacks."
    assert f'entry,validated,hopper-gravity-v0,sequential,smoke,2,joint_gap,,,,"{joint}"' in rows


def test_markdown_has_tables_and_escapes_what_a_stranger_wrote(
    submission: Write, known: None, manifest_text: str, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    folder = submission(manifest=manifest_text.replace("An entry", "<b>|entry"))
    assert cli.main([str(folder), "--markdown"]) == 0
    shown = capfdbinary.readouterr().out.decode()
    assert "\n\n## entry: &lt;b>\\|entry\n\nTrust: validated.\n" in shown
    assert "| task | Fully Trained | After Env Training | First Step | Single Env |" in shown


def test_a_folder_of_submissions_gives_a_line_each(
    submission: Write, known: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in "dcba":
        submission(name=name, protocols=("single",))
    (tmp_path / "README.md").write_text("not a submission")
    assert cli.main([str(tmp_path)]) == 0
    assert capsys.readouterr().out == "".join(f"{name}  An entry  (validated)\n" for name in "abcd")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ([], "name at least one FOLDER, or two with --compare"),
        (["x", "--jobs", "0"], "--jobs takes a number from 1"),
        (["x", "--json", "--csv"], "argument --csv: not allowed with argument --json"),
        (
            ["--compare", "a", "b", "--csv"],
            "--compare takes two submissions and only --json, --groups and --references besides",
        ),
        (
            ["x", "--compare", "a", "b"],
            "--compare takes two submissions and only --json, --groups and --references besides",
        ),
    ],
)
def test_misuse_exits_2(arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(arguments)
    assert stopped.value.code == 2
    assert told in capsys.readouterr().err


def test_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(["--version"])
    assert stopped.value.code == 0
    assert capsys.readouterr().out == f"{version('gym-extensions')}\n"


@pytest.mark.parametrize("arguments", [["nowhere"], ["--compare", ".", "nowhere"], ["nowhere", "--json"]])
def test_a_path_that_does_not_exist_exits_2(
    arguments: list[str],
    submission: Write,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(submission())
    assert cli.main(arguments) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err == (
        "error: nowhere: There is no such folder. Name a submission, or a folder of submissions.\n"
    )


@pytest.mark.parametrize(
    ("arguments", "status"),
    [([], 0), (["--json"], 0), (["--markdown"], 0), (["--help"], 0), (["nowhere"], 2)],
)
def test_closed_output_prints_nothing(
    arguments: list[str],
    status: int,
    submission: Write,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    folder = submission(protocols=("joint",))
    for stream in ("stdout", "stderr"):
        monkeypatch.setattr(sys, stream, None)
    try:
        assert cli.main([str(folder), *arguments]) == status
    except SystemExit as stopped:  # argparse prints the help and exits
        assert stopped.code == status
    finally:
        for replacement in (sys.stdout, sys.stderr):
            replacement.close()
    assert capfd.readouterr() == ("", "")


def test_markdown_says_what_the_references_are_and_what_the_scorer_noted(
    submission: Write, known: None, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = submission(value=lambda protocol, run, stage, j, e: float(j))
    manifest = folder / "submission.toml"
    manifest.write_text(manifest.read_text().replace("parameters_last = 100", "parameters_last = 0"))
    cli.main([str(folder), "--markdown"])
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "Provisional references `synthetic`: fewer runs or a smaller budget."
    assert "* hopper-gravity-v0: Runs 0, 1 are identical in every episode and count as one." in lines


def test_a_printed_total_stands_beside_the_recomputed_one(capsys: pytest.CaptureFixture[str]) -> None:
    cli.main(["submissions/henderson2017-trpo", "--markdown"])
    lines = capsys.readouterr().out.splitlines()
    at = next(place for place, line in enumerate(lines) if line.startswith("| printed total"))
    assert lines[at - 1].startswith("| total | 1238.31 ± 1029.24 |")
    assert lines[at].startswith("| printed total | 990.95 ± 1022.32 |")


def test_a_place_that_cannot_be_written_is_told(
    submission: Write, known: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    assert cli.main([str(submission()), "--out", str(tmp_path / "file" / "out")]) == 2
    assert "Traceback" not in capsys.readouterr().err


NASTY = {
    "nothing": b"",
    "zeros": bytes(100),
    "a picture": b"\x89PNG\r\n\x1a\n" + bytes(range(256)),
    "commas": b"," * 50 + b"\n" + b"," * 50 + b"\n",
    "a header of another file": b"protocol,run,task,step,return\nsequential,0,x,1,1.0\n",
    "one huge cell": b"run,stage,task,episode,seed,length,return,terminated,success,fingerprint\n"
    + b"9" * 10_000
    + b"\n",
    "half a surrogate": b"\xed\xa0\x80\n\xed\xa0\x80\n",
    "huge numbers": b"run,stage,task,episode,seed,length,return,terminated,success,fingerprint\n"
    + b",".join([b"9" * 40] * 7 + [b"true", b"x"])
    + b"\n",
}


@pytest.mark.parametrize("name", ["sequential.csv", "curves.csv", "submission.toml", "traces"])
@pytest.mark.parametrize("nasty", NASTY)
def test_no_input_gives_a_traceback_or_passes(
    name: str,
    nasty: str,
    good: Callable[[str, Path], Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    folder = good("hopper-gravity", tmp_path)
    place = folder / name if name.endswith("toml") else folder / "hopper-gravity" / name
    if name == "traces":
        place = place / "sequential-run0-stage1-Hopper-episode0.npz"
        place.parent.mkdir()
    place.write_bytes(NASTY[nasty])
    assert cli.main([str(folder)]) == 1
    shown = capsys.readouterr()
    assert "problem" in shown.out
    assert "Traceback" not in shown.out + shown.err
