"""Every rule has a folder that breaks it, and the exact words that a submitter reads."""

from __future__ import annotations

import io
import pickle
import random
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.tasks import TASKS, Task
from gym_extensions.scoring.bounds import BOUNDS, bound
from gym_extensions.scoring.checks import RULES, broken
from gym_extensions.scoring.checks.arrays import Arrays
from gym_extensions.scoring.folder import Folder, submission_folders
from gym_extensions.scoring.problems import Problem
from gym_extensions.scoring.submission import read

GROUP = "hopper-gravity"
LOG = f"{GROUP}/sequential.csv"
HALF = "gym_extensions/HopperGravityHalf-v0"
TRACE = f"{GROUP}/traces/sequential-run0-stage1-HopperGravityHalf-episode3.npz"


@dataclass(frozen=True)
class Broken:
    """A folder with a mistake: which rule it breaks, how it is broken, and what is told, whole."""

    rule: str
    title: str
    spoil: Callable[[Path], object]
    told: tuple[tuple[str, str, str], ...]
    also: tuple[str, ...] = ()
    """Other rules that the same mistake breaks."""
    group: str = GROUP


def edit(old: str, new: str, path: str = LOG, count: int = 1) -> Callable[[Path], object]:
    def spoil(folder: Path) -> None:
        text = (folder / path).read_bytes().decode()
        assert old in text
        (folder / path).write_bytes(text.replace(old, new, count).encode())

    return spoil


def row(number: int, change: Callable[[list[str]], list[str]], path: str = LOG) -> Callable[[Path], object]:
    """Changes the cells of the row of that number (the header is row 1)."""

    def spoil(folder: Path) -> None:
        lines = (folder / path).read_text().split("\n")
        lines[number - 1] = ",".join(change(lines[number - 1].split(",")))
        (folder / path).write_text("\n".join(lines), newline="\n")

    return spoil


def cell(number: int, column: int, value: str, path: str = LOG) -> Callable[[Path], object]:
    return row(number, lambda cells: [*cells[:column], value, *cells[column + 1 :]], path)


def lines(change: Callable[[list[str]], list[str]], path: str = LOG) -> Callable[[Path], object]:
    """Changes the list of data lines."""

    def spoil(folder: Path) -> None:
        text = (folder / path).read_text().split("\n")
        (folder / path).write_text("\n".join([text[0], *change(text[1:-1]), ""]), newline="\n")

    return spoil


def put(path: str, data: bytes) -> Callable[[Path], object]:
    def spoil(folder: Path) -> None:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(data)

    return spoil


def arrays(**content: object) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, **content)  # type: ignore[arg-type]
    return stream.getvalue()


def bomb() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("a.npy", "w") as member:
        np.lib.format.write_array(member, np.zeros(2**25 + 1, np.int8))
        for _ in range(7):
            member.write(bytes(2**25))
    return stream.getvalue()


def bare_pickle() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("weights.npy", pickle.dumps([1])[:5])
    return stream.getvalue()


def link(folder: Path) -> None:
    (folder / GROUP / "joint.csv").symlink_to("/etc/hostname")


def remove(path: str) -> Callable[[Path], object]:
    return lambda folder: (folder / path).unlink()


REWRITE = "Write it with gym_extensions.scoring.log.write_episodes or write_curves."
COUNT_STEPS = "Count the steps from the reset to the end of the episode."
TOML = "submission.toml"

BROKEN = (
    Broken(
        "not-a-submission",
        "a folder without submission.toml",
        remove(TOML),
        (
            (
                "entry",
                "There is no submission.toml in it.",
                "Write submission.toml as docs/rollout-log.md says, or name the folder that holds it.",
            ),
        ),
    ),
    Broken(
        "folder-name",
        "a name that cannot be an address",
        lambda folder: folder.rename(folder.with_name("my entry!")),
        (
            (
                "my entry!",
                "The folder's name is 'my entry!'.",
                "Rename it with letters, digits, dots, dashes and underscores, 64 at most.",
            ),
        ),
    ),
    Broken(
        "not-a-regular-file",
        "a symbolic link",
        link,
        ((f"{GROUP}/joint.csv", "This is a symbolic link.", "Put the file itself in its place."),),
    ),
    Broken(
        "unknown-group",
        "a misspelt group",
        lambda folder: (folder / GROUP).rename(folder / "hoper-gravity"),
        (("hoper-gravity", "There is no group 'hoper-gravity'.", "Did you mean 'hopper-gravity'?"),),
    ),
    Broken(
        "unexpected-name",
        "a misspelt log",
        put(f"{GROUP}/sequental.csv", b""),
        (
            (
                f"{GROUP}/sequental.csv",
                "A file of this name has no place here.",
                "Did you mean 'sequential.csv'?",
            ),
        ),
    ),
    Broken(
        "unexpected-name",
        "a program",
        put("run.py", b"print()"),
        (
            (
                "run.py",
                "A file of this name has no place here.",
                "Remove it, or give it the name that docs/rollout-log.md says.",
            ),
        ),
    ),
    Broken(
        "unexpected-name",
        "the trace of a task of another group",
        put(f"{GROUP}/traces/sequential-run0-stage1-Humanoid-episode3.npz", arrays(actions=np.zeros(3))),
        (
            (
                f"{GROUP}/traces/sequential-run0-stage1-Humanoid-episode3.npz",
                "A file of this name has no place here.",
                "Remove it, or give it the name that docs/rollout-log.md says.",
            ),
        ),
    ),
    Broken(
        "unexpected-name",
        "a folder among the logs",
        lambda folder: (folder / GROUP / "code").mkdir(),
        ((f"{GROUP}/code", "A folder of this name has no place here.", "Remove it."),),
    ),
    Broken(
        "no-logs",
        "a group's folder without a log",
        lambda folder: (folder / "humanoid-gravity").mkdir(),
        (
            (
                "humanoid-gravity",
                "There is no log in it.",
                "Add one of sequential.csv, single.csv, joint.csv, or remove the folder.",
            ),
        ),
    ),
    Broken(
        "too-large",
        "a long manifest",
        lambda folder: (folder / TOML).write_text((folder / TOML).read_text() + "#" * 2**18),
        (
            (
                TOML,
                "The file has 262661 bytes; the limit is 262144.",
                "Leave out what the format does not ask for.",
            ),
        ),
    ),
    Broken(
        "malformed-toml",
        "a missing quote",
        edit('title = "An entry"', 'title = "An entry', TOML),
        (
            (
                TOML,
                "It is not TOML: Illegal character '\\n' (at line 2, column 18).",
                "Correct that place; the format is at https://toml.io.",
            ),
        ),
    ),
    Broken(
        "malformed-toml",
        "bytes that are no UTF-8",
        lambda folder: (folder / TOML).write_bytes(b"\xff\xfe"),
        (
            (
                TOML,
                "It is not TOML: 'utf-8' codec can't decode byte 0xff in position 0: invalid start byte.",
                "Correct that place; the format is at https://toml.io.",
            ),
        ),
    ),
    Broken(
        "unknown-key",
        "a misspelt key",
        edit("[code]", 'tittle = "Another"\n[code]', TOML),
        ((TOML, "There is no key 'tittle'.", "Did you mean 'title'?"),),
    ),
    Broken(
        "unknown-key",
        "a key of another section",
        edit("stored_steps = 2000", "stored_step = 1\nstored_steps = 2000", TOML),
        (
            (
                f"{TOML}, [memory] stored_step",
                "There is no key 'stored_step'.",
                "Did you mean 'stored_steps'?",
            ),
        ),
    ),
    Broken(
        "missing-key",
        "what the agent knows is left out",
        edit("boundaries = false\n", "", TOML),
        (
            (
                f"{TOML}, [knows] boundaries",
                "The key is missing.",
                "Add boundaries with a value: true or false.",
            ),
        ),
    ),
    Broken(
        "bad-value",
        "a text in place of a number",
        edit("stored_steps = 2000", 'stored_steps = "2000"', TOML),
        ((f"{TOML}, [memory] stored_steps", "'2000' is not a whole number from 0.", "Give a whole number."),),
    ),
    Broken(
        "bad-value",
        "an address that a browser would run",
        edit('url = ""', 'url = "javascript:alert(1)"', TOML),
        (
            (
                f"{TOML}, [code] url",
                "'javascript:alert(1)' is not an address that begins with https:// or http://.",
                "Give a web address, or an empty text.",
            ),
        ),
    ),
    Broken(
        "bad-value",
        "another evaluation",
        edit('"sampled"', '"sample"', TOML),
        ((f"{TOML}, [protocol] evaluation", "The value is 'sample'.", "Did you mean 'sampled'?"),),
    ),
    Broken(
        "bad-value",
        "a value where a section belongs",
        lambda folder: (
            edit('[code]\nurl = ""\ncommit = ""\n', "", TOML)(folder)
            or edit("format = 1", 'format = 1\ncode = "https://example.org"', TOML)(folder)
        ),
        ((f"{TOML}, code", "'https://example.org' is not a section.", "Write [code] and its keys."),),
    ),
    Broken(
        "unknown-budget",
        "a misspelt budget",
        edit('"smoke"', '"smok"', TOML),
        ((f"{TOML}, [protocol] budget", "There is no budget 'smok'.", "Did you mean 'smoke'?"),),
    ),
    Broken(
        "unknown-report",
        "a table that the project does not keep",
        edit("format = 1", 'format = 1\nreported = "henderson2018"', TOML),
        ((f"{TOML}, reported", "There is no table 'henderson2018'.", "Did you mean 'henderson2017'?"),),
    ),
    Broken(
        "logs-of-a-reported-entry",
        "a published table with logs",
        edit("format = 1", 'format = 1\nreported = "henderson2017"', TOML),
        (
            (
                GROUP,
                "A reported entry has no logs.",
                "Remove the key 'reported' from submission.toml, or the folder.",
            ),
        ),
    ),
    Broken(
        "not-a-submission",
        "a folder that is not there",
        lambda folder: folder.rename(folder.with_name("elsewhere")).joinpath(TOML).unlink(),
        (
            (
                "elsewhere",
                "There is no submission.toml in it.",
                "Write submission.toml as docs/rollout-log.md says, or name the folder that holds it.",
            ),
        ),
    ),
    Broken(
        "bad-hyperparameter",
        "a number of more digits than can be printed",
        edit("step = 0.01", f"step = 0x{'f' * 6000}", TOML),
        (
            (
                f"{TOML}, [hyperparameters] step",
                "a number of very many digits is of another kind.",
                "Give a text, a finite number, true or false, or a list of them.",
            ),
        ),
    ),
    Broken(
        "malformed-toml",
        "lists within lists without end",
        edit("step = 0.01", f"step = {'[' * 5000}", TOML),
        (
            (
                TOML,
                "It is not TOML: it is nested too deeply.",
                "Correct that place; the format is at https://toml.io.",
            ),
        ),
    ),
    Broken(
        "bad-hyperparameter",
        "a table among the hyperparameters",
        edit("step = 0.01", "step = {first = 1}", TOML),
        (
            (
                f"{TOML}, [hyperparameters] step",
                "{'first': 1} is of another kind.",
                "Give a text, a finite number, true or false, or a list of them.",
            ),
        ),
    ),
    Broken(
        "control-character",
        "an escape sequence in the title",
        edit("An entry", "An \\u001b[31mentry", TOML),
        ((f"{TOML}, title", "The text 'An \\x1b[31mentry' holds a control character.", "Remove it."),),
    ),
    Broken(
        "empty-file",
        "an empty log",
        put(LOG, b""),
        ((LOG, "The file is empty.", "Add the rows, or remove the file."),),
    ),
    Broken(
        "empty-file",
        "a header alone",
        lines(lambda _: []),
        ((LOG, "The file has a header and no row.", "Add the rows, or remove the file."),),
    ),
    Broken(
        "byte-order-mark",
        "a log saved by a spreadsheet",
        lambda folder: (folder / LOG).write_bytes(b"\xef\xbb\xbf" + (folder / LOG).read_bytes()),
        (
            (
                LOG,
                "The file begins with a byte order mark (EF BB BF).",
                "Save it as UTF-8 without BOM.",
            ),
        ),
    ),
    Broken(
        "line-ends",
        "a log saved on Windows",
        lambda folder: (folder / LOG).write_bytes((folder / LOG).read_bytes().replace(b"\n", b"\r\n")),
        ((LOG, "The file has 1201 carriage returns (\\r).", "Save it with \\n line ends."),),
    ),
    Broken(
        "truncated-file",
        "a log cut off within a row",
        lambda folder: (folder / LOG).write_bytes((folder / LOG).read_bytes()[:-30]),
        (
            (
                f"{LOG}, row 1201",
                "The last line, '1,5,gym_extensions/HopperGravityOneAndHalf-v0,19,1400010033,1000,5', "
                "has no line end.",
                "The file is cut off: copy or write it again.",
            ),
        ),
        also=("cell-count",),
    ),
    Broken(
        "wrong-header",
        "a renamed column",
        edit("terminated", "terminate"),
        (
            (
                f"{LOG}, row 1",
                "The header is 'run,stage,task,episode,seed,length,return,terminate,fingerprint'.",
                "Write run,stage,task,episode,seed,length,return,terminated,fingerprint. "
                "Did you mean 'terminated'?",
            ),
        ),
    ),
    Broken(
        "odd-character",
        "a quoted task",
        edit(HALF, f'"{HALF}"'),
        ((f"{LOG}, row 2", "The row holds the character '\"'.", REWRITE),),
    ),
    Broken(
        "cell-count",
        "a row with a cell too few and an empty cell",
        lambda folder: row(5, lambda cells: cells[:-1])(folder) or cell(7, 6, "")(folder),
        (
            (f"{LOG}, row 5", "The row has 8 cells; 9 are needed.", "Write every cell of every row."),
            (f"{LOG}, row 7", "The cell 'return' is empty.", "Write every cell of every row."),
        ),
    ),
    Broken(
        "bad-cell",
        "a length with a point and a word for a return",
        lambda folder: cell(3, 5, "1000.0")(folder) or cell(4, 6, "many")(folder),
        (
            (f"{LOG}, row 3", "The length is '1000.0'.", "Write a whole number."),
            (f"{LOG}, row 4", "The return is 'many'.", "Write a number."),
        ),
    ),
    Broken(
        "bad-cell",
        "True in place of true",
        cell(3, 7, "True"),
        ((f"{LOG}, row 3", "The terminated is 'True'.", "Write true or false."),),
    ),
    Broken(
        "foreign-task",
        "a task of another group and one that does not exist",
        lambda folder: (
            cell(2, 2, "gym_extensions/Humanoid-v0")(folder)
            or cell(3, 2, "gym_extensions/HopperGravityHalf-v1")(folder)
        ),
        (
            (
                f"{LOG}, row 2",
                "gym_extensions/Humanoid-v0 is no task of hopper-gravity-v0.",
                "Did you mean 'gym_extensions/Hopper-v0'?",
            ),
            (
                f"{LOG}, row 3",
                "There is no task 'gym_extensions/HopperGravityHalf-v1'.",
                "Did you mean 'gym_extensions/Hopper-v0'?",
            ),
        ),
        also=("missing-cell", "unsorted-rows"),
    ),
    Broken(
        "wrong-stage",
        "a stage beyond the number of tasks",
        cell(1201, 1, "6"),
        (
            (
                f"{LOG}, row 1201",
                "The stage is 6; 0 to 5 is allowed.",
                "The stage is the number of tasks trained so far; it is 1 (trained) in single.csv and "
                "joint.csv.",
            ),
        ),
        also=("missing-cell",),
    ),
    Broken(
        "wrong-episode",
        "a twenty-first episode",
        lines(lambda rows: [*rows[:20], rows[19].replace(",19,", ",20,", 1), *rows[20:]]),
        (
            (
                f"{LOG}, row 22",
                "The episode is 20; 0 to 19 exist.",
                "Evaluate 20 episodes a cell, numbered from 0.",
            ),
        ),
    ),
    Broken(
        "wrong-seed",
        "a seed that somebody chose",
        cell(2, 4, "7"),
        (
            (
                f"{LOG}, row 2",
                "The seed is 7; this episode has 315912130.",
                "Reset with gym_extensions.catalog.protocol.evaluation_seed(group id, task id, episode).",
            ),
        ),
    ),
    Broken(
        "duplicate-episode",
        "two rows for one episode",
        lines(lambda rows: [rows[0], *rows]),
        ((f"{LOG}, row 3", "Row 2 is the same episode.", "Keep the one row that was measured."),),
    ),
    Broken(
        "missing-cell",
        "a matrix with a hole",
        lines(lambda rows: rows[:20] + rows[40:]),
        (
            (
                LOG,
                "Run 0, stage 0, gym_extensions/HopperGravityThreeQuarters-v0 has 0 of 20 episodes.",
                "Finish the evaluation of this run, or leave the whole run out.",
            ),
        ),
    ),
    Broken(
        "missing-cell",
        "one run short of a task",
        lines(lambda rows: [line for line in rows if not (line[0] == "1" and "/Hopper-v0" in line)]),
        (
            *(
                (
                    LOG,
                    f"Run 1, stage {stage}, gym_extensions/Hopper-v0 has 0 of 20 episodes.",
                    "Finish the evaluation of this run, or leave the whole run out.",
                )
                for stage in range(3)
            ),
            (
                LOG,
                "Run 1 lacks episodes in 3 more cells.",
                "Finish the evaluation of this run, or leave the whole run out.",
            ),
        ),
    ),
    Broken(
        "unsorted-rows",
        "two rows exchanged",
        lines(lambda rows: [rows[1], rows[0], *rows[2:]]),
        (
            (
                f"{LOG}, row 3",
                "The row comes before the row above it.",
                "Sort by run, stage, task in training order, episode.",
            ),
        ),
    ),
    Broken(
        "reserved-run",
        "the training seed of a reference run",
        lambda folder: [
            lines(
                lambda rows: [row.replace("1,", "1000,", 1) if row[0] == "1" else row for row in rows], path
            )(folder)
            for path in (LOG, f"{GROUP}/single.csv")
        ],
        tuple(
            finding
            for path, first, more in ((LOG, 602, 597), (f"{GROUP}/single.csv", 102, 97))
            for finding in (
                *(
                    (f"{path}, row {number}", "The run is 1000.", "Train with seeds from 0 to 999.")
                    for number in range(first, first + 3)
                ),
                (
                    path,
                    f"{more} more rows of this file break the same rule.",
                    "Train with seeds from 0 to 999.",
                ),
            )
        ),
    ),
    Broken(
        "not-finite",
        "NaN and infinity",
        lambda folder: cell(2, 6, "nan")(folder) or cell(3, 6, "-inf")(folder),
        (
            (
                f"{LOG}, row 2",
                "The return is nan.",
                "Find what the policy or the sum did there; the row cannot be scored.",
            ),
            (
                f"{LOG}, row 3",
                "The return is -inf.",
                "Find what the policy or the sum did there; the row cannot be scored.",
            ),
        ),
    ),
    Broken(
        "impossible-length",
        "episodes that are too long, empty and negative",
        lambda folder: [
            cell(number, 5, steps)(folder) for number, steps in ((2, "1001"), (3, "0"), (4, "-5"))
        ],
        tuple(
            (
                f"{LOG}, row {number}",
                f"The length is {steps}; the task's episodes have 1 to 1000 steps.",
                COUNT_STEPS,
            )
            for number, steps in ((2, 1001), (3, 0), (4, -5))
        ),
    ),
    Broken(
        "unfinished-episode",
        "an episode that nobody ended",
        cell(2, 5, "999"),
        (
            (
                f"{LOG}, row 2",
                "The episode stops after 999 of 1000 steps and terminated is false.",
                "Evaluate every episode to its end; write terminated = true where the task ended it.",
            ),
        ),
    ),
    Broken(
        "impossible-return",
        "a return beyond what the task can give in that many steps",
        row(2, lambda cells: [*cells[:5], "10", "3000.0", "true", cells[8]]),
        (
            (
                f"{LOG}, row 2",
                "The return is 3000.0; 10 steps of this task give from -200 to 200.",
                "Write the undiscounted, unscaled sum of the rewards.",
            ),
        ),
    ),
    Broken(
        "foreign-fingerprint",
        "a task of other physics",
        cell(2, 8, "0123456789abcdef"),
        (
            (
                f"{LOG}, row 2",
                "The fingerprint is '0123456789abcdef'; gym_extensions/HopperGravityHalf-v0 has 'HALF'.",
                "Evaluate in this benchmark's environments, with the pinned versions of gymnasium and "
                "mujoco.",
            ),
        ),
    ),
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
    Broken(
        "foreign-curve",
        "the curve of a run that is not logged",
        lines(lambda rows: [*rows, "single,2,gym_extensions/Hopper-v0,10,1.0"], f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 242",
                "single.csv has no run 2.",
                "Keep the curves of the runs that are logged.",
            ),
        ),
    ),
    Broken(
        "curve-order",
        "a step that goes back",
        cell(4, 3, "10", f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 4",
                "Step 10 does not follow the row above.",
                "Sort by protocol, run, task in training order and step; steps count from 0 in every curve.",
            ),
        ),
    ),
    Broken(
        "curve-not-finite",
        "NaN in a curve",
        cell(4, 4, "nan", f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 4",
                "The return is nan.",
                "Leave the row out where no episode ended; find the cause of NaN elsewhere.",
            ),
        ),
    ),
    Broken(
        "over-budget",
        "a curve beyond the budget",
        cell(13, 3, "1021", f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 13",
                "Step 1021 is beyond the budget 'smoke', which is 1000 steps here.",
                "Train within the budget, or name the larger budget in submission.toml.",
            ),
        ),
    ),
    Broken(
        "malformed-arrays",
        "a trace that is no archive",
        put(TRACE, b"not a zip"),
        (
            (
                TRACE,
                "It is no .npz file: File is not a zip file.",
                "Write it with numpy.savez_compressed.",
            ),
        ),
    ),
    Broken(
        "unpacks-too-large",
        "a small file that unpacks to 256 MiB",
        put(TRACE, bomb()),
        (
            (
                TRACE,
                "It unpacks to 1 arrays of 268435585 bytes; the limits are 256 and 268435456.",
                "Keep one episode a trace and one policy a file.",
            ),
        ),
    ),
    Broken(
        "pickled-arrays",
        "an array of Python objects",
        put(TRACE, arrays(actions=np.array([{"a": 1}], dtype=object))),
        (
            (
                TRACE,
                "'actions.npy' is an array of Python objects (a pickle).",
                "Store numbers alone; savez_compressed(..., allow_pickle=False) refuses the rest.",
            ),
        ),
    ),
    Broken(
        "pickled-arrays",
        "a bare pickle in the archive",
        put(f"{GROUP}/policies/run0.npz", bare_pickle()),
        (
            (
                f"{GROUP}/policies/run0.npz",
                "'weights.npy' cannot be read: EOF: reading magic string, expected 8 bytes got 5.",
                "Write it with numpy.savez_compressed.",
            ),
        ),
    ),
    Broken(
        "impossible-end",
        "HalfCheetah said to have ended an episode",
        cell(2, 7, "true", "halfcheetah-gravity/sequential.csv"),
        (
            (
                "halfcheetah-gravity/sequential.csv, row 2",
                "gym_extensions/HalfCheetahGravityHalf-v0 never ends an episode by itself.",
                "Write terminated = false where the time limit ended the episode.",
            ),
        ),
        group="halfcheetah-gravity",
    ),
    Broken(
        "foreign-trace",
        "the trace of a run that is not logged",
        put(TRACE.replace("run0", "run7"), arrays(actions=np.zeros(3))),
        (
            (
                TRACE.replace("run0", "run7"),
                "sequential.csv has no run 7.",
                "Remove the trace, or add the run's log.",
            ),
        ),
    ),
)


Good = Callable[[str, Path], Path]


@pytest.mark.parametrize("example", BROKEN, ids=lambda one: f"{one.rule}: {one.title}")
def test_a_broken_folder_breaks_its_rule_and_says_so(example: Broken, good: Good, tmp_path: Path) -> None:
    folder = good(example.group, tmp_path)
    example.spoil(folder)
    problems = read(folder if folder.exists() else next(tmp_path.iterdir())).problems
    told = tuple((one.where, one.message, one.hint) for one in problems if one.rule == example.rule)
    expected = tuple(
        (where, message.replace("'HALF'", repr(published(HALF))), hint)
        for where, message, hint in example.told
    )
    assert told == expected
    assert {one.rule for one in problems} == {example.rule, *example.also}


def test_a_good_folder_breaks_no_rule(good: Good, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    put(TRACE, arrays(actions=np.zeros((5, 3), np.float32), segment_steps=np.int64(10)))(folder)
    put(f"{GROUP}/policies/run0.npz", arrays(weights=np.zeros((5, 3))))(folder)
    put(".progress/half-done.csv", b"nothing yet")(folder)
    assert read(folder).problems == ()


def test_every_rule_has_an_example() -> None:
    elsewhere = {"unreadable-file"}  # test_a_file_that_cannot_be_read_is_named
    assert {example.rule for example in BROKEN} | elsewhere == set(RULES)


def test_damaged_arrays_are_told_and_never_raise() -> None:
    whole, rng = arrays(actions=np.zeros((50, 3)), returns=np.arange(5.0)), random.Random(1)
    told = 0
    for _ in range(1500):
        damaged = bytearray(whole)
        for _ in range(rng.choice((1, 2, 20))):
            place = rng.randrange(len(damaged))
            damaged[place : place + rng.randrange(3)] = rng.randbytes(rng.randrange(3))
        told += bool(broken("arrays", Arrays(TRACE, bytes(damaged), {"sequential": (0,)})))
    assert told > 500


def test_damaged_logs_are_told_and_never_raise(good: Good, tmp_path: Path) -> None:
    folder, rng = good(GROUP, tmp_path), random.Random(2)
    (folder / GROUP / "sequential.csv").unlink()
    (folder / GROUP / "curves.csv").unlink()
    log = folder / GROUP / "single.csv"
    whole = log.read_bytes()
    for _ in range(150):
        damaged = bytearray(whole)
        place = rng.randrange(len(damaged))
        damaged[place : place + rng.randrange(4)] = bytes(rng.choices(b"0123456789,.\ne-/true\x00\xff", k=2))
        log.write_bytes(bytes(damaged))
        # Only a changed digit of a return may pass: what it was is known to replay alone.
        problems = read(folder).problems
        rows = [
            (a, b) for a, b in zip(whole.split(b"\n"), bytes(damaged).split(b"\n"), strict=False) if a != b
        ]
        other = [a for a, b in rows if a.split(b",")[:6] != b.split(b",")[:6]]
        assert problems or not other


def test_a_name_that_is_no_folder_is_no_submission(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    told = [read(tmp_path / name).problems[0].message for name in ("nowhere", "file")]
    assert told == ["'nowhere' does not exist.", "'file' is not a folder."]


def test_a_linked_submission_in_a_collection_is_refused(good: Good, tmp_path: Path) -> None:
    good(GROUP, tmp_path)
    (tmp_path / "other").symlink_to(tmp_path / "entry")
    problems = {path.name: read(path).problems for path in submission_folders([tmp_path])}
    assert problems["entry"] == ()
    assert [(one.rule, one.where) for one in problems["other"]] == [("not-a-regular-file", "other")]


def test_a_file_that_cannot_be_read_is_named(
    submission: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(self: Folder, path: str) -> bytes:
        if path == LOG:
            raise PermissionError(13, "Permission denied")
        return (self.root / path).read_bytes()

    monkeypatch.setattr(Folder, "read", refuse)
    assert read(submission()).problems == (
        Problem(
            "unreadable-file",
            LOG,
            "The file cannot be read: Permission denied.",
            "Give it read permission, or copy it again.",
        ),
    )


def test_all_problems_are_told_at_once(submission: Callable[..., Path]) -> None:
    folder = submission()
    cell(2, 6, "nan")(folder)
    cell(3, 4, "7")(folder)
    edit("boundaries = false\n", "", TOML)(folder)
    put("notes.txt", b"")(folder)
    cell(2, 5, "12", f"{GROUP}/single.csv")(folder)
    assert {problem.rule for problem in read(folder).problems} == {
        "not-finite",
        "wrong-seed",
        "missing-key",
        "unexpected-name",
        "unfinished-episode",
    }


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


def test_thousands_of_bad_rows_are_counted_not_listed(submission: Callable[..., Path]) -> None:
    folder = submission()
    edit(",1000,", ",2000,", count=-1)(folder)
    found = [problem for problem in read(folder).problems if problem.rule == "impossible-length"]
    assert len(found) == 4
    assert found[-1].message == "1197 more rows of this file break the same rule."


@pytest.mark.parametrize("task", TASKS.values(), ids=lambda task: task.name)
def test_every_task_has_a_row_of_bounds(task: Task) -> None:
    assert bound(task) in BOUNDS.values()
    assert bound(task).low < bound(task).high
