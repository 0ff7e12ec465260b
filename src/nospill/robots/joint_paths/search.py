"""Joint paths: the continuous joint motions that carry the level tray along a path, and the choice among them.

Every branch of the inverse kinematics that exists at the start of the path is followed along all of it with a level
tray, by Newton continuation with step control, so that a branch never jumps. Seven joints have a family of branches for
every position of the redundant joint: a number of positions is tried, each kept along the path; where none leads
through, the joints are left to move as little as they can; where that breaks a limit, too, the whole range of the
redundant joint is searched on a grid (`redundancy_grid`). That gives the planner its start; it may move the redundant
joint as it likes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.batches import evaluate
from nospill.core.hermite import cubic_hermite
from nospill.core.piecewise import Pieces
from nospill.errors import ScenarioError
from nospill.paths.joint_curves import JointCurve
from nospill.paths.path import Path
from nospill.robots.joint_paths.following import Followed, follow, tray_poses, tray_rates
from nospill.robots.joint_paths.no_joint_path import arrives_elsewhere, explain
from nospill.robots.joint_paths.redundancy_grid import PLACES, POSITIONS, paths_on_grid
from nospill.robots.kinematics.closed_form import TURN, has_closed_form, solutions_anywhere, turn_choices
from nospill.robots.kinematics.closed_form import inverse_solutions as inverse_solutions
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.newton import Held, aim_columns, newton
from nospill.robots.kinematics.newton import solve_joints as solve_joints
from nospill.robots.kinematics.newton_steps import step_functions
from nospill.robots.kinematics.redundancy import held_positions, redundant_joint, self_motion
from nospill.robots.robot import Robot
from nospill.robots.tool import FLANGE, Tool

NEARLY_AS_FAST = 1.5
"""A branch may have this many times the best speed figure and still be taken because the arm is near to it."""


_IN_A_SPAN = 4
"""Samples in a span of a path of the joints."""
_SAME_JOINTS = 1e-6
"""rad; joints that are nearer to stated ones are those."""


@dataclass(frozen=True, slots=True)
class JointPath:
    """One continuous way for the joints to carry the level tray along a path.

    Attributes:
        branch: start configuration in words.
        s: (m,) path parameters from 0 to 1.
        q: (m, n) joint positions, rad, all within the limits.
        dq_ds: (m, n) derivative with respect to s, rad.
        speed_figure: max over s and joints of |dq_i/ds| / max_speed_i, s: no motion with s' constant is shorter.
            Smaller is better.
        limit_margin: least distance of a joint to one of its position limits, rad.
    """

    branch: str
    s: np.ndarray
    q: np.ndarray
    dq_ds: np.ndarray
    speed_figure: float
    limit_margin: float

    def at(self, s: np.ndarray) -> np.ndarray:
        """Return joint positions (k, n), rad, at path parameters s (k,) in [0, 1], by cubic Hermite interpolation."""
        span = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, len(self.s) - 2)
        width = (self.s[span + 1] - self.s[span])[:, None]
        u = (np.asarray(s) - self.s[span])[:, None] / width
        ends = np.array([span, span + 1])
        return cubic_hermite(u, width, self.q[ends], self.dq_ds[ends])


def joint_paths(
    robot: Robot,
    path: Path,
    *,
    tool: Tool = FLANGE,
    samples: int = 101,
) -> list[JointPath]:
    """Return every continuous joint motion within the limits that carries the level tray along a path.

    The tray's frame follows position = r(s), rotation = Rz(yaw(s)).

    Args:
        robot: the arm.
        path: path of the tray frame in the robot's base frame.
        tool: frame carried by the flange.
        samples: number of equally spaced path parameters.

    Returns:
        At least one joint path, best first: smallest speed figure, then farthest from the limits, then nearest to
        the middle of the ranges.

    Raises:
        ScenarioError: there is none. The message says whether the path leaves the arm's reach (from which s on,
        by how many mm), a joint limit is in the way (which, where, by how much) or every branch ends in a
        singularity (where).
    """
    tried = try_joint_paths(robot, path, tool=tool, samples=samples)
    if tried.paths:
        return tried.paths
    raise tried.failure()


@dataclass(frozen=True, slots=True)
class TriedPaths:
    """The joint paths along a path of the tray, or how far the arm came.

    Attributes:
        paths: as `joint_paths` returns them; none where there is no joint path.
        reached: path parameter that the best branch comes to; 0 where not even the start is reached.
        failure: the error that says why there is none; takes a while.
    """

    paths: list[JointPath]
    reached: float
    failure: Callable[[], ScenarioError]


def try_joint_paths(
    robot: Robot,
    path: Path,
    *,
    tool: Tool = FLANGE,
    samples: int = 101,
) -> TriedPaths:
    """`joint_paths` for whoever tries many: the reason why there is none is found out only on demand."""
    if path.joint_curve is not None:
        return TriedPaths([prescribed_path(robot, path.joint_curve)], 1.0, _follows)
    s = np.linspace(0.0, 1.0, samples)
    joint = redundant_joint(robot)
    followed: Followed | None = None
    found: list[JointPath] = []
    elsewhere: list[JointPath] = []
    for held, moving in _tries(robot, path, joint, samples):
        starts = _starts(robot, path, joint, moving, tool)
        followed = follow(kinematics(robot), path, s, starts, tool=tool, held=held, moving=moving)
        rates = np.zeros(samples) if moving is None else moving(s, 1)[:, 0]
        through = _within_limits(robot, path, s, [(q, rates) for q in followed.q[followed.complete]], held, tool=tool)
        found = [one for one in through if _keeps_ends(path, one)]
        if found:
            break
        elsewhere = elsewhere or through
    assert followed is not None  # there is one turn of the loop at least
    searched, ends_are_free = "", all(end is None for end in path.ends)
    if not found and ends_are_free and joint is not None and has_closed_form(kinematics(robot), joint):
        held, motions = np.eye(len(robot.joints))[joint], paths_on_grid(robot, path, joint, s, tool=tool)
        found = _within_limits(robot, path, s, motions, held, tool=tool)
        searched = f"; searched: {POSITIONS} positions of {robot.joints[joint]} at {PLACES} places of the path"
    if path.ends[0] is not None:
        searched = "; it begins in the joints stated at its start, and in others the arm may follow it"
    why = partial(explain, robot, path, followed, searched=searched, tool=tool)
    if elsewhere:
        why = partial(arrives_elsewhere, robot, path, elsewhere[0].q)
    return TriedPaths(found, float(s[followed.last].max(initial=0.0)), why)


def prescribed_path(robot: Robot, curve: JointCurve) -> JointPath:
    """A path of the joints as the planner follows one; it keeps the ranges of the joints, its reader saw to it."""
    breaks = curve.pieces.breaks
    inner = breaks[:-1, None] + np.diff(breaks)[:, None] * (np.arange(_IN_A_SPAN) / _IN_A_SPAN)
    s = np.append(inner.ravel(), 1.0)
    q, dq_ds = curve.joints(s), curve.joints(s, 1)
    figure = float((np.abs(dq_ds) / robot.max_speed).max())
    margin = float(np.minimum(q - robot.lower, robot.upper - q).min())
    return JointPath(branch_in_words(q[0]), s, read_only(q), read_only(dq_ds), figure, margin)


def _follows() -> ScenarioError:
    raise AssertionError("a path of the joints is followed")


def _keeps_ends(path: Path, joint_path: JointPath) -> bool:
    """Whether a joint path begins and ends in the joints that are stated."""
    both = zip(path.ends, joint_path.q[[0, -1]], strict=True)
    return all(stated is None or float(np.abs(q - stated).max()) < _SAME_JOINTS for stated, q in both)


def preferred_path(paths: Sequence[JointPath], robot: Robot, near: np.ndarray | None) -> JointPath:
    """Return the joint path to plan with.

    Args:
        paths: as `joint_paths` returns them, best first.
        robot: the arm.
        near: (n,) joint positions from which the arm comes, rad, or None.

    Returns:
        The best one; with `near`, among those whose speed figure is at most `NEARLY_AS_FAST` times the best, the one
        whose start is nearest to it: each joint's way is measured by the time it takes at full speed, and the root of
        the sum of squares counts, so that no joint's way is hidden behind a longer one (of equals the better one).
    """
    if near is None:
        return paths[0]
    able = [path for path in paths if path.speed_figure <= NEARLY_AS_FAST * paths[0].speed_figure]
    # rounded, so that branches as near as each other keep their order
    return min(able, key=lambda path: float(f"{np.linalg.norm((path.q[0] - near) / robot.max_speed):.6g}"))


def path_through(paths: Sequence[JointPath], s: float, q: np.ndarray) -> JointPath:
    """The joint path that passes a place on the path nearest to joint positions q (n,), rad, in which the arm is."""
    return min(paths, key=lambda path: float(np.linalg.norm(path.at(np.array([s]))[0] - q)))


def branch_in_words(q: np.ndarray) -> str:
    """The branch of a configuration q (n,), rad: a branch is named by where it starts."""
    # + 0.0 turns -0 into 0
    return "start (" + ", ".join(f"{value:.0f}" for value in np.round(np.degrees(q)) + 0.0) + ") deg"


def _tries(robot: Robot, path: Path, joint: int | None, samples: int) -> list[tuple[np.ndarray | None, Pieces | None]]:
    """What is held along the path and the values it has there, one try after the other."""
    if joint is None:
        return [(None, None)]
    held = np.eye(len(robot.joints))[joint]
    start, goal = path.ends
    if path.joints is not None:
        # the combination that the self-motion moves everywhere along them: of a joint it may leave at rest
        direction = self_motion(robot, path.joints(np.linspace(0.0, 1.0, samples)))
        known = [(direction, Pieces(path.joints.breaks, path.joints.coefficients @ direction[:, None]))]
    elif start is not None and goal is not None:  # evenly from one to the other
        slope = np.array([goal[joint] - start[joint], start[joint]])
        known = [(held, Pieces(np.array([0.0, 1.0]), slope[:, None, None]))]
    else:
        known = []
    return [*known, (held, None), (None, None)]


def _starts(robot: Robot, path: Path, joint: int | None, moving: Pieces | None, tool: Tool) -> np.ndarray:
    """All solutions (k, n) at the start of the path, the redundant joint of seven at a number of positions.

    Those that are stated at the start, alone, or known there of the path; where they are stated at the goal, the
    redundant joint as there as well.
    """
    start, goal = path.ends
    if start is not None:
        return start[None]
    positions, rotations = tray_poses(path, np.zeros(1))
    if moving is not None and path.joints is not None:
        return newton(kinematics(robot), positions, rotations, path.joints(np.zeros(1)), tool=tool)[0]
    if joint is None:
        return solutions_anywhere(robot, positions[0], rotations[0], tool=tool)
    values = np.append(held_positions(robot, joint), [] if goal is None else goal[joint])
    values = values if moving is None else moving(np.zeros(1))[:, 0]
    found = [solutions_anywhere(robot, positions[0], rotations[0], held=(joint, value), tool=tool) for value in values]
    return np.concatenate(found)


def _within_limits(
    robot: Robot,
    path: Path,
    s: np.ndarray,
    motions: Sequence[tuple[np.ndarray, np.ndarray]],
    held: np.ndarray | None,
    *,
    tool: Tool,
) -> list[JointPath]:
    """The joint paths among motions q (m, n), held . dq/ds (m,) given for each, best first."""
    arm = kinematics(robot)
    prediction, shared = step_functions(arm, held=held is not None)["prediction"], arm.shared_of(tool)
    rates = tray_rates(path, s).T
    found: list[tuple[tuple[float, ...], JointPath]] = []
    middle = 0.5 * (robot.lower + robot.upper)
    for q, held_rate in motions:
        aim = aim_columns(None if held is None else Held(held, q @ held + held_rate), len(q))
        dq_ds = evaluate(prediction, [q.T, rates, aim], shared).T
        figure = float((np.abs(dq_ds) / robot.max_speed).max())
        for turns in product(*turn_choices(robot, q.min(axis=0), q.max(axis=0))):
            turned = q + TURN * np.array(turns)
            margin = float(np.minimum(turned - robot.lower, robot.upper - turned).min())
            off_middle = float((np.abs(turned.mean(axis=0) - middle) / (robot.upper - robot.lower)).sum())
            joint_path = JointPath(branch_in_words(turned[0]), s, read_only(turned), read_only(dq_ds), figure, margin)
            # rounded, so that whole turns of one branch compare by their margins and not by rounding errors
            found.append(((float(f"{figure:.6g}"), -float(f"{margin:.6g}"), off_middle), joint_path))
    return [joint_path for _, joint_path in sorted(found, key=lambda entry: entry[0])]
