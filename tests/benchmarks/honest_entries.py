"""The honest submissions of ``measure_honest.py``: records and checks the one of a number.

Each line of the standard input is a request as JSON, and is answered with a line.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np

from gym_extensions.baselines import Card, train
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.rollouts.policies import Policy
from gym_extensions.scoring import score_folder
from gym_extensions.scoring.reevaluation.reevaluate import reevaluate
from gym_extensions.scoring.replay.verify import verify

KINDS = ("random", "deterministic", "gaussian")


class Network:
    """A policy of one hidden layer with random weights, which learns nothing."""

    sigma = 0.0

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
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
        return Card("network", evaluation="sampled" if self.sigma else "deterministic", parameters=8)


class NoisyNetwork(Network):
    """The same with noise."""

    sigma = 0.3


def group_of(number: int) -> Any:
    """Two tasks of a published group, as a group with seeds of its own."""
    published = list(GROUPS.values())[number % len(GROUPS)]
    count = len(published.tasks)
    first = number // len(GROUPS) % count
    tasks = (published.tasks[first], published.tasks[(first + 1) % count])
    return TaskGroup(f"honest-{number}", tasks)


def record(number: int, folder: Path) -> None:
    """Records an entry."""
    shutil.rmtree(folder, ignore_errors=True)
    agents: dict[str, Any] = {"random": "random", "deterministic": Network, "gaussian": NoisyNetwork}
    kind = KINDS[number % len(KINDS)]
    train(agents[kind], group_of(number), "single", "smoke", 0, out=folder, progress=False)
    shutil.rmtree(folder / ".progress")


def check(number: int, folder: Path) -> dict[str, Any]:
    """The problems of an entry, the number of its replayed episodes, and the p values on new seeds.

    An entry that the new seeds of the first salt refuse is evaluated with a second one, which decides.
    """
    groups = with_custom([group_of(number)])
    problems = [
        f"{problem.rule}: {problem.message}" for problem in score_folder(folder, groups=groups).problems
    ]
    verification = verify(folder, groups)
    evaluations = [reevaluate(folder, _salt(number), groups)]
    if any(problem.rule == "reevaluation-differs" for problem in evaluations[0].problems):
        evaluations.append(reevaluate(folder, _salt(number, "second"), groups))
    last = evaluations[-1]
    problems += [f"{item.rule}: {item.message}" for item in (*verification.problems, *last.problems)]
    p_values = [evaluation.p_value for evaluation in evaluations]
    return {"problems": problems, "replayed": verification.replayed, "p": p_values}


def _salt(number: int, suffix: str = "") -> str:
    return hashlib.sha256(f"{number}{suffix}".encode()).hexdigest()


def main() -> None:
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
            answer = {"problems": [f"{type(error).__name__}: {error}"], "replayed": 0, "p": []}
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
