"""Checks honest submissions, each recorded with one set of CPU instructions and checked with two.

python tests/benchmarks/measure_honest.py --out _honest [--entries 400]

The submissions go through all groups, two tasks of each, and through three agents: uniformly random, a
deterministic and a Gaussian policy of random weights. Every other one is recorded without AVX, AVX2, AVX512
and FMA in numpy, OpenBLAS, numba and the C library. Each is scored, replayed and evaluated on new seeds in
both settings; if the test on new seeds refuses one, a second salt decides. Finished entries are in
``results.jsonl``, so that the command can be repeated until all are.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

ENTRIES = 400
PROGRAM = Path(__file__).with_name("honest_entries.py")
FEATURES = "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"
HARDWARE = ("AVX", "AVX2", "FMA", "AVX512F", "AVX512VL", "AVX512BW", "AVX512DQ", "AVX512CD")
SETTINGS: dict[str, dict[str, str]] = {
    "all instructions": {},
    "without FMA and AVX": {
        "NPY_DISABLE_CPU_FEATURES": FEATURES,
        "OPENBLAS_CORETYPE": "Nehalem",
        "NUMBA_CPU_NAME": "x86-64",
        "NUMBA_CPU_FEATURES": "",
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=" + ",".join(f"-{name},-{name}_Usable" for name in HARDWARE),
    },
}
"""Environment variables of each setting."""


class Worker:
    """A process of a setting."""

    def __init__(self, variables: dict[str, str]) -> None:
        environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"} | variables
        command = [sys.executable, str(PROGRAM)]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )

    def ask(self, **request: object) -> None:
        """Sends a request."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()

    def answer(self) -> dict[str, Any]:
        """Waits for the answer to the request."""
        assert self._process.stdout is not None
        answer: dict[str, Any] = json.loads(self._process.stdout.readline())
        return answer


def measure(out: Path, entries: int) -> list[dict[str, Any]]:
    """Records and checks the entries that are not finished. Returns the results of all."""
    out.mkdir(parents=True, exist_ok=True)
    path = out / "results.jsonl"
    path.touch()
    results = [json.loads(line) for line in path.read_text().splitlines()]
    done = {result["number"] for result in results}
    missing = [number for number in range(entries) if number not in done]
    workers = {name: Worker(variables) for name, variables in SETTINGS.items()} if missing else {}
    for number in missing:
        recorded = list(SETTINGS)[number % 2]
        folder = out / f"honest-{number}"
        workers[recorded].ask(command="record", number=number, folder=str(folder))
        failed = workers[recorded].answer().get("problems", [])
        for worker in workers.values():  # both check at the same time
            worker.ask(command="check", number=number, folder=str(folder))
        checks = {name: worker.answer() for name, worker in workers.items()}
        result = {"number": number, "recorded": recorded, "failed": failed, "checks": checks}
        results.append(result)
        with path.open("a") as file:
            file.write(json.dumps(result) + "\n")
        if not failed and not any(check["problems"] for check in checks.values()):
            shutil.rmtree(folder, ignore_errors=True)  # a refused entry stays, to look at
    return results


def report(results: list[dict[str, Any]]) -> str:
    """A table of the results, and every problem."""
    lines = [
        "| recorded | checked | entries | episodes replayed | refused by the first salt | refused |",
        "|---|---|---:|---:|---:|---:|",
    ]
    counts: Counter[tuple[str, str]] = Counter()
    replayed: Counter[tuple[str, str]] = Counter()
    first: Counter[tuple[str, str]] = Counter()
    refused: Counter[tuple[str, str]] = Counter()
    problems = []
    for result in results:
        problems += [f"{result['number']}, recording: {text}" for text in result["failed"]]
        for name, outcome in result["checks"].items():
            key = result["recorded"], name
            counts[key] += 1
            replayed[key] += outcome["replayed"]
            first[key] += len(outcome["p"]) > 1
            refused[key] += bool(outcome["problems"])
            problems += [f"{result['number']}, {name}: {text}" for text in outcome["problems"]]
    lines += [
        f"| {' | '.join(key)} | {count} | {replayed[key]} | {first[key]} | {refused[key]} |"
        for key, count in sorted(counts.items())
    ]
    return "\n".join([*lines, *problems, ""])


def main() -> None:
    """Measures and prints the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", type=Path, default=Path("_honest"))
    parser.add_argument("--entries", type=int, default=ENTRIES)
    options = parser.parse_args()
    sys.stdout.write(report(measure(options.out, options.entries)))


if __name__ == "__main__":
    main()
