"""The fingerprints of tasks: seeded episodes, definition and model, compared with the published ones."""

import functools
import hashlib
import math
import platform
import warnings
from collections.abc import Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.tasks import TASKS, Task, definition
from gym_extensions.envs.make import build
from gym_extensions.envs.mujoco.model import asset
from gym_extensions.errors import BenchError
from gym_extensions.versions import CPU_INFO, version

SEEDS = (0, 1)
STEPS = 8
DIGITS = 12
"""Significant digits that are written: three more than the tolerance needs."""
FOREIGN_DIGITS = 6
"""The same for environments of other packages, whose digest is compared without a tolerance."""
TOLERANCE = 1e-9
"""Largest accepted difference, absolute below 1, relative above; differences between CPUs are smaller."""

GOLDEN = 0.6180339887498949


def actions(space: gym.spaces.Box) -> Iterator[NDArray[np.float32]]:
    """Yields actions spread evenly over the space by multiples of the golden ratio; needs no libm."""
    low = np.where(np.isfinite(space.low), space.low, -1.0).astype(np.float64)
    high = np.where(np.isfinite(space.high), space.high, 1.0).astype(np.float64)
    for step in range(STEPS):
        spread = np.modf((step * low.size + np.arange(low.size) + 1) * GOLDEN)[0]
        yield (low + (high - low) * spread.reshape(low.shape)).astype(np.float32)


def record(task: Task, digits: int = DIGITS) -> list[dict[str, Any]]:
    """Returns seed, rewards, last observation and termination of one episode per seed."""
    with closing(build(task)) as env:
        return [_episode(env, seed, digits) for seed in SEEDS]


def _episode(env: gym.Env[Any, Any], seed: int, digits: int) -> dict[str, Any]:
    assert isinstance(env.action_space, gym.spaces.Box)
    observation, _ = env.reset(seed=seed)
    rewards, terminated = [], False
    for action in actions(env.action_space):
        observation, reward, terminated, _, _ = env.step(action)
        rewards.append(_rounded(float(reward), digits))
        if terminated:
            break
    last: Any = [_rounded(float(value), digits) for value in observation.ravel()]
    if observation.dtype.kind in "iu":  # a picture, whose integers are exact
        digest_of_bytes = hashlib.sha256(observation.tobytes()).hexdigest()
        last = {"sha256": digest_of_bytes, "shape": list(observation.shape)}
    return {"seed": seed, "rewards": rewards, "observation": last, "terminated": bool(terminated)}


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


ENGINE = ("mujoco", "gymnasium")
PLATFORM = "Linux-x86_64"
"""The system on which the physics is the same to the last bit on every machine."""


@dataclass(frozen=True)
class Difference:
    """One value of a task that differs from the published value."""

    task: str
    where: str
    published: Any
    current: Any

    def __str__(self) -> str:
        return f"{self.task}: {self.where} is {self.current!r}, published as {self.published!r}"


def engine() -> dict[str, str]:
    """Returns the installed versions of the packages on which physics depends."""
    return {name: version(name) for name in ENGINE}


def other_engine() -> str:
    """Returns the installed packages whose versions are not the published ones; empty if there are none."""
    published = fingerprints.table()["engine"]
    versions = ((name, found, published[name]) for name, found in engine().items())
    return " with ".join(f"{name} {found} (not {old})" for name, found, old in versions if found != old)


def other_platform() -> str:
    """Returns why the physics of this machine may differ in the last bits; empty if it may not.

    It is the same on all x86-64 Linux machines. There, the C library rounds in another way only on processors
    without fused multiply-add, which are from before 2013.
    """
    name = f"{platform.system()}-{platform.machine()}"
    if name != PLATFORM:
        return f"This machine is {name}, not {PLATFORM}: its physics may differ in the last bits."
    try:
        flags = CPU_INFO.read_text(errors="replace").partition("\nflags")[2].partition("\n")[0].split()
    except OSError:
        flags = []
    return "" if "fma" in flags else f"{CPU_INFO} states no FMA: the physics may differ in the last bits."


def warn_of_another_engine() -> None:
    """Warns that published ids have other physics, if another version of the engine is installed."""
    if other := other_engine():
        message = f"{other} is installed: published ids may not have their published physics. {install()}"
        warnings.warn(message, stacklevel=3)


def require_published_engine(tasks: Iterable[Task] | None = None) -> None:
    """Raises ``BenchError`` if another version of the engine is installed than that of the published tasks.

    It is called before episodes are recorded or repeated. Fingerprints are not enough to repeat them bit for
    bit: two versions of an engine can agree in their few steps and differ later. With ``tasks``, as for
    training, another Gymnasium is a warning if the fingerprints of all published tasks of their bodies agree,
    and so is another platform.
    """
    if tasks is not None and (reason := other_platform()):
        warnings.warn(f"{reason} Record runs for a submission on x86-64 Linux.", stacklevel=2)
    if not (other := other_engine()):
        return
    if tasks is not None and engine()["mujoco"] == fingerprints.table()["engine"]["mujoco"]:
        bases = {task.base for task in tasks}
        if not check(task for task in TASKS.values() if task.base in bases):
            message = f"{other} is installed; the fingerprints agree. Results may differ in later steps."
            warnings.warn(message, stacklevel=2)
            return
    message = f"Episodes are recorded and repeated with the published engine, but {other} is installed."
    raise BenchError("other-engine", message, hint=install())


def install() -> str:
    """Returns how to install the published engine."""
    pins = " ".join(f"{name}=={fingerprints.table()['engine'][name]}" for name in ENGINE)
    return f"Run: pip install {pins}"


def definition_and_model(task: Task) -> dict[str, object]:
    """Returns a task's definition, and the sha256 of the file from which its base is made.

    In navigation it is the file of the map, and a line with the center of the goal.
    """
    if task.body.family == "navigation":
        from gym_extensions.envs.navigation import env, geometry

        course = env.course(task)
        x, y = geometry.goals()[course.map, course.goal]
        base = geometry.map_bytes(course.map) + f"goal {x:g} {y:g}\n".encode("ascii")
    else:
        base = asset(task.body).read_bytes()
    return {"definition": definition(task), "model_sha256": hashlib.sha256(base).hexdigest()}


def row(task: Task) -> dict[str, Any]:
    """Returns a task's definition, sha256 of its base model, canary values, and the digest of these."""
    canary = {"tolerance": TOLERANCE, "episodes": record(task)}
    content = definition_and_model(task) | {"canary": canary}
    return {"fingerprint": fingerprints.digest(content)} | content


@functools.cache
def fingerprint_of(task: Task) -> str:
    """Returns the fingerprint that logs record: the published one, or that of a custom task.

    The fingerprint of a custom task covers its definition and its base model. It has no canary values, so it
    is the same on every machine. That of an environment of another package covers its definition and the
    first steps of two seeded episodes, to 6 digits.
    """
    if TASKS.get(task.id) == task:
        return fingerprints.published(task.id)
    if task.is_foreign:
        return fingerprints.digest({"definition": definition(task), "episodes": record(task, FOREIGN_DIGITS)})
    return fingerprints.digest(definition_and_model(task))


def check(tasks: Iterable[Task] | None = None) -> list[Difference]:
    """Returns every difference between the tasks (by default all) and the published table.

    Another version of the engine is none: its effects are (see :func:`other_engine`). Digests are computed
    from the published rows, so a value that changes within the tolerance, as on another CPU, changes none.
    """
    rows = fingerprints.table()["tasks"]
    found: list[Difference] = []
    for task in TASKS.values() if tasks is None else tasks:
        published = rows.get(task.id)
        if published is None:
            found.append(Difference(task.id, "fingerprint", None, "not yet published"))
            continue
        current = row(task) | {"fingerprint": fingerprints.digest(published)}
        differences = compare("", published, current)
        found += [Difference(task.id, where, old, new) for where, old, new in differences]
    gone = sorted(rows.keys() - TASKS.keys()) if tasks is None else ()
    return found + [Difference(task_id, "task", "published", "not in the catalog") for task_id in gone]


def compare(where: str, published: Any, current: Any) -> Iterator[tuple[str, Any, Any]]:
    """Yields the path, the published and the current value of each leaf at which two rows differ.

    Numbers within ``TOLERANCE`` of each other (relative above 1) are equal.
    """
    if isinstance(published, dict) and isinstance(current, dict):
        for key in sorted(published.keys() | current.keys()):
            path = f"{where}.{key}" if where else key
            yield from compare(path, published.get(key), current.get(key))
    elif isinstance(published, list) and isinstance(current, list) and len(published) == len(current):
        for index, (old, new) in enumerate(zip(published, current, strict=True)):
            yield from compare(f"{where}[{index}]", old, new)
    elif all(type(value) in (int, float) for value in (published, current)):
        if not math.isclose(published, current, rel_tol=TOLERANCE, abs_tol=TOLERANCE):
            yield where, published, current
    elif published != current:
        yield where, published, current
