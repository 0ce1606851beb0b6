"""The oracle solves every task without a collision."""

import math

import numpy as np
import pytest

from gym_extensions.catalog.tasks import task
from gym_extensions.envs.navigation.env import Navigation, World
from gym_extensions.envs.navigation.geometry import Arena, goals, parse
from gym_extensions.envs.navigation.planner import FINENESS, NEVER, Oracle, lookahead, oracle_returns

ROOM = parse(["#" * 40, *["#" + "." * 38 + "#"] * 38, "#" * 40])
# One wall across the room at x 200-210, with a passage of one cell at y 380-390 (the room's top).
WALL = parse(["#" * 40, "#" + "." * 38 + "#", *["#" + "." * 19 + "#" + "." * 18 + "#"] * 37, "#" * 40])


def run(oracle: Oracle, starts: np.ndarray, limit: int = 1000) -> tuple[np.ndarray, np.ndarray]:
    """Steps taken and return of one episode from each start."""
    world, lanes = World([oracle.arena] * len(starts), "state"), len(starts)
    for lane, start in enumerate(starts):
        world.positions[lane] = start
    steps, returns, arrived = np.zeros(lanes, int), np.zeros(lanes), np.zeros(lanes, bool)
    for _ in range(limit):
        if arrived.all():
            break
        actions = np.array(
            [
                np.zeros(2) if done else oracle.act(point)
                for point, done in zip(world.positions, arrived, strict=True)
            ]
        )
        rewards, reached = world.advance(actions, arrived)
        steps += ~arrived
        returns += rewards
        arrived |= reached
    assert arrived.all()
    return steps, returns


def fewest_in_the_open(start: np.ndarray, goal: tuple[float, float]) -> int:
    """Steps of at most 5 in x and in y after which the distance can be 20 or less, nothing being in the
    way."""
    gap_x, gap_y = np.abs(start - goal)
    return next(n for n in range(1, 1000) if math.hypot(max(gap_x - 5 * n, 0), max(gap_y - 5 * n, 0)) <= 20)


def test_in_an_open_room_the_oracle_takes_the_fewest_steps_from_anywhere() -> None:
    goal = (305.0, 95.0)
    starts = np.random.default_rng(0).uniform(11, 389, (15, 2))
    starts = starts[np.hypot(*(starts - goal).T) > 21]
    steps, returns = run(Oracle(Arena(ROOM, goal)), starts)
    assert steps.tolist() == [fewest_in_the_open(start, goal) for start in starts]
    assert returns.tolist() == (10.0 - steps).tolist()


def test_around_a_wall_the_oracle_takes_the_fewest_steps_by_hand() -> None:
    # Wall: x 200-210, up to y 380. From (150, 300) to within 20 of (250, 300): up over the corner and down
    # again. The left end of the passage (200, 380+) is max(50, 80) = 80 away: 16 steps. 10 units of x cross
    # the wall's top: 2 steps. From (210, 380+) down to the disc, whose nearest point in steps of 5 x 5 is
    # (243, 319): 61 / 5 = 12.2. Together 80 + 10 + 61 = 151 units, at least 31 steps; the corners are not
    # touched, so some of that is lost.
    steps, _ = run(Oracle(Arena(WALL, (250.0, 300.0))), np.array([[150.0, 300.0]]))
    assert steps[0] in (31, 32)


GOALS = [
    pytest.param(number, goal, marks=() if goal == number % 3 else pytest.mark.slow)
    for number, goal in sorted(goals())
]
"""Every goal; one per map belongs to the quick tests, because a plan takes a second."""


@pytest.mark.parametrize(("number", "goal"), GOALS)
def test_every_goal_is_reached_from_every_free_cell_without_a_collision(number: int, goal: int) -> None:
    oracle = Oracle.at(number, goal)
    cells = oracle.arena.grid.cells
    # The plan has steps to go from each of its points, 400 a cell, in all free cells. A cell is convex, so
    # from any point in it some of its lattice points lie within one step: there is a way from everywhere.
    planned = oracle.steps.reshape(48, 10 * FINENESS, 64, 10 * FINENESS).transpose(0, 2, 1, 3)
    assert (planned[~cells] >= 0).all()
    assert (planned[cells] == -1).all()
    # And it is gone: from starts drawn over the whole of free space, corners of cells included.
    generator = np.random.default_rng(number * 3 + goal)
    free = np.argwhere(~cells)[:, ::-1]
    chosen = free[generator.choice(len(free), 3, replace=False)]
    starts = chosen * 10 + generator.uniform(0.001, 9.999, (3, 2))
    where = oracle.arena.grid.solid, oracle.steps, np.array(oracle.arena.goal)
    bound = [lookahead(*where, x, y, NEVER)[0] for x, y in starts]
    steps, returns = run(oracle, starts)
    assert (steps <= np.maximum(bound, 1)).all()
    assert (steps >= [fewest_in_the_open(start, oracle.arena.goal) for start in starts]).all()
    # No collision: the return is -1 a step and +10 at the goal.
    assert returns.tolist() == (10.0 - steps).tolist()


def test_the_oracles_returns_are_those_of_single_episodes_and_the_same_in_every_family() -> None:
    seeds = [3, 4, 2**31 - 1]
    returns = oracle_returns(task("Limited-Range-Based-Navigation-2d-Map5-Goal1"), seeds)
    assert returns.tolist() == oracle_returns(task("State-Based-Navigation-2d-Map5-Goal1"), seeds).tolist()
    env, oracle = Navigation(task("State-Based-Navigation-2d-Map5-Goal1")), Oracle.at(5, 1)
    for seed, expected in zip(seeds, returns, strict=True):
        env.reset(seed=seed)
        total, ended = 0.0, False
        while not ended:
            _, reward, ended, _, _ = env.step(oracle.act(env.position))
            total += reward
        assert total == expected
