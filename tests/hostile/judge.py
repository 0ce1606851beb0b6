"""Judges folders in forks of one process, each with limits of memory and processor time.

Run as a program it reads a JSON object per line (``folder``, ``command``) and answers each with a line. The
libraries are imported once; a fork that exceeds a limit or crashes ends alone.
"""

from __future__ import annotations

import gc
import json
import os
import resource
import signal
import subprocess
import sys
import traceback
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

CPU_SECONDS = 5
MEBIBYTE = 2**20
MEMORY = 500 * MEBIBYTE
WALL_SECONDS = 120


@dataclass(frozen=True)
class Judgement:
    """What became of a folder.

    ``rules`` are the broken ones, sorted. ``output`` is the number of characters of all problems or of the
    document. ``failure`` is an exception or a signal, empty if the command ended as it should. Memory is what
    the judgement needed beyond the imported libraries, in MiB.
    """

    rules: tuple[str, ...] = ()
    output: int = 0
    failure: str = ""
    cpu_seconds: float = 0.0
    memory: float = 0.0


class Judge:
    """The process that forks; a context manager."""

    def __enter__(self) -> Judge:
        root = Path(__file__).resolve().parents[2]
        sources = [str(root / part) for part in ("envs", "scoring", "baselines", "site")]
        paths = [*sources, *filter(None, [os.environ.get("PYTHONPATH")])]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(paths), "OPENBLAS_NUM_THREADS": "1"}
        self._process = subprocess.Popen(
            [sys.executable, __file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=environment,
            text=True,
        )
        return self

    def __exit__(self, *_: object) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()

    def __call__(self, folder: Path, command: str = "score") -> Judgement:
        """The judgement of a folder by a command, a key of ``commands``."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps({"folder": str(folder), "command": command}) + "\n")
        self._process.stdin.flush()
        answer = json.loads(self._process.stdout.readline())
        return Judgement(**answer | {"rules": tuple(answer["rules"])})


def commands() -> dict[str, Callable[[Path], tuple[list[str], int]]]:
    """What judges a folder: each gives the rules that it breaks and the number of characters to read."""
    from gym_extensions.curation.evidence import prove
    from gym_extensions.errors import BenchError
    from gym_extensions.rollouts.auditing.submission_digest import submission_digest
    from gym_extensions.scoring.output.tables import csv_text, markdown_text
    from gym_extensions.scoring.pipeline.score import make_scorer, references_info, scorecard_document
    from gym_extensions.scoring.reevaluation.reevaluate import reevaluate
    from gym_extensions.scoring.replay import verify  # noqa: F401 - loads the simulator once
    from gym_extensions.scoring.scorecard.model import Scorecard
    from gym_extensions.site.build import Site
    from gym_extensions.site.page import Draft

    scorer = make_scorer()

    def summary(card: Scorecard) -> tuple[list[str], int]:
        texts = [text for problem in card.problems for text in problem.as_dict().values()]
        return [problem.rule for problem in card.problems], len("".join(texts))

    def score(folder: Path) -> tuple[list[str], int]:
        return summary(scorer(folder))

    def replay(folder: Path) -> tuple[list[str], int]:
        problems = prove(folder).problems
        texts = [text for problem in problems for text in problem.as_dict().values()]
        return [problem.rule for problem in problems], len("".join(texts))

    def new_seeds(folder: Path) -> tuple[list[str], int]:
        problems = reevaluate(folder, "5a" * 32).problems
        return [problem.rule for problem in problems], len(problems)

    def table(folder: Path) -> tuple[list[str], int]:
        card = scorer(folder)
        document = scorecard_document((card,), scorer.references)
        return summary(card)[0], len(csv_text(document)) + len(markdown_text(document))

    def pages(folder: Path) -> tuple[list[str], int]:
        card = scorer(folder)
        files = [content for _, content in Site(references_info(scorer.references)).entry_files(card)]
        texts = [content.write() if isinstance(content, Draft) else content for content in files]
        return summary(card)[0], sum(map(len, texts))

    def digest(folder: Path) -> tuple[list[str], int]:
        return [], len(submission_digest(folder))

    def named(command: Callable[[Path], tuple[list[str], int]]) -> Callable[[Path], tuple[list[str], int]]:
        def run(folder: Path) -> tuple[list[str], int]:
            try:
                return command(folder)
            except BenchError as error:
                return [error.code], len(error.message)

        return run

    table_of_commands = {"score": score, "replay": replay, "new seeds": new_seeds}
    table_of_commands |= {"table": table, "pages": pages, "digest": digest}
    return {name: named(command) for name, command in table_of_commands.items()}


def _judge(command: Callable[[Path], tuple[list[str], int]], folder: Path) -> Judgement:
    before = _virtual_memory()
    if before:
        resource.setrlimit(resource.RLIMIT_AS, (before + MEMORY, before + MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS + 1))
    signal.alarm(WALL_SECONDS)
    try:
        rules, output = command(folder)
    except BaseException as error:  # noqa: BLE001 - whatever happens is the result
        last = traceback.extract_tb(error.__traceback__)[-1]
        return Judgement(failure=f"{type(error).__name__} in {Path(last.filename).name}, {last.name}")
    return Judgement(tuple(sorted(set(rules))), output)


def _virtual_memory() -> int:
    """Bytes of this process's address space; 0 where the system does not say."""
    statm = Path("/proc/self/statm")
    return int(statm.read_text().split()[0]) * resource.getpagesize() if statm.exists() else 0


def _peak() -> float:
    scale = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * scale / MEBIBYTE


def fork(command: Callable[[Path], tuple[list[str], int]], folder: Path) -> Judgement:
    """The judgement of a fork of this process."""
    base = _peak()
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        judgement = _judge(command, folder)
        os.write(writer, json.dumps(asdict(judgement)).encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        answer = pipe.read()
    _, status, usage = os.wait4(child, 0)
    fields = json.loads(answer) if answer else {}
    if status:
        fields["failure"] = f"status {os.waitstatus_to_exitcode(status)}"
    scale = 1 if sys.platform == "darwin" else 1024
    fields["memory"] = round(max(0.0, usage.ru_maxrss * scale / MEBIBYTE - base), 1)
    fields["cpu_seconds"] = round(usage.ru_utime + usage.ru_stime, 3)
    return Judgement(**fields)


def main() -> None:
    """Answers each line of the standard input."""
    by_name = commands()
    gc.freeze()  # the forks then share the memory of the libraries
    for line in sys.stdin:
        request = json.loads(line)
        judgement = fork(by_name[request["command"]], Path(request["folder"]))
        sys.stdout.write(json.dumps(asdict(judgement)) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
