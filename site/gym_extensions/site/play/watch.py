"""The Watch panel: episodes of submissions and of experts, their drawings, and the script for the player.

Poses are those of ``gym_extensions.submissions.poses``. A drawing has about twelve poses of an episode, with
the returns beside it. ``static/watch.js`` repeats the kinematics: where shapes of a skeleton are for joint
coordinates.
"""

import json
import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from gym_extensions.catalog.descriptions import FREE, SLIDE, Description, Role, Skeleton, descriptions
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site import paths, submission_results
from gym_extensions.site.charts.svg import disc, picture, scale_around, stroke, text, tick_label
from gym_extensions.site.charts.task_pictures import SIZE, map_shapes
from gym_extensions.site.text import count, digits_for, fixed
from gym_extensions.submissions.poses import MAX_SECONDS, Clip, Poses, TaskPoses

Array = NDArray[np.float64]
TRAVELLING = ("planar", "humanoid")
"""Families whose bodies move along x."""


@dataclass(frozen=True)
class Episode:
    """An episode: its clip, its cell in words, and the facts of its task."""

    clip: Clip
    title: str
    poses: TaskPoses
    description: Description

    @cached_property
    def travels(self) -> bool:
        """Whether its body moves along x, so that the view follows it."""
        return TASKS[self.poses.task].body.family in TRAVELLING

    @cached_property
    def coordinates(self) -> Array:
        """The coordinates, (frames, n)."""
        return self.clip.coordinates(self.poses.unit)

    @property
    def return_(self) -> float:
        """Its return."""
        return self.clip.returns[self.clip.episode]

    @property
    def distance(self) -> float:
        """How far a travelling body comes in the part that is shown, m."""
        return float(self.coordinates[-1, 0] - self.coordinates[0, 0])

    @property
    def facts(self) -> str:
        """Return, length, distance and success in words."""
        facts = [f"return {fixed(self.return_, digits_for(self.clip.returns))}"]
        facts.append(count(self.clip.steps, "step"))
        if self.poses.steps_per_second:
            seconds = self.clip.steps / self.poses.steps_per_second
            facts[-1] += f" ({fixed(seconds, 1)} s)"
            if seconds > MAX_SECONDS:
                facts.append(f"the first {fixed(MAX_SECONDS, 0)} s are shown")
        if self.travels:
            facts.append(
                f"{fixed(abs(self.distance), 1)} m {'backward' if self.distance < -0.05 else 'forward'}"
            )
        if self.clip.success is not None:
            facts.append("success" if self.clip.success else "no success")
        return ", ".join(facts)


@dataclass(frozen=True)
class Watch:
    """The panel of one group: of each task two episodes, or one of the task that was trained last."""

    id: str
    path: str  # of the script with its poses
    run: int
    tasks: tuple[tuple[Episode, ...], ...]

    @property
    def script(self) -> str:
        """The script that hands the poses to the player, which loads it when Replay is pressed."""
        skeletons: list[Any] = []
        maps: list[Any] = []
        rows = []
        for episodes in self.tasks:
            poses, facts = episodes[0].poses, episodes[0].description
            row: dict[str, object] = {
                "unit": poses.unit,
                "rate": poses.steps_per_second / poses.steps_per_frame or 15.0,
                "clips": [[episode.clip.frames, episode.clip.motion] for episode in episodes],
            }
            if facts.skeleton is not None:
                row |= {"skeleton": _index(skeletons, facts.skeleton), "travels": episodes[0].travels}
            else:
                row |= {"map": _index(maps, facts.obstacles), "goal": facts.goal}
            rows.append(row)
        text = json.dumps({"tasks": rows, "skeletons": skeletons, "maps": maps}, separators=(",", ":"))
        return f"watchPoses({json.dumps(self.id)},{text});\n"


def _index(values: list[Any], value: Any) -> int:
    if value not in values:
        values.append(value)
    return values.index(value)


def watches(submission: Scorecard, poses: Mapping[str, Poses]) -> dict[str, Watch]:
    """The panels of a submission by group id, for groups with poses of its present results."""
    panels = {}
    for result in submission_results.results_of(submission.groups):
        shown = poses.get(result.group)
        if shown is None or not result.stage_matrices or not shown.shows(result.runs, result.stage_matrices):
            continue
        if tuple(row.task for row in shown.tasks) == result.tasks:
            path = paths.submission_file(submission.name, f"poses-{result.group}.js")
            tasks = tuple(filter(None, map(watched, shown.tasks)))
            panels[result.group] = Watch(f"watch-{result.id}", path, shown.run, tasks)
    return panels


LAST = "At the end, right after its training"
"""The title of the only episode of the task that was trained last."""


def watched(row: TaskPoses, only: str = LAST) -> tuple[Episode, ...]:
    """The episodes of a task, of which a single one is titled ``only``; none if it is not published."""
    facts = descriptions().get(row.task)
    if facts is None:
        return ()
    if row.end is None:
        return (Episode(row.after, only, row, facts),)
    after = Episode(row.after, "Right after its training", row, facts)
    return after, Episode(row.end, "At the end", row, facts)


GHOSTS, MANY_LIMBS = 12, 12
"""Poses of an episode; two fewer if a body has more limbs than this."""
WIDTH, HEIGHT = 640, 150
"""Largest picture, in pixels."""
SHORT_TRACK = 3.0
"""Distance in m. If all episodes of a task are shorter and it has no wall, poses are drawn side by side."""
APART, LEAST_APART = 0.6, 0.55
"""Distance of poses that are moved apart: relative to the width of a body, and at least in m."""
NEAR = 0.35
"""A shape without length that is closer to the one before it, in m, is joined to it."""
SMALL = 0.055
"""Such a shape with a smaller radius, in m, is left out: a hand at the end of its arm."""
MARGIN = 0.15
"""Space around the track, in m."""
FAINTEST = 0.2
"""Opacity of the first pose; that of the last is 1."""


@dataclass(frozen=True)
class Placed:
    """A shape in every frame: its ends (frames, 2) in m, x to the right and y up, and its radius.

    For a wall, the ends are the lower left and the upper right corner.
    """

    role: Role
    radius: float
    start: Array
    end: Array


def placed(skeleton: Skeleton, coordinates: Array) -> list[Placed]:
    """The shapes of a skeleton for coordinates (frames, n), in the order of its links."""
    frames = len(coordinates)
    around, above = map(math.radians, skeleton.view)  # of the camera
    right, level = np.array([math.sin(around), -math.cos(around), 0.0]), math.cos(above)
    ahead = [level * math.cos(around), level * math.sin(around), math.sin(above)]
    view = np.stack([right, np.cross(right, ahead)])  # its directions to the right and up
    origins, turns, shapes = list[Array](), list[Array](), list[Placed]()
    for link in skeleton.links:
        is_rooted = link.parent < 0
        parent_turn = np.broadcast_to(np.eye(3), (frames, 3, 3)) if is_rooted else turns[link.parent]
        parent_origin = np.zeros((frames, 3)) if is_rooted else origins[link.parent]
        origin = parent_origin + parent_turn @ np.array(link.position)
        turn = parent_turn @ _rotation(np.array(link.rotation))
        for joint in link.joints:
            axis, anchor = np.array(joint.axis), np.array(joint.anchor)
            if joint.kind == FREE:
                pose = coordinates[:, joint.coordinate : joint.coordinate + 7]
                origin, turn = pose[:, :3], _rotation(pose[:, 3:])
                continue
            moved = coordinates[:, joint.coordinate] - joint.rest
            if joint.kind == SLIDE:
                origin = origin + (turn @ axis) * moved[:, None]
                continue
            pivot = origin + turn @ anchor
            half = moved[:, None] / 2
            turn = turn @ _rotation(np.hstack([np.cos(half), np.sin(half) * axis]))
            origin = pivot - turn @ anchor
        origins.append(origin)
        turns.append(turn)
        for shape in link.shapes:
            start, end = np.array(shape.start), np.array(shape.end)
            if shape.role == "wall":
                start, end = start - end, start + end
            fixed = np.eye(3) if shape.role == "world-beam" else turn
            ends = [(origin + fixed @ point) @ view.T for point in (start, end)]
            shapes.append(Placed(shape.role, shape.radius, *ends))
    return shapes


def _rotation(quaternion: Array) -> Array:
    """Rotation matrices (…, 3, 3) of quaternions (…, 4) of any length except 0."""
    w, x, y, z = np.moveaxis(quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


@dataclass(frozen=True)
class Frame:
    """The part of the view that all episodes of a task share, in m, and its scale in units per m."""

    left: float
    bottom: float
    right: float
    top: float

    @property
    def scale(self) -> float:
        """Pixels per m."""
        return min(WIDTH / (self.right - self.left), HEIGHT / (self.top - self.bottom))

    def at(self, point: Sequence[float]) -> tuple[int, int]:
        """The coordinates of a point in the picture."""
        return round((point[0] - self.left) * self.scale), round((self.top - point[1]) * self.scale)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.at((self.right, self.bottom))


def stroboscopes(episodes: Sequence[Episode]) -> list[Markup]:
    """A picture per episode of a task, all on one scale."""
    skeleton, travels = episodes[0].description.skeleton, episodes[0].travels
    if skeleton is None:
        return [_path(episode) for episode in episodes]
    bodies = []
    for episode in episodes:
        shapes = placed(skeleton, _ghosts(episode))
        bodies.append([shape for shape in shapes if not shape.role.endswith("beam")])
    has_wall = any(shape.role == "wall" for shape in bodies[0])
    is_short = all(abs(episode.distance) < SHORT_TRACK for episode in episodes)
    is_moved_apart = travels and is_short and not has_wall
    if is_moved_apart:
        bodies = _moved_apart(bodies, episodes)
    frame = frame_of([shape for shapes in bodies for shape in shapes], travels)
    return [
        _picture(shapes, frame, episode, has_ticks=not is_moved_apart)
        for shapes, episode in zip(bodies, episodes, strict=True)
    ]


def _moved_apart(bodies: Sequence[Sequence[Placed]], episodes: Sequence[Episode]) -> list[list[Placed]]:
    """The poses of each episode side by side, the body's own motion along x taken out."""
    widths = []
    for shapes in bodies:
        ends = np.stack([point[:, 0] for shape in shapes for point in (shape.start, shape.end)])
        widths.append(np.median(np.ptp(ends, axis=0)))
    apart = max(APART * float(max(widths)), LEAST_APART)
    moved = []
    for shapes, episode in zip(bodies, episodes, strict=True):
        root = _ghosts(episode)[:, 0]
        shift = np.stack([apart * np.arange(len(root)) - root, np.zeros(len(root))], axis=1)
        moved.append([replace(row, start=row.start + shift, end=row.end + shift) for row in shapes])
    return moved


def frame_of(shapes: Sequence[Placed], travels: bool) -> Frame:
    """The smallest part of the view that contains all shapes, and the floor of a body that travels."""
    ends = [
        point + sign * shape.radius
        for shape in shapes
        for point in (shape.start, shape.end)
        for sign in (-1, 1)
    ]
    points = np.concatenate(ends)
    low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    if travels:
        low[1] = min(low[1], -MARGIN)
    return Frame(float(low[0]), float(low[1]), float(high[0]), float(high[1]))


def _ghosts(episode: Episode) -> Array:
    rows, skeleton = episode.coordinates, episode.description.skeleton
    limbs = sum(len(link.shapes) for link in skeleton.links) if skeleton else 0
    ghosts = GHOSTS - 2 * (limbs > MANY_LIMBS)
    return rows[np.unique(np.rint(np.linspace(0, len(rows) - 1, ghosts)).astype(int))]


def _picture(shapes: Sequence[Placed], frame: Frame, episode: Episode, has_ticks: bool) -> Markup:
    """The picture of one episode, with a tick per m of the floor where poses are at their true distance."""
    width, height = frame.size
    parts = []
    if episode.travels:
        ticks = range(math.ceil(frame.left), math.floor(frame.right) + 1) if has_ticks else ()
        marks = "".join("M{} {}v5".format(*frame.at((tick, 0.0))) for tick in ticks)
        parts.append(f'<path class="floor" d="M0 {frame.at((0.0, 0.0))[1]}h{width}{marks}"/>')
    limbs = [shape for shape in shapes if shape.role in ("body", "far", "changed")]
    thickness = round(2 * float(np.median([shape.radius for shape in limbs])) * frame.scale)
    for shape in shapes:
        if shape.role == "wall":
            (left, bottom), (right, top) = frame.at(shape.start[-1]), frame.at(shape.end[-1])
            parts.append(f'<path class="wall" d="M{left} {top}H{right}V{bottom}H{left}"/>')
        elif shape.role in ("goal", "object"):
            (x, y), radius = frame.at(shape.start[-1]), max(round(shape.radius * frame.scale), 2)
            parts.append(disc(shape.role, x, y, radius))
    ghosts = len(limbs[0].start)
    for ghost in range(ghosts):
        opacity = FAINTEST + (1 - FAINTEST) * (ghost + 1) / ghosts
        shown = "" if ghost == ghosts - 1 else f' opacity="{opacity:.1f}"'.replace("0.", ".")
        parts.append(f'<path{shown} d="{_limbs(limbs, ghost, frame)}"/>')
    label = f"{episode.title}: {episode.facts}"
    drawn = f' width="{width}" stroke-width="{max(thickness, 2)}"'
    return picture("strobe", width, height, label, "".join(parts), drawn=drawn)


def _limbs(limbs: Sequence[Placed], ghost: int, frame: Frame) -> str:
    """The limbs of one pose as a path; a limb continues the one before where it begins at its end."""
    path, pen, last = "", (-1, -1), np.full(2, np.inf)
    for limb in limbs:
        ends = [limb.start[ghost], limb.end[ghost]]
        is_point = float(np.ptp(ends, axis=0).max()) < NEAR / 10
        if not is_point and math.dist(ends[1], last) < math.dist(ends[0], last):
            ends.reverse()
        start, end = frame.at(ends[0]), frame.at(ends[1])
        if is_point and math.dist(ends[0], last) < NEAR:
            if limb.radius < SMALL:
                continue
            start = pen
        elif start != pen:
            path += f"M{start[0]} {start[1]}"
        if start != end or (is_point and start != pen):
            path += f"l{end[0] - start[0]} {end[1] - start[1]}".replace(" -", "-")
        pen, last = end, ends[1]
    return path


def _path(episode: Episode) -> Markup:
    """The path of an episode of 2-D navigation over its map."""
    width, height = SIZE
    rows = np.rint(episode.coordinates).astype(int)
    rows[:, 1] = height - rows[:, 1]
    ways = " ".join(f"{x} {y}" for x, y in np.diff(rows, axis=0).tolist() if x or y)
    line = f"M{rows[0, 0]} {rows[0, 1]}l{ways or '0 0'}".replace(" -", "-")
    label = f"{episode.title}: {episode.facts}"
    drawn = ' width="320" stroke-width="4"'
    end = disc("object", rows[-1, 0], rows[-1, 1], 8)
    parts = f'{map_shapes(episode.description)}<path d="{line}"/>{end}'
    return picture("strobe map", width, height, label, parts, drawn=drawn)


DOTS_WIDTH, DOTS_MARGIN, LINE = 280, 12, 26
TICKS = 4


def episode_dots(episodes: Sequence[Episode]) -> list[Markup]:
    """A picture per episode: the dots of its cell on the scale that all of them share."""
    shared = [value for episode in episodes for value in episode.clip.returns]
    scale = scale_around(shared, DOTS_MARGIN, DOTS_WIDTH - DOTS_MARGIN, always=(0.0,))
    y, pictures = LINE / 2, []
    for episode in episodes:
        returns, digits = episode.clip.returns, digits_for(episode.clip.returns)
        parts = [stroke(scale.at(scale.low), y, scale.at(scale.high), y, "level")]
        parts += [text("tick", scale.at(mark), LINE + 8, tick_label(mark)) for mark in scale.ticks(TICKS)]
        dots = "".join(dict.fromkeys(f"M{scale.at(value):.0f} {y:.0f}h0" for value in returns))
        parts.append(f'<path class="episodes" d="{dots}"/>')
        mean = statistics.fmean(returns)
        parts.append(stroke(scale.at(mean), y - 9, scale.at(mean), y + 9, "cell-mean"))
        parts.append(disc("shown", scale.at(episode.return_), y, 5.5))
        label = (
            f"Returns of the {len(returns)} episodes: mean {fixed(mean, digits)}, "
            f"from {fixed(min(returns), digits)} to {fixed(max(returns), digits)}; "
            f"the episode shown has {fixed(episode.return_, digits)}"
        )
        pictures.append(picture("dots", DOTS_WIDTH, LINE + 12, label, "".join(parts)))
    return pictures
