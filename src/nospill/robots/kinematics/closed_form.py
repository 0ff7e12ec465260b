"""All inverse solutions of an arm, by EAIK's subproblem decomposition polished on our own forward kinematics.

Of a seven-joint arm one joint is held at a given position, which leaves six. Where no closed form is known, Newton's
method is started from many places; what it finds is exact too, but a solution may be missed.

Source: Ostermeier, Kuelz, Althoff, "Automatic geometric decomposition for analytical inverse kinematics", IEEE
RA-L 2025 (EAIK).
EAIK knows neither tool nor limits and mixes least-squares answers in; all three are dealt with here.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from nospill.errors import ScenarioError
from nospill.robots.kinematics.forward import Kinematics, kinematics
from nospill.robots.kinematics.newton import RESIDUAL, Held, newton
from nospill.robots.robot import Robot
from nospill.robots.tool import FLANGE, Tool

TURN = 2.0 * np.pi
SAME = 1e-6
"""Solutions closer than this in every joint (rad, whole turns removed) are one."""

_TRIALS = 8
_ROUGHLY = 1e-3
_RANDOM_STARTS = 256
_RANDOM_ITERATIONS = 60


def inverse_solutions(
    robot: Robot,
    position: np.ndarray,
    rotation: np.ndarray,
    *,
    tool: Tool = FLANGE,
    held: tuple[int, float] | None = None,
) -> np.ndarray:
    """Return every joint position within the limits that puts the tool at a pose.

    Args:
        robot: the arm.
        position: (3,) tool origin in the base frame, m.
        rotation: (3, 3) tool axes to base axes.
        tool: frame carried by the flange.
        held: index and position (rad) of the joint that is given; needed with seven joints.

    Returns:
        (k, n), rad; k is 0 where there is none. A joint that can turn by more than a full turn gives one row per
        admissible turn, at most one full turn away from the middle of its range.

    Raises:
        ScenarioError: the arm has more joints to solve for than six.
    """
    return with_turns(robot, solutions_anywhere(robot, position, rotation, tool=tool, held=held))


def with_turns(robot: Robot, q: np.ndarray) -> np.ndarray:
    """All configurations (j, n) within the limits that differ from given ones (k, n) by whole turns of joints, rad.

    A joint with a range of several turns is kept within one turn of its middle, as in `turn_choices`.
    """
    bottom, more = _turns_within(robot, q)
    fitting = np.all(more >= 0.0, axis=1)
    rows, more = (q + TURN * bottom)[fitting], more[fitting].astype(int)
    for joint in np.flatnonzero(np.any(more > 0, axis=0)):
        again = np.repeat(np.arange(len(rows)), more[:, joint] + 1)
        turns = [turn for count in more[:, joint].tolist() for turn in range(count + 1)]
        rows, more = rows[again], more[again]
        rows[:, joint] += TURN * np.array(turns)
    return rows


def count_turns(robot: Robot, q: np.ndarray) -> np.ndarray:
    """How many configurations `with_turns` makes of each of given ones (k, n), rad: (k,)."""
    return np.prod(np.maximum(_turns_within(robot, q)[1] + 1.0, 0.0), axis=1)


def _turns_within(robot: Robot, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whole turns (k, n) that bring joints to the lowest place in their range, and how many more fit; -1 where none."""
    middle = 0.5 * (robot.lower + robot.upper)
    bottom = np.ceil((np.maximum(robot.lower, middle - TURN) - q) / TURN - 1e-12)
    return bottom, np.floor((np.minimum(robot.upper, middle + TURN) - q) / TURN + 1e-12) - bottom


def turn_choices(robot: Robot, lowest: np.ndarray, highest: np.ndarray) -> list[list[int]]:
    """Return, per joint, the whole turns that may be added to a motion from `lowest` to `highest` (n,) within limits.

    A joint with a range of several turns is kept within one turn of its middle: farther turns are the same motion
    with less space.
    """
    middle = 0.5 * (robot.lower + robot.upper)
    bottom = np.ceil((np.maximum(robot.lower, middle - TURN) - lowest) / TURN - 1e-12)
    top = np.floor((np.minimum(robot.upper, middle + TURN) - highest) / TURN + 1e-12)
    choices = [list(range(int(low), int(high) + 1)) for low, high in zip(bottom, top, strict=True)]
    # a motion wider than the two turns around the middle may still fit into the limits
    for joint, fitting in enumerate(choices):
        if not fitting:
            turn = round(float((middle - 0.5 * (lowest + highest))[joint] / TURN))
            inside = (
                robot.lower[joint] <= lowest[joint] + TURN * turn and highest[joint] + TURN * turn <= robot.upper[joint]
            )
            choices[joint] = [turn] if inside else []
    return choices


def solutions_anywhere(
    robot: Robot,
    position: np.ndarray,
    rotation: np.ndarray,
    *,
    tool: Tool = FLANGE,
    held: tuple[int, float] | None = None,
) -> np.ndarray:
    """Return the distinct exact solutions (k, n) for one pose, limits ignored, every joint in (-pi, pi], rad.

    Raises:
        ScenarioError: the arm has more joints to solve for than six.
    """
    arm = kinematics(robot)
    if arm.n - (held is not None) > 6:
        raise ScenarioError(
            f"robot {robot.name!r} has {arm.n} moving joints; all inverse solutions are available for six, hold one"
        )
    flange_position, flange_rotation = _flange(position, rotation, tool)
    index, value = (None, None) if held is None else held
    solver = _solver(arm, index, value) if has_closed_form(arm, index) else None
    start = _random_starts(arm.n) if solver is None else solver.solutions(flange_position, flange_rotation)
    if held is not None:
        start[:, held[0]] = held[1]
    polished, error = newton(
        arm,
        np.broadcast_to(flange_position, (len(start), 3)),
        np.broadcast_to(flange_rotation, (len(start), 3, 3)),
        start,
        held=None if held is None else Held(np.eye(arm.n)[held[0]], np.full(len(start), held[1])),
        max_iterations=10 if solver is not None else _RANDOM_ITERATIONS,
    )
    found = _wrap(polished[error < RESIDUAL])
    if held is not None:
        found[:, held[0]] = held[1]
    return _distinct(found)


def approximate_solutions(
    robot: Robot,
    positions: np.ndarray,
    rotations: np.ndarray,
    *,
    tool: Tool = FLANGE,
    held: tuple[int, np.ndarray] | None = None,
) -> list[np.ndarray]:
    """Solutions for many poses as the closed form finds them: to some six digits, limits ignored.

    Args:
        robot: the arm.
        positions: (m, 3) tool origin in the base frame, m.
        rotations: (m, 3, 3) tool axes to base axes.
        tool: frame carried by the flange.
        held: index of the joint that is given and its positions (m,), rad; needed with seven joints.

    Returns:
        For each pose (k, n), rad; empty where no closed form is known.
    """
    arm = kinematics(robot)
    index, values = (None, [None] * len(positions)) if held is None else (held[0], held[1].tolist())
    made = {value: _solver(arm, index, value) for value in set(values)}
    solvers = [made[value] for value in values]
    known = [place for place, solver in enumerate(solvers) if solver is not None]
    found = [np.zeros((0, arm.n))] * len(values)
    places, turns = _flange(positions, rotations, tool)
    solved = _solve([solver for solver in solvers if solver is not None], places[known], turns[known])
    for place, q in zip(known, solved, strict=True):
        found[place] = q
    return found


def _flange(position: np.ndarray, rotation: np.ndarray, tool: Tool) -> tuple[np.ndarray, np.ndarray]:
    """Position (..., 3) and rotation (..., 3, 3) of the flange that carries the tool at a pose."""
    flange_rotation = np.asarray(rotation, dtype=float) @ tool.rotation.T
    return np.asarray(position, dtype=float) - flange_rotation @ np.asarray(tool.position, dtype=float), flange_rotation


@lru_cache(maxsize=64)
def has_closed_form(arm: Kinematics, held: int | None) -> bool:
    """Whether EAIK solves the chain with a joint held (None: none is).

    Its own word is not enough: of some chains it knows a decomposition that yields nothing. It has to find its way back
    to configurations all over.
    """
    # multiples of irrational roots (no square is 4 k + 2), modulo 1: importing numpy.random takes 30 ms
    wanted = 4.0 * (np.outer(np.arange(1, _TRIALS + 1), np.sqrt(4.0 * np.arange(arm.n) + 2.0)) % 1.0) - 2.0
    positions, rotations = arm.poses(wanted)
    for q, position, rotation in zip(wanted, positions, rotations, strict=True):
        solver = _solver(arm, held, None if held is None else float(q[held]))
        found = np.zeros((0, arm.n)) if solver is None else solver.solutions(position, rotation)
        if not len(found) or np.abs(_wrap(found - q)).max(axis=1).min() > _ROUGHLY:
            return False
    return True


class _ClosedForm:
    """EAIK's solver for a chain, and the flange's rotation at zero, which EAIK takes as identity."""

    def __init__(self, arm: Kinematics, held: int | None, value: float | None) -> None:
        # imported here: compiled module that only planning needs
        from eaik.pybindings import EAIK

        q = np.zeros((1, arm.n))
        moving = [index for index in range(arm.n) if index != held]
        if held is not None:
            q[0, held] = value
        position, rotation, jacobian = (array[0] for array in arm.poses_and_jacobians(q))
        axes = jacobian[3:, moving].T
        # v = axis x (p - o): the point o of the axis next to the flange is p + axis x v
        points = position + np.cross(axes, jacobian[:3, moving].T)
        offsets = np.diff(np.vstack([np.zeros(3), points, position]), axis=0)
        self.solver = EAIK.Robot(axes.T, offsets.T, np.eye(3), [], True)
        self.from_zero, self.moving, self.at = rotation.T, moving, q[0]
        self.known = bool(self.solver.has_known_decomposition())

    def solutions(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """All joint positions (k, n) for a flange pose, as EAIK finds them; least-squares answers are left out."""
        return _solve([self], position[None], rotation[None])[0]


def _solve(solvers: Sequence[_ClosedForm], positions: np.ndarray, rotations: np.ndarray) -> list[np.ndarray]:
    """`_ClosedForm.solutions` of chains of one arm, each at its own flange pose: (m, 3), m, and (m, 3, 3)."""
    if not solvers:
        return []
    poses = np.zeros((len(solvers), 4, 4))
    poses[:, :3, :3] = rotations @ np.array([solver.from_zero for solver in solvers])
    poses[:, :3, 3], poses[:, 3, 3] = positions, 1.0
    answers = [solver.solver.calculate_IK(pose) for solver, pose in zip(solvers, poses, strict=True)]
    moving = solvers[0].moving
    rows = [np.asarray(answer.Q).reshape(-1, len(moving)) for answer in answers]
    of = np.repeat(np.arange(len(rows)), [len(some) for some in rows])
    joined = np.concatenate(rows)
    exact = ~np.concatenate([np.asarray(answer.is_LS, dtype=bool) for answer in answers])
    exact &= np.isfinite(joined).all(axis=1)
    q = np.array([solver.at for solver in solvers])[of[exact]]
    q[:, moving] = joined[exact]
    return np.split(q, np.searchsorted(of[exact], np.arange(1, len(rows))))


@lru_cache(maxsize=4096)  # a grid of positions of a redundant joint has 1,921 at most
def _solver(arm: Kinematics, held: int | None, value: float | None) -> _ClosedForm | None:
    """The closed form of a chain with six moving joints; None where none is known, or where one follows another."""
    if arm.coupled:
        return None
    try:
        solver = _ClosedForm(arm, held, value)
    except RuntimeError:  # EAIK's word for a geometry it does not know
        return None
    return solver if solver.known else None


def _random_starts(joints: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-np.pi, np.pi, size=(_RANDOM_STARTS, joints))


def _wrap(q: np.ndarray) -> np.ndarray:
    return q - TURN * np.ceil(q / TURN - 0.5)


def _distinct(q: np.ndarray) -> np.ndarray:
    kept: list[np.ndarray] = []
    for row in q:
        if all(np.abs(_wrap(row - other)).max() > SAME for other in kept):
            kept.append(row)
    return np.array(kept).reshape(-1, q.shape[1])
