"""Checks honest submissions, each recorded with one set of CPU instructions and checked with two.

python tests/benchmarks/measure_honest.py --out _honest [--entries 400]

The submissions go through all groups, two tasks of each, and through three agents: uniformly random, a
deterministic and a Gaussian policy of random weights. Every other one is recorded without AVX, AVX2, AVX512
and FMA in numpy, OpenBLAS, numba and the C library. Each is scored, replayed and evaluated on new seeds in
both settings. Finished entries are in ``results.jsonl``, so that the command can be repeated until all are.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

ENTRIES = 400
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
KINDS = ("random", "deterministic", "gaussian")


class Network:
    """A policy of one hidden layer with random weights, which learns nothing."""

    sigma = 0.0

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        from gym_extensions.rollouts.policies import Policy

        rng = np.random.default_rng(seed)
        inputs, outputs = int(np.prod(observation_space.shape)), int(np.prod(action_space.shape))
        low, high = action_space.low.ravel(), action_space.high.ravel()
        layers = (rng.normal(0, inputs**-0.5, (inputs, 8)), rng.normal(0, 1, (8, outputs)))
        noise: dict[str, Any] = (
            {"head": "gaussian", "log_sigma": np.full(outputs, np.log(self.sigma))} if self.sigma else {}
        )
        self._noise, self._shape = np.random.default_rng(seed + 1), action_space.shape
        self._policy = Policy(
            *((high + low) / 2, (high - low) / 2, layers, (np.zeros(8), np.zeros(outputs))),
            activation="tanh",
            squash="tanh",
            **noise,
        )

    def act(self, observations: Any) -> Any:
        """The policy's actions."""
        actions = self._policy.act(observations, self._noise)
        return actions.reshape(len(observations), *self._shape).astype(np.float32)

    def learn(self, env: Any, steps: int) -> None:
        """Does nothing."""

    def policy(self) -> Any:
        """The policy."""
        return self._policy

    def card(self) -> Any:
        """The description in the manifest."""
        from gym_extensions.baselines.agent import Card

        return Card("network", evaluation="sampled" if self.sigma else "deterministic", parameters=8)


class NoisyNetwork(Network):
    """The same with noise."""

    sigma = 0.3


def group_of(number: int) -> Any:
    """Two tasks of a published group, as a group with seeds of its own."""
    from gym_extensions.catalog.groups import GROUPS, TaskGroup

    published = list(GROUPS.values())[number % len(GROUPS)]
    count = len(published.tasks)
    first = number // len(GROUPS) % count
    tasks = (published.tasks[first], published.tasks[(first + 1) % count])
    return TaskGroup(f"honest-{number}", tasks)


def record(number: int, folder: Path) -> None:
    """Records an entry."""
    from gym_extensions.baselines import train

    shutil.rmtree(folder, ignore_errors=True)
    agents: dict[str, Any] = {"random": "random", "deterministic": Network, "gaussian": NoisyNetwork}
    kind = KINDS[number % len(KINDS)]
    train(agents[kind], group_of(number), "single", "smoke", 0, out=folder, progress=False)
    shutil.rmtree(folder / ".progress")


def check(number: int, folder: Path) -> dict[str, Any]:
    """The problems of an entry, and the number of its episodes that were replayed."""
    from gym_extensions.catalog.custom_groups import with_custom
    from gym_extensions.scoring.pipeline.score import score_folder
    from gym_extensions.scoring.reevaluation.reevaluate import reevaluate
    from gym_extensions.scoring.replay.verify import verify

    groups, salt = with_custom([group_of(number)]), hashlib.sha256(str(number).encode()).hexdigest()
    problems = [
        f"{problem.rule}: {problem.message}" for problem in score_folder(folder, groups=groups).problems
    ]
    verification = verify(folder, groups)
    fresh = reevaluate(folder, salt, groups)
    problems += [f"{item.rule}: {item.message}" for item in (*verification.problems, *fresh.problems)]
    return {"problems": problems, "replayed": verification.replayed, "p": fresh.p_value}


def worker() -> None:
    """Answers each line of the standard input with a line."""
    for line in sys.stdin:
        request = json.loads(line)
        folder = Path(request["folder"])
        try:
            if request["command"] == "record":
                record(request["number"], folder)
                answer: dict[str, Any] = {}
            else:
                answer = check(request["number"], folder)
        except Exception as error:  # noqa: BLE001 - the failure is the result
            answer = {"problems": [f"{type(error).__name__}: {error}"], "replayed": 0, "p": None}
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()


class Worker:
    """A process of a setting."""

    def __init__(self, variables: dict[str, str]) -> None:
        environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"} | variables
        command = [sys.executable, __file__, "--worker"]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )

    def __call__(self, **request: object) -> dict[str, Any]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
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
        failed = workers[recorded](command="record", number=number, folder=str(folder)).get("problems", [])
        checks = {
            name: worker(command="check", number=number, folder=str(folder))
            for name, worker in workers.items()
        }
        result = {"number": number, "recorded": recorded, "failed": failed, "checks": checks}
        results.append(result)
        with path.open("a") as file:
            file.write(json.dumps(result) + "\n")
        if not failed and not any(check["problems"] for check in checks.values()):
            shutil.rmtree(folder, ignore_errors=True)  # a refused entry stays, to look at
    return results


def report(results: list[dict[str, Any]]) -> str:
    """A table of the results, and every problem."""
    lines = ["| recorded | checked | entries | episodes replayed | refused |", "|---|---|---:|---:|---:|"]
    counts: Counter[tuple[str, str]] = Counter()
    replayed: Counter[tuple[str, str]] = Counter()
    refused: Counter[tuple[str, str]] = Counter()
    problems = []
    for result in results:
        problems += [f"{result['number']}, recording: {text}" for text in result["failed"]]
        for name, outcome in result["checks"].items():
            key = result["recorded"], name
            counts[key] += 1
            replayed[key] += outcome["replayed"]
            refused[key] += bool(outcome["problems"])
            problems += [f"{result['number']}, {name}: {text}" for text in outcome["problems"]]
    lines += [
        f"| {recorded} | {checked} | {count} | {replayed[recorded, checked]} | {refused[recorded, checked]} |"
        for (recorded, checked), count in sorted(counts.items())
    ]
    return "\n".join([*lines, *problems, ""])


def main() -> None:
    """Measures and prints the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", type=Path, default=Path("_honest"))
    parser.add_argument("--entries", type=int, default=ENTRIES)
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        worker()
    else:
        sys.stdout.write(report(measure(options.out, options.entries)))


if __name__ == "__main__":
    main()
