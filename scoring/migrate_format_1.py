"""Moves submissions of the form before every run had its own files to the form of today, in place.

    python scoring/migrate_format_1.py submissions/trpo submissions/ppo …

The old form has, per group, ``sequential.csv`` (with the columns ``run``, ``trace`` and ``fingerprint``),
``curves.csv``, ``evaluations.csv`` and the folders ``policies`` and ``traces``. Nothing is measured or
rounded: cells of the logs are copied as they are. What the old form did not record (machine, processor time,
memory) is null. Running it again changes nothing.

Evidence of before is kept only for the files that it is about: the decisions of ``ledger.jsonl``, and what
``scoring/reevaluations`` and ``scoring/repetitions`` say, become ``review.toml``.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import re
import shutil
import sys
import tempfile
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomli_w

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import BUDGETS, PROTOCOLS
from gym_extensions.files import write_text
from gym_extensions.rollouts.layout import (
    DOCUMENT,
    LOG,
    MANIFEST,
    POLICIES,
    PROGRESS,
    README,
    REVIEW,
    run_file,
    run_key,
)
from gym_extensions.rollouts.manifest import OLD_SECTIONS
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.review import Decision, Review, Verification, write_review
from gym_extensions.rollouts.run import (
    Curve,
    InterimEvaluation,
    Memory,
    PolicyFile,
    RunDocument,
    Versions,
    read_run,
    write_run,
)
from gym_extensions.rollouts.run_policies import (
    content_sha256,
    npz_bytes,
    old_policy_files,
    policy_keys,
    read_arrays,
)
from gym_extensions.rollouts.tables import LOG_COLUMNS

OLD_LOGS = tuple(f"{protocol}.csv" for protocol in PROTOCOLS)
OLD_FILES = (*OLD_LOGS, "curves.csv", "evaluations.csv")
MAINTAINERS = "The gym-extensions authors"
MADE_BY = re.compile(r"\s*Made by: ")
COMMAND = re.compile(
    r"gym-extensions train .*?(?=, then gym-extensions|, and joined| and the same with| \(|$)"
)
COMMIT = re.compile(r"\(at commit ([0-9a-f]{7,40})\)")
LAST_COMMIT = re.compile(r"\(these (two|three|four) at commit ([0-9a-f]{7,40})\)")
SAME_WITH = re.compile(r"and the same with --runs (\S+) --out (\S+)")
NUMBERS = {"two": 2, "three": 3, "four": 4}


@dataclass(frozen=True)
class Training:
    """A command of the description, and the commit that it names; both empty if unknown."""

    command: str = ""
    commit: str = ""

    def covers(self, group: str, protocol: str, run: int) -> bool:
        """Whether it trained a run."""
        options = dict(re.findall(r"--(groups|protocol|runs) (\S+)", self.command))
        runs = set[int]()
        for part in options.get("runs", "").split(","):
            first, _, last = part.partition("-")
            runs |= set(range(int(first), int(last or first) + 1)) if first.isdigit() else set()
        return (
            group in options.get("groups", "").split(",")
            and protocol in options.get("protocol", "").split(",")
            and run in runs
        )


def trainings(description: str) -> list[Training]:
    """The commands that a description names, in its order."""
    found: list[Training] = []
    for match in COMMAND.finditer(description):
        end = description.find("gym-extensions train ", match.end())
        after = description[match.end() : end if end >= 0 else len(description)]
        commit = COMMIT.search(after)
        found.append(Training(match[0].strip(), commit[1] if commit else ""))
        if same := SAME_WITH.search(after):
            other = re.sub(
                r"--runs \S+", f"--runs {same[1]}", re.sub(r"--out \S+", f"--out {same[2]}", match[0])
            )
            found.append(Training(other.strip(), found[-1].commit))
        if several := LAST_COMMIT.search(after):
            count = NUMBERS[several[1]]
            found[-count:] = [Training(each.command, several[2]) for each in found[-count:]]
    return found


def rows_of(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file as text; none without the file."""
    if not path.exists():
        return []
    with path.open(encoding="ascii", newline="") as file:
        return list(csv.DictReader(file))


def by_run(rows: Iterable[dict[str, str]]) -> dict[int, list[dict[str, str]]]:
    """Rows by run, in their order."""
    found: dict[int, list[dict[str, str]]] = defaultdict(list)
    for row in rows:
        found[int(row["run"])].append(row)
    return dict(sorted(found.items()))


def log_text(rows: list[dict[str, str]]) -> str:
    """The text of a run's log: the cells of the old one."""
    lines = [",".join(row[name] for name in LOG_COLUMNS) for row in rows]
    return "\n".join([",".join(LOG_COLUMNS), *lines, ""])


def curves_of(rows: Iterable[dict[str, str]], group: TaskGroup, protocol: str) -> list[Curve]:
    """The training curves in the rows of one run, by stage and task."""
    points: dict[str, list[tuple[int, float]]] = defaultdict(list)
    for row in rows:
        points[row["task"]].append((int(row["step"]), float(row["return"])))
    return [
        Curve(
            stage=position + 1 if protocol == "sequential" else 1,
            task=task,
            steps=[step for step, _ in points[task]],
            returns=[value for _, value in points[task]],
        )
        for position, task in enumerate(group.task_ids)
        if task in points
    ]


def evaluations_of(rows: Iterable[dict[str, str]], group: TaskGroup) -> list[InterimEvaluation]:
    """The evaluations during training in the rows of one run, by stage and task."""
    points: dict[tuple[int, int, int], list[tuple[int, float]]] = defaultdict(list)
    for row in rows:
        key = int(row["stage"]), group.task_ids.index(row["task"]), int(row["episodes"])
        points[key].append((int(row["step"]), float(row["return"])))
    return [
        InterimEvaluation(
            stage=stage,
            task=group.task_ids[position],
            episodes=episodes,
            steps=[step for step, _ in found],
            returns=[value for _, value in found],
        )
        for (stage, position, episodes), found in sorted(points.items())
    ]


def policies_of(folder: Path, group: TaskGroup, protocol: str, run: int) -> PolicyFile | None:
    """What the document says about the policies of a run; None unless it has all of them."""
    files = old_policy_files(folder, group, protocol, run)
    if set(files) != set(policy_keys(protocol, group)):
        return None
    size = sum(path.stat().st_size for path in files.values())
    return PolicyFile(sha256=content_sha256(read_arrays(folder, group, protocol, run)), size=size)


def digest_of_old_run(folder: Path, group: TaskGroup, protocol: str, run: int) -> str:
    """What the record of a repetition is about: rows and policies of a run, as the old code hashed them."""
    lines = (folder / group.name / f"{protocol}.csv").read_bytes().splitlines(keepends=True)[1:]
    rows = b"".join(line for line in lines if int(line.partition(b",")[0]) == run)
    files = sorted(old_policy_files(folder, group, protocol, run).values())
    hashes = [hashlib.sha256(data).hexdigest() for data in (rows, *(path.read_bytes() for path in files))]
    return hashlib.sha256("".join(f"{each}\n" for each in hashes).encode()).hexdigest()


def digest_of_old_entry(folder: Path) -> str:
    """What the record of a re-evaluation is about: all files but traces, as the old code hashed them."""
    paths = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    names = sorted(
        path.as_posix() for path in paths if path.parts[1:2] != ("traces",) and path.parts[0] != PROGRESS
    )
    lines = (f"{name} {hashlib.sha256((folder / name).read_bytes()).hexdigest()}\n" for name in names)
    return hashlib.sha256("".join(lines).encode()).hexdigest()


class Entry:
    """A submission of the old form."""

    def __init__(self, folder: Path, groups: Mapping[str, TaskGroup]) -> None:
        self.folder = folder
        self.tables: dict[str, Any] = tomllib.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        self.groups = [group for name, group in sorted(groups.items()) if (folder / name).is_dir()]
        self.trainings = trainings(self.tables["description"])

    @property
    def is_old(self) -> bool:
        """Whether there is anything of the old form but policies and traces."""
        files = (self.folder / group.name / name for group in self.groups for name in OLD_FILES)
        return any(name in self.tables for name in OLD_SECTIONS) or any(path.exists() for path in files)

    def runs(self) -> Iterator[tuple[str, str, RunDocument]]:
        """The path without suffix, the text of the log and the document of every run."""
        for group in self.groups:
            place = self.folder / group.name
            others = rows_of(place / "curves.csv"), rows_of(place / "evaluations.csv")
            for protocol in PROTOCOLS:
                curves, evaluations = (
                    by_run(row for row in rows if row["protocol"] == protocol) for rows in others
                )
                for run, rows in by_run(rows_of(place / f"{protocol}.csv")).items():
                    document = RunDocument(
                        **self._facts(group, protocol, run),
                        fingerprints={row["task"]: row["fingerprint"] for row in rows},
                        curves=curves_of(curves.get(run, []), group, protocol),
                        evaluations=evaluations_of(evaluations.get(run, []), group),
                        log=hashlib.sha256(log_text(rows).encode()).hexdigest(),
                    )
                    yield run_key(group.name, protocol, run), log_text(rows), document

    def _facts(self, group: TaskGroup, protocol: str, run: int) -> dict[str, Any]:
        """What the document of a run says besides the content of the group's files."""
        training = self._training(group.name, protocol, run)
        budget = BUDGETS[self.tables["protocol"]["budget"]]
        return {
            "group": group.id,
            "protocol": protocol,
            "run": run,
            "command": training.command,
            "commit": training.commit or self.tables["code"]["commit"],
            "versions": Versions(**self.tables["versions"]),
            "packages": self.tables.get("packages", {}),
            "steps": budget.steps_for(group.name) * len(group.tasks),
            "memory": Memory(**self.tables["memory"]),
            "policies": policies_of(self.folder, group, protocol, run),
        }

    def _training(self, group: str, protocol: str, run: int) -> Training:
        """The one command that trained a run; an empty one if none or several did."""
        found = [each for each in self.trainings if each.covers(group, protocol, run)]
        return found[0] if len(found) == 1 else Training()

    def description(self) -> str:
        """The description without the commands that made the entry."""
        return str(MADE_BY.split(self.tables["description"], maxsplit=1)[0])

    def review(self, documents: Mapping[str, RunDocument]) -> Review:
        """The decisions and the evidence about these files."""
        submissions, name = self.folder.parent, self.folder.name
        ledger = submissions / "ledger.jsonl"
        lines = [json.loads(line) for line in ledger.read_text().splitlines()] if ledger.exists() else []
        lines = [line for line in lines if line["entry"] == name]
        decisions = [
            Decision(action=line["event"], by=MAINTAINERS, date=line["date"], reason=line["reason"])
            for line in lines
            if line["event"] in ("accepted", "withdrawn")
        ]
        record = _json(submissions.parent / "scoring" / "reevaluations" / f"{name}.json")
        dates = [line["date"] for line in lines if line["level"] == "re-evaluated"]
        seeds = record.get("new_seeds", {})
        if not dates or not record["is_complete"] or seeds.get("digest") != digest_of_old_entry(self.folder):
            return Review(decisions=decisions)
        repeated, kernels = self._repeated(
            _json(submissions.parent / "scoring" / "repetitions" / f"{name}.json")
        )
        cells = [
            cell for parts in record["groups"].values() for part in parts.values() for cell in part["cells"]
        ]
        verification = Verification(
            date=dates[-1],
            version=next(line["scorer"] for line in reversed(lines)),
            value=seeds["salt"],
            runs={key: document.digest for key, document in documents.items()},
            episodes=repeated,
            repeated=repeated,
            kernels=kernels,
            cells=len(cells),
            p_value=seeds["p_value"],
            passed=True,
        )
        return Review(verifications=[verification], decisions=decisions)

    def _repeated(self, record: dict[str, Any]) -> tuple[int, str]:
        """How many episodes of these rows and policies were repeated bit for bit, and the kernels."""
        groups = {group.id: group for group in self.groups}
        found = [
            run
            for run in record.get("runs", [])
            if run["group"] in groups
            and (self.folder / groups[run["group"]].name / f"{run['protocol']}.csv").exists()
            and run["digest"]
            == digest_of_old_run(self.folder, groups[run["group"]], run["protocol"], run["run"])
        ]
        kernels = dict.fromkeys(run["blas"] for run in found)
        return sum(run["episodes"] for run in found), ", ".join(kernels)

    def migrate(self, *, decisions_only: bool = False) -> int:
        """Writes the new form in the place of the old one, and returns the number of runs.

        Args:
            decisions_only: whether the review says nothing about verifications, which come anew.
        """
        runs = list(self.runs())
        documents = {key: document for key, _, document in runs}
        review = self.review(documents)
        if decisions_only:
            review = Review(decisions=review.decisions)
        with tempfile.TemporaryDirectory(dir=self.folder, prefix=".migration-") as scratch:
            for key, text, document in runs:
                write_text(Path(scratch, f"{key}{LOG}"), text)
                write_run(Path(scratch, f"{key}{DOCUMENT}"), document)
            for source in sorted(Path(scratch).glob("*/*")):
                target = self.folder / source.parent.name / source.name
                shutil.rmtree(target, ignore_errors=True)
                source.rename(target)
        if review != Review():
            write_review(self.folder, review)
        is_known = all(document.command for document in documents.values())
        if MADE_BY.search(self.tables["description"]) and not is_known:
            write_text(self.folder / README, f"# {self.tables['title']}\n\n{self.tables['description']}\n")
        for group in self.groups:
            for name in OLD_FILES:
                (self.folder / group.name / name).unlink(missing_ok=True)
        kept = {name: value for name, value in self.tables.items() if name not in OLD_SECTIONS}
        write_text(self.folder / MANIFEST, tomli_w.dumps(kept | {"description": self.description()}))
        return len(runs)

    def repack(self) -> int:
        """Writes the policies of every run into one file, and returns the number of runs."""
        count = 0
        for group in self.groups:
            for protocol in PROTOCOLS:
                for path in sorted((self.folder / group.name / protocol).glob(f"run*{DOCUMENT}")):
                    document = read_run(path)
                    files = old_policy_files(self.folder, group, protocol, document.run)
                    if document.policies is None or not files:
                        continue
                    arrays = read_arrays(self.folder, group, protocol, document.run)
                    target = self.folder / run_file(group.name, protocol, document.run, POLICIES)
                    count += _repacked(path, target, arrays, document)
            shutil.rmtree(self.folder / group.name / "policies", ignore_errors=True)
        return count

    def drop_traces(self) -> None:
        """Removes the folders of traces."""
        for group in self.groups:
            shutil.rmtree(self.folder / group.name / "traces", ignore_errors=True)


def _repacked(path: Path, target: Path, arrays: dict[str, Any], document: RunDocument) -> int:
    import msgspec

    data = npz_bytes(arrays)
    partial = target.with_name(f".{target.name}.partial")
    partial.write_bytes(data)
    partial.replace(target)
    policies = PolicyFile(sha256=content_sha256(arrays), size=len(data))
    write_run(path, msgspec.structs.replace(document, policies=policies))
    return 1


def _json(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = (
        json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"is_complete": False}
    )
    return content


def main(argv: list[str] | None = None) -> int:
    """Migrates the submissions that are named. Returns 1 if one of them has problems afterwards."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("submissions", nargs="+", type=Path)
    parser.add_argument("--repack-policies", action="store_true", help="one file of policies per run")
    parser.add_argument("--drop-traces", action="store_true", help="remove the folders of traces")
    parser.add_argument("--decisions-only", action="store_true", help="keep no verification of before")
    options = parser.parse_args(argv)
    code = 0
    for folder in options.submissions:
        entry = Entry(folder, GROUPS)
        done = ["as it was"]
        if entry.is_old or not (folder / REVIEW).exists():
            done = [f"{entry.migrate(decisions_only=options.decisions_only)} runs"]
        if options.repack_policies:
            done.append(f"{entry.repack()} files of policies")
        if options.drop_traces:
            entry.drop_traces()
        problems = read(folder).problems
        done += [f"{problem.rule}: {problem.where}: {problem.message}" for problem in problems]
        sys.stdout.write(f"{folder.name}: {'; '.join(done)}\n")
        code = max(code, int(bool(problems)))
    return code


if __name__ == "__main__":
    raise SystemExit(main())
