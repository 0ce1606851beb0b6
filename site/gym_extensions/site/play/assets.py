"""The files that the page Play loads: MuJoCo, bodies, tasks, and policies that a script in the browser runs.

There is no room for every policy. The site publishes the experts of the tasks, then of each group the first
run of the submissions that trained in sequence, the best submissions first, then their second run, and so on,
until ``MAX_BYTES`` are reached. Policies of more than ``MAX_FILE_BYTES`` are left out.

MuJoCo for the browser are two files of the npm package ``@mujoco/mujoco``, pinned by their digests.
``make site-assets`` fetches them with ``npm``. They belong to no package and to no commit.
"""

import base64
import gzip
import hashlib
import importlib.util
import json
import math
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from itertools import zip_longest
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np

from gym_extensions.catalog import bodies, variations
from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.tasks import Task
from gym_extensions.errors import BenchError
from gym_extensions.references import experts, load_references
from gym_extensions.scoring.ranking.core_board import REFERENCE
from gym_extensions.site.board_views import BoardView, Leaderboard, Row
from gym_extensions.site.paths import slug
from gym_extensions.site.submission_results import SEQUENTIAL
from gym_extensions.submissions.policies import mlp, mlp_arrays
from gym_extensions.submissions.policies.files import has_policies, npz_bytes, read_policies, run_arrays
from gym_extensions.submissions.submission import runs_folder

PACKAGE, VERSION = "@mujoco/mujoco", "3.14.0"
SHA256 = {
    "mujoco.js": "bc6980e4bc5ee5f809a6cabde0743798637e113d333f9e85124714d42be1ccae",
    "mujoco.wasm": "2d380f1070a556c3003b4a7c7c10c98a5f61db4e91815de1075ec478e9487e76",
}
"""The files that are used, by name."""
HINT = "Run: make site-assets"
MODELS = "play/models/"
MAX_BYTES, MAX_FILE_BYTES = 40_000_000, 1_000_000
"""Bytes of all policies that a site publishes for Play, and of those of one run."""
NAMES = ("Hopper", "Walker2d", "HalfCheetah", "Humanoid", "HumanoidStandup", "HumanoidStandupAndRun")
PLAYED = tuple(bodies.BODIES[name] for name in NAMES)
"""Bodies whose rules the script ``static/play/rules.js`` has."""
NO_POLICIES = "No policies are published"
NOT_ARRAYS = "The policies are not plain arrays, which the script needs"
TOO_LARGE = f"The policies take more than {MAX_FILE_BYTES // 10**6} MB"
NO_ROOM = f"This site offers {MAX_BYTES // 10**6} MB of policies, the best submissions first"


@dataclass(frozen=True)
class Simulator:
    """The two files as the site publishes them."""

    script: bytes  # the JavaScript that loads the other
    wasm: bytes  # the WebAssembly, compressed with gzip
    license: bytes  # of both, Apache-2.0

    @property
    def megabytes(self) -> float:
        """Their size as they are loaded."""
        return sum(map(len, self.files().values())) / 1e6

    def facts(self) -> dict[str, str]:
        """Paths and digests, for the page's script."""
        return {
            "script": "play/mujoco.js",
            "script_integrity": integrity(self.script),
            "wasm": "play/mujoco.wasm.packed",
            "wasm_integrity": integrity(self.wasm),
        }

    def files(self) -> dict[str, bytes]:
        """The files by their paths in the site."""
        facts = self.facts()
        return {
            facts["script"]: self.script,
            facts["wasm"]: self.wasm,
            "play/LICENSE-mujoco.txt": self.license,
        }


def integrity(content: bytes) -> str:
    """The digest of a file as browsers check it (Subresource Integrity)."""
    return f"sha256-{base64.b64encode(hashlib.sha256(content).digest()).decode()}"


def load(folder: Path) -> Simulator | None:
    """The files of a folder; None if there is no such folder.

    Raises ``BenchError`` if a file is missing, or is not the pinned one.
    """
    if not folder.is_dir():
        return None
    script, packed = (read_file(folder / name) for name in ("mujoco.js", "mujoco.wasm.gz"))
    try:
        wasm = gzip.decompress(packed)
    except (OSError, EOFError, zlib.error) as error:
        raise BenchError("bad-asset", f"Not a gzip file: {error}.", str(folder), HINT) from error
    for name, content in (("mujoco.js", script), ("mujoco.wasm", wasm)):
        check(name, content, folder)
    return Simulator(script, packed, license_of("mujoco"))


def license_of(package: str) -> bytes:
    """The licence that an installed package comes with."""
    text = metadata.distribution(package).read_text("licenses/LICENSE")
    return (text or f"See the package {package}.\n").encode()


def read_file(path: Path) -> bytes:
    """The content of a file. Raises ``BenchError`` if it cannot be read."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise BenchError("bad-asset", f"{error.strerror or error}.", str(path), HINT) from error


def check(name: str, content: bytes, where: Path) -> None:
    """Raises ``BenchError`` if a file is not the pinned one of this name."""
    if hashlib.sha256(content).hexdigest() != SHA256[name]:
        message = f"{name} is not the one of {PACKAGE} {VERSION}."
        raise BenchError("bad-asset", message, str(where), f"Remove the folder. {HINT}")


def is_playable(task: Task) -> bool:
    """Whether the script has the rules of the task's body and of its variations."""
    return task.body in PLAYED and all(each.played is not None for each in task.variations)


@cache
def playable_groups() -> tuple[TaskGroup, ...]:
    """The published groups whose tasks can all be played."""
    return tuple(group for group in GROUPS.values() if all(map(is_playable, group.tasks)))


@cache
def playable_tasks() -> dict[str, Task]:
    """The tasks of these groups by name. The page offers groups, so a task of no group cannot be chosen."""
    return {task.name: task for group in playable_groups() for task in group.tasks}


def play_link(task: Task) -> str:
    """The path of the page with this task chosen; empty for a task that it does not offer."""
    return f"play.html#?task={task.name}" if playable_tasks().get(task.name) == task else ""


def play_group_link(group_id: str, submission: str = "", run: int = 0, at: int = 0) -> str:
    """The path of the page with a task of a group chosen, and the policy of a run after its training.

    ``at`` is the position of the task, from 0. Empty if the group cannot be played.
    """
    group = next((each for each in playable_groups() if each.id == group_id), None)
    if group is None:
        return ""
    chosen = {"submission": submission, "run": run, "stage": at + 1} if submission else {}
    return f"play.html#?{urlencode({'group': group_id, 'task': group.tasks[at].name} | chosen)}"


def assets(
    site: Leaderboard, folders: Mapping[str, Path], simulator: Simulator
) -> tuple[dict[str, bytes], dict[str, list[tuple[str, str]]]]:
    """The files by path, and the results that are not offered (title and group) by the reason.

    Files are the index, models, policies and the simulator. The order of the boards decides who comes first.
    """
    files = _models()
    tasks = {name: _task(task) for name, task in playable_tasks().items()}
    room = MAX_BYTES
    for name in experts.names():
        if name in tasks:
            path = f"play/experts/{slug(name.lower())}.npz"
            files[path] = policy_file(experts.load(name).arrays())
            tasks[name] |= {"expert": path, "provisional": bool(experts.card(name).provisional)}
            room -= len(files[path])
    groups: dict[str, dict[str, Any]] = {
        group.id: {"id": group.id, "tasks": [task.name for task in group.tasks], "submissions": {}}
        for group in playable_groups()
    }
    boards = [board for board in site.boards if board.protocol == SEQUENTIAL and board.group in groups]
    whys: dict[tuple[str, str], tuple[str, str]] = {}  # title and reason by group and name
    for board, row, nth in _in_turn(boards):
        submissions, name = groups[board.group]["submissions"], row.card.name
        content, why = b"", NO_ROOM
        if room:  # of many submissions, most are not read
            content, why = _run_file(row, board.group, nth, folders)
        if len(content) > room:
            room, why = 0, NO_ROOM
        if why:
            whys.setdefault((board.group, name), (row.card.title, why))
            continue
        path = f"play/{slug(name)}/{slug(board.group)}-run{row.result.runs[nth]}.npz"
        files[path] = content
        room -= len(content)
        submission = submissions.setdefault(name, {"title": row.card.title, "runs": []})
        logged = [[round(cell, 1) for cell in stage] for stage in row.result.stage_matrices[nth]]
        submission["runs"].append((row.result.runs[nth], path, logged))
    absent: dict[str, list[tuple[str, str]]] = {}
    for (group_id, name), (title, why) in whys.items():
        if name not in groups[group_id]["submissions"]:
            absent.setdefault(why, []).append((title, group_id))
    core = site.scored.core
    index = {
        "mujoco": simulator.facts(),
        "bodies": {body.name: _body(body) for body in PLAYED},
        "tasks": tasks,
        "groups": list(groups.values()),
        "reference": REFERENCE,
        "core": [submission.name for submission in core.rows if submission.ranked] if core else [],
    }
    files["play/index.json"] = json.dumps(index, ensure_ascii=False, separators=(",", ":")).encode()
    return files | simulator.files(), absent


def _in_turn(boards: Sequence[BoardView]) -> Iterator[tuple[BoardView, Row, int]]:
    """Submissions with the position of a run.

    The first run of the first submission of every board, of the second submission, and so on; then the second
    runs.
    """
    turns = zip_longest(*(board.rows for board in boards))
    rows = [(board, row) for turn in turns for board, row in zip(boards, turn, strict=True) if row]
    for nth in range(max([1, *(len(row.result.runs) for _, row in rows)])):
        yield from ((board, row, nth) for board, row in rows if nth < max(len(row.result.runs), 1))


def _run_file(row: Row, group_id: str, nth: int, folders: Mapping[str, Path]) -> tuple[bytes, str]:
    """The policies of a run of a submission on a group, and why there are none."""
    folder = folders.get(row.card.name)
    group = next(group for group in GROUPS.values() if group.id == group_id)
    if folder is None or not row.result.runs:
        return b"", NO_POLICIES
    folder, run = runs_folder(folder, group.name, SEQUENTIAL), row.result.runs[nth]
    try:
        if not has_policies(folder, group, SEQUENTIAL, run):
            return b"", NO_POLICIES
        policies = read_policies(folder, group, SEQUENTIAL, run)
    except BenchError:
        return b"", NOT_ARRAYS
    if not all(isinstance(policy, mlp.Policy) for policy in policies.values()):
        return b"", NOT_ARRAYS
    content = policy_file(run_arrays(policies))
    return (content, "") if len(content) <= MAX_FILE_BYTES else (b"", TOO_LARGE)


def policy_file(arrays: mlp_arrays.Arrays) -> bytes:
    """An .npz file that ``static/play/policy.js`` can read: little-endian arrays in the order of C."""
    plain = {name: np.asarray(each, each.dtype.newbyteorder("<"), order="C") for name, each in arrays.items()}
    return npz_bytes(plain)


def _models() -> dict[str, bytes]:
    """The base bodies' model files, as Gymnasium publishes them, and Gymnasium's licence."""
    found = importlib.util.find_spec("gymnasium")
    if found is None or not found.submodule_search_locations:
        raise BenchError("no-models", "The models need Gymnasium.", hint="Run: pip install gymnasium")
    assets = Path(found.submodule_search_locations[0]) / "envs" / "mujoco" / "assets"
    files = {f"{MODELS}{body.asset}": (assets / body.asset).read_bytes() for body in PLAYED}
    return files | {f"{MODELS}LICENSE-gymnasium.txt": license_of("gymnasium")}


def _body(body: bodies.Body) -> dict[str, object]:
    wall, health = variations.Wall(width=body.wall_width or 0.8), body.health
    # JSON has no infinity, so an open end is None.
    ends = (health.height, health.angle) if health else ((), ())
    height, angle = ([end if math.isfinite(end) else None for end in each] for each in ends)
    return {
        "name": body.name,
        "model": f"{MODELS}{body.asset}",
        "is_planar": body.family == "planar",
        "max_steps": body.max_steps,
        "parts": body.parts,
        "feet": {"names": body.feet.names, "distance": body.feet.distance} if body.feet else None,
        "beams": body.beams,
        "velocity_limit": body.velocity_limit,
        "frame_skip": body.frame_skip,
        "noise": body.noise,
        "ctrl_cost": body.ctrl_cost,
        "health": health and {"height": height, "angle": angle, "state": health.state},
        "wall": {
            "half": wall.half_sizes,
            "height": wall.centre_height,
            "range": (wall.nearest, wall.farthest),
        },
    }


def _task(task: Task) -> dict[str, Any]:
    """The world of a task: factors of gravity and parts, and whether a wall stands there; its floor and 1."""
    facts: dict[str, Any] = {"body": task.base, "gravity": 1.0, "limbs": {}, "wall": False}
    if known := load_references().tasks.get(task.id):
        facts |= {"floor": known.floor.mean, "one": known.expert.mean if known.expert else None}
    for played in (each.played or {} for each in task.variations):
        facts |= played | {"limbs": facts["limbs"] | played.get("limbs", {})}
    return facts
