"""Rules about the logs of one group together."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from gym_extensions.rollouts.reader import read

from .broken import GROUP, LOG, TOML, Broken, Judge, each, edit, lines

BROKEN = (
    Broken(
        "different-runs",
        "a run that single.csv lacks, but for its curves",
        lines(lambda rows: [line for line in rows if line[0] == "0"], f"{GROUP}/single.csv"),
        (
            (
                f"{GROUP}/single.csv",
                "The runs are [0]; sequential.csv has [0, 1].",
                "Add the runs that are missing on either side, or leave them out on both.",
            ),
        ),
        also=("foreign-curve",),
    ),
    Broken(
        "identical-runs",
        "a run copied under another seed",
        lines(lambda rows: rows[:600] + ["1" + line[1:] for line in rows[:600]]),
        (
            (
                LOG,
                "Run 1 is the same as run 0 in every episode.",
                "Train each run with its own seed; an agent that has no parameters says so in [memory].",
            ),
        ),
    ),
)


@each(BROKEN)
def test_a_broken_folder_breaks_its_rule_and_says_so(example: Broken, judge: Judge) -> None:
    judge(example)


def test_identical_runs_of_an_agent_without_parameters_count_as_one(submission: Callable[..., Path]) -> None:
    folder = submission(value=lambda protocol, run, stage, position, episode: float(position))
    edit("parameters_last = 100", "parameters_last = 0", TOML)(folder)
    entry = read(folder).groups["hopper-gravity-v0"]
    assert {protocol: log.runs for protocol, log in entry.logs.items()} == {
        "sequential": (0,),
        "single": (0,),
    }
    assert entry.notes == ("Runs 0, 1 are identical in every episode and count as one.",)
    assert len(entry.logs["sequential"].return_) == 600


def test_an_agent_without_parameters_is_the_same_in_both_files_or_in_none(
    submission: Callable[..., Path],
) -> None:
    folder = submission(
        value=lambda protocol, run, stage, position, episode: (
            position + (run if protocol == "single" else 0.0)
        )
    )
    edit("parameters_last = 100", "parameters_last = 0", TOML)(folder)
    assert [(one.rule, one.where, one.message, one.hint) for one in read(folder).problems] == [
        (
            "identical-runs",
            LOG,
            "Run 1 is the same as run 0 in every episode. In single.csv they differ.",
            "Train each run with its own seed, and write both files from the same agent.",
        )
    ]


def test_a_mistake_elsewhere_in_the_manifest_makes_no_agent_learn(submission: Callable[..., Path]) -> None:
    folder = submission(value=lambda protocol, run, stage, position, episode: float(position))
    edit("parameters_last = 100", "parameters_last = 0", TOML)(folder)
    edit("boundaries = ", "luck = true\nboundaries = ", TOML)(folder)
    assert [one.rule for one in read(folder).problems] == ["unknown-key"]


def test_identical_joint_runs_count_as_one_whatever_the_other_logs_hold(
    submission: Callable[..., Path],
) -> None:
    folder = submission(
        runs=(0, 1, 2),
        protocols=("sequential", "joint"),
        value=lambda protocol, run, stage, position, episode: float(position if protocol == "joint" else run),
    )
    edit("parameters_last = 100", "parameters_last = 0", TOML)(folder)
    log = folder / "hopper-gravity" / "joint.csv"
    log.write_text("".join(line for line in log.read_text().splitlines(keepends=True) if line[0] != "2"))
    entry = read(folder).groups["hopper-gravity-v0"]
    assert {protocol: log.runs for protocol, log in entry.logs.items()} == {
        "sequential": (0, 1, 2),
        "joint": (0,),
    }
    assert entry.notes == ("Joint runs 0, 1 are identical in every episode and count as one.",)


def test_identical_runs_count_as_one_beside_a_joint_log_of_other_runs(
    submission: Callable[..., Path],
) -> None:
    folder = submission(
        runs=(0, 1, 2),
        protocols=("sequential", "single", "joint"),
        value=lambda protocol, run, stage, position, episode: float(run if protocol == "joint" else position),
    )
    edit("parameters_last = 100", "parameters_last = 0", TOML)(folder)
    log = folder / "hopper-gravity" / "joint.csv"
    log.write_text("".join(line for line in log.read_text().splitlines(keepends=True) if line[0] != "2"))
    entry = read(folder).groups["hopper-gravity-v0"]
    assert {protocol: log.runs for protocol, log in entry.logs.items()} == {
        "sequential": (0,),
        "single": (0,),
        "joint": (0, 1),
    }
