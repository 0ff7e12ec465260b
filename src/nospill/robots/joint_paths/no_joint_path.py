"""Why no joint path exists: out of reach, a joint limit, or a singularity; with the place on the path and the size."""

from __future__ import annotations

import numpy as np

from nospill.core.batches import evaluate
from nospill.errors import ROBOT, Reason, ScenarioError
from nospill.paths.path import Path
from nospill.robots.joint_paths.following import Followed, tray_poses
from nospill.robots.kinematics.closed_form import TURN, has_closed_form, solutions_anywhere, with_turns
from nospill.robots.kinematics.forward import Kinematics, kinematics
from nospill.robots.kinematics.newton import pose_columns
from nospill.robots.kinematics.newton_steps import step_functions
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool

_ORIENTATION_WEIGHT = 100.0  # m per rad
_RANDOM_STARTS = 16
_REACHED = 1e-6  # m
_CLEARLY_MISSED = 1e-3  # m
_BISECTIONS = 20
_PLACES = 9
_SAME_BRANCH = 1e-6  # rad


def explain(robot: Robot, path: Path, followed: Followed, *, searched: str = "", tool: Tool) -> ScenarioError:
    """Return the error that says why none of the followed branches is a joint path.

    Args:
        robot: the arm.
        path: path of the tray.
        followed: what `follow` returned for all solutions at the start.
        searched: where else a joint path was looked for, in words that end the message.
        tool: frame carried by the flange.
    """
    if followed.complete.any():
        return _limit_in_the_way(robot, followed, path, searched)
    s = followed.s
    solved = np.array([is_reachable(robot, path, value, tool) for value in s])
    if not solved.all():
        return _out_of_reach(robot, path, s, solved, tool)
    best = int(np.argmax(followed.last))
    farthest = int(followed.last[best])
    joints = ", ".join(f"{value:.0f}" for value in np.degrees(followed.q[best, farthest]))
    lost = float(s[min(farthest + 1, len(s) - 1)])
    count = len(followed.last)
    end = f"all {count} branches end in a singularity, the last" if count > 1 else "its branch ends in a singularity"
    return ScenarioError(
        f"path: robot {robot.name!r} cannot follow it in one go: {end} near {place_in_words(path, lost)} at joints "
        f"({joints}) deg; "
        f"move the path or change its yaw there{searched}",
        Reason(ROBOT, "singularity", robot.name, lost),
    )


def arrives_elsewhere(robot: Robot, path: Path, q: np.ndarray) -> ScenarioError:
    """Return the error for joint motions that all begin or end in other joints than those that are stated.

    Args:
        robot: the arm.
        path: path of the tray, with joints at one of its ends.
        q: (m, n) of the fastest of the motions, rad.
    """
    key, stated, there = next(
        (key, stated, joints)
        for key, stated, joints in zip(("start", "goal"), path.ends, q[[0, -1]], strict=True)
        if stated is not None and not np.allclose(stated, joints, rtol=0.0, atol=_SAME_BRANCH)
    )
    joint = int(np.argmax(np.abs(there - stated)))
    if key == "start":  # it begins in them but for whole turns
        wanted, reached = (f"{np.degrees(joints[joint]):.0f} deg" for joints in (stated, there))
        return ScenarioError(
            f"path: robot {robot.name!r} cannot follow it from the joints stated at its start: "
            f"{robot.joints[joint]} at {wanted} would pass its limits on the way, at {reached} it would not; turn it "
            "before the motion begins, or move the path",
            Reason(ROBOT, "branch", robot.name, 0.0),
        )
    wanted, reached = (", ".join(f"{value:.0f}" for value in np.degrees(joints) + 0.0) for joints in (stated, there))
    return ScenarioError(
        f"path: robot {robot.name!r} arrives in joints ({reached}) deg along it, on another branch than goal.joints "
        f"({wanted}) deg; give goal.position and yaw in their place, or joints of that branch",
        Reason(ROBOT, "branch", robot.name, 1.0),
    )


def place_in_words(path: Path, s: float) -> str:
    """A path parameter and where the tray is there: "s = 0.500 (x, y, z = 600, 186, 900 mm)"."""
    position = np.round(1e3 * path.at(s)[0, :3]) + 0.0  # turns -0.0 into 0.0
    return f"s = {s:.3f} (x, y, z = {', '.join(f'{value:.0f}' for value in position)} mm)"


def _limit_in_the_way(robot: Robot, followed: Followed, path: Path, searched: str) -> ScenarioError:
    """Return the error for the branch that breaks its limits least."""
    joint, limit, worst, first = _least_beyond(robot, followed)
    at_s = float(followed.s[first])
    return ScenarioError(
        f"path: no way to follow it keeps all joint limits of robot {robot.name!r}; the nearest of "
        f"{int(followed.complete.sum())} continuous branches passes {limit} by {np.degrees(worst):.3g} deg, from "
        f"{place_in_words(path, at_s)} on; move the path or change its yaw{searched}",
        Reason(ROBOT, "joint position", robot.joints[joint], at_s, worst, "rad"),
    )


def _least_beyond(robot: Robot, followed: Followed) -> tuple[int, str, float, int]:
    """Of the branch that breaks its limits least, with the whole turns that suit it best: what breaks one most.

    Returns:
        The joint; its limit in words; by how much it is passed, rad; from which sample on.
    """
    best: tuple[float, int, int, np.ndarray] | None = None
    for q in followed.q[followed.complete]:
        # for each joint the whole turns that break its limits least
        turns = np.round((0.5 * (robot.lower + robot.upper) - 0.5 * (q.min(axis=0) + q.max(axis=0))) / TURN)
        options = q + TURN * (turns + np.array([[-1.0], [0.0], [1.0]]))[:, None, :]
        over = np.maximum(np.maximum(robot.lower - options, options - robot.upper), 0.0)
        kept = np.argmin(over.max(axis=1), axis=0)
        joints = np.arange(q.shape[1])
        turned, excess = options[kept, :, joints].T, over[kept, :, joints].T
        joint = int(np.argmax(excess.max(axis=0)))
        worst = float(excess[:, joint].max())
        if best is None or worst < best[0]:
            best = (worst, joint, int(np.argmax(excess[:, joint] > 0)), turned)
    assert best is not None, "called with no complete branch"
    worst, joint, first, turned = best
    upper = turned[first, joint] > robot.upper[joint]
    limit = np.degrees(robot.upper[joint] if upper else robot.lower[joint])
    return joint, f"the {'upper' if upper else 'lower'} limit of {robot.joints[joint]} ({limit:.6g} deg)", worst, first


def farthest_reached(robot: Robot, path: Path, tool: Tool) -> float:
    """How far along the path every place is reachable, by a quick look at some of them; 1 where all of these are.

    Args:
        robot: the arm.
        path: path of the tray.
        tool: frame carried by the flange.
    """
    places = np.linspace(0.0, 1.0, _PLACES)
    reached = 0.0
    for place in places:
        if not is_reachable(robot, path, float(place), tool):
            return reached
        reached = float(place)
    return reached


def require_reachable_ends(robot: Robot, path: Path, tool: Tool) -> None:
    """Refuse a start or a goal that no joints within their limits reach with a level tray, wherever the way leads.

    Out of reach is what is missed by a millimetre or more; limits are looked at where all solutions are known.

    Args:
        robot: the arm.
        path: any path from the start to the goal.
        tool: frame carried by the flange.

    Raises:
        ScenarioError: one of the two is out of reach, or outside of a limit; by how much.
    """
    for name, s in (("start", 0.0), ("goal", 1.0)):
        if is_reachable(robot, path, s, tool):
            _require_within_limits(robot, path, name, s, tool)
            continue
        missed = float(_shortfalls(kinematics(robot), path, np.array([s]), tool)[0])
        if missed < _CLEARLY_MISSED:
            continue
        by = f" by {1000 * missed:.4g} mm" if np.isfinite(missed) else ""
        raise ScenarioError(
            f"path: the {name}, {place_in_words(path, s)}, is out of reach of robot {robot.name!r}{_stated(robot)}"
            f"{by}; move it nearer to the robot's base or away from its axis",
            Reason(ROBOT, "reach", robot.name, s, missed, "m"),
        )


def _require_within_limits(robot: Robot, path: Path, name: str, s: float, tool: Tool) -> None:
    """Refuse an end that the arm reaches outside of its joint limits only; of six joints with a closed form."""
    if redundant_joint(robot) is not None or not has_closed_form(kinematics(robot), None):
        return
    positions, rotations = tray_poses(path, np.array([s]))
    q = solutions_anywhere(robot, positions[0], rotations[0], tool=tool)
    if len(with_turns(robot, q)):
        return
    every = np.ones(len(q), dtype=bool)
    joint, limit, worst, _ = _least_beyond(robot, Followed(np.array([s]), q[:, None], every, 0 * every))
    raise ScenarioError(
        f"path: the {name}, {place_in_words(path, s)}, is reached by robot {robot.name!r} outside of its joint limits "
        f"only; the nearest of {len(q)} configurations passes {limit} by {np.degrees(worst):.3g} deg; "
        f"move the {name} or change its yaw",
        Reason(ROBOT, "joint position", robot.joints[joint], s, worst, "rad"),
    )


def _stated(robot: Robot) -> str:
    return "" if robot.reach is None else f" (stated reach {robot.reach:g} m)"


def is_reachable(robot: Robot, path: Path, s: float, tool: Tool) -> bool:
    """Whether the arm can put the level tray on the path at s, joint limits aside."""
    positions, rotations = tray_poses(path, np.array([s]))
    held = redundant_joint(robot)
    if held is None:
        return len(solutions_anywhere(robot, positions[0], rotations[0], tool=tool)) > 0
    return _shortfalls(kinematics(robot), path, np.array([s]), tool)[0] < _REACHED


def _out_of_reach(robot: Robot, path: Path, s: np.ndarray, solved: np.ndarray, tool: Tool) -> ScenarioError:
    first = int(np.argmin(solved))
    edge = float(s[first])
    if first > 0:
        inside = float(s[first - 1])
        for _ in range(_BISECTIONS):
            middle = 0.5 * (inside + edge)
            if is_reachable(robot, path, middle, tool):
                inside = middle
            else:
                edge = middle
    outside = s[~solved]
    shortfall = _shortfalls(kinematics(robot), path, outside, tool)
    worst = int(np.argmax(shortfall))
    return ScenarioError(
        f"path: out of reach of robot {robot.name!r}{_stated(robot)} from {place_in_words(path, edge)} on, by up to "
        f"{1000 * shortfall[worst]:.4g} mm at {place_in_words(path, float(outside[worst]))}; "
        "move the path nearer to the robot's base or away from its axis",
        Reason(ROBOT, "reach", robot.name, edge, float(shortfall[worst]), "m"),
    )


def _shortfalls(arm: Kinematics, path: Path, s: np.ndarray, tool: Tool, *, iterations: int = 60) -> np.ndarray:
    """Return how far (m,) in m the tray stays from its place on the path when its orientation is kept.

    Damped least squares (Levenberg-Marquardt) on the pose gap with the orientation weighted so heavily that it is
    kept, from several starts; at a place out of reach the gap that remains is the distance to the edge of the
    workspace.
    """
    generator = np.random.default_rng(0)
    positions, rotations = tray_poses(path, np.repeat(s, _RANDOM_STARTS))
    q = generator.uniform(-np.pi, np.pi, size=(len(positions), arm.n))
    weight, pose = np.array([1.0, 1.0, 1.0, *[_ORIENTATION_WEIGHT] * 3]), pose_columns(positions, rotations)

    def linearised(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        gap = evaluate(step_functions(arm, held=False)["gap"], [at.T, pose], arm.shared_of(tool)).T
        return gap * weight, arm.jacobians(at, tool=tool) * weight[:, None]

    gap, jacobian = linearised(q)
    damping = np.full(len(q), 1e-1)
    for _ in range(iterations):
        transposed = np.swapaxes(jacobian, 1, 2)
        normal = transposed @ jacobian + damping[:, None, None] * np.eye(arm.n)
        trial = q + np.linalg.solve(normal, (transposed @ gap[..., None]))[..., 0]
        trial_gap, trial_jacobian = linearised(trial)
        better = np.linalg.norm(trial_gap, axis=1) < np.linalg.norm(gap, axis=1)
        q[better], gap[better], jacobian[better] = trial[better], trial_gap[better], trial_jacobian[better]
        damping = np.clip(np.where(better, damping / 4.0, damping * 6.0), 1e-8, 1e6)
    remaining = np.where(
        np.linalg.norm(gap[:, 3:], axis=1) < 0.1 * _ORIENTATION_WEIGHT, np.linalg.norm(gap[:, :3], axis=1), np.inf
    )
    return remaining.reshape(-1, _RANDOM_STARTS).min(axis=1)
