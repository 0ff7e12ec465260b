"""Smooth motions along the path, from rest to rest, from which a search starts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.constraints.trough import Trough
from nospill.laws.constraints.via import PassedPlace
from nospill.laws.like_objects import bearable_acceleration
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.robots.joint_paths.search import JointPath
from nospill.robots.kinematics.redundancy import self_motion
from nospill.scene.initial_state import InitialState
from nospill.scene.scene import Scene
from nospill.transcription.export_samples import with_joints_solved
from nospill.transcription.layout import layout_of
from nospill.transcription.resampling import resolving_intervals
from nospill.transcription.stages import Stages


@dataclass(frozen=True, slots=True)
class Start:
    """How a starting motion differs from the plain quintic.

    Attributes:
        stretch: factor on the estimated duration.
        skew: shifts the middle of the motion earlier (negative) or later, -0.3 to 0.3.
        tilt: (2,) rad, amplitude of a smooth lean of theta_x and theta_y, where free.
    """

    stretch: float = 1.0
    skew: float = 0.0
    tilt: tuple[float, float] = (0.0, 0.0)


COARSEST = 25
COARSE_SWING = 2.5
"""Most of a liquid's swing in an interval, rad."""

HIDDEN_AT_START = (SloshHeight.name, Trough.name, PassedPlace.name)
"""Constraints of which no start says anything: its liquids are at rest, and it is on its way through the places."""

USUAL_START = Start(stretch=0.7)
"""The start that is tried first."""

_FIXED_STARTS = (USUAL_START, Start(stretch=0.6, skew=-0.45), Start(stretch=0.5, skew=0.25))


def quintic(tau: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """10 tau^3 - 15 tau^4 + 6 tau^5 and its first two derivatives: rest to rest over the unit interval."""
    return (
        tau**3 * (10 - 15 * tau + 6 * tau**2),
        30 * tau**2 * (1 - tau) ** 2,
        60 * tau * (1 - tau) * (1 - 2 * tau),
    )


def estimate_duration(scene: Scene, joint_path: JointPath) -> float:
    """End time of a quintic motion that uses about half of friction and slosh height and 80 % of joint speed, s."""
    s, rate, change = quintic(np.linspace(0.0, 1.0, 201))
    first, second = scene.path.derivative(s, 1), scene.path.derivative(s, 2)
    unit_acceleration = second * rate[:, None] ** 2 + first * change[:, None]
    objects = numbers_of(scene).objects
    offset = max((float(np.hypot(*item.position[:2])) for item in objects), default=0.0)
    turning = offset * (np.abs(unit_acceleration[:, 3]) + (first[:, 3] * rate) ** 2)
    demand = float(np.max(np.linalg.norm(unit_acceleration[:, :3], axis=1) + turning))
    borne = (
        bearable_acceleration(item, fixed=own.fixed, lid=own.lid)
        for own, item in zip(structure_of(scene).objects, objects, strict=True)
    )
    allowed = 0.5 * min(borne, default=np.inf)
    speeds = np.array([np.interp(s, joint_path.s, column) for column in joint_path.dq_ds.T]).T * rate[:, None]
    fastest = float(np.max(np.abs(speeds) / (0.8 * scene.robot.max_speed)))
    jerk = (60.0 / scene.motion.path_jerk_limit) ** (1 / 3)
    tray = _least_by_tray(scene, first[:, :3] * rate[:, None], unit_acceleration[:, :3])
    return float(np.clip(max(np.sqrt(demand / allowed), fastest, jerk, tray), 0.1, 0.8 * scene.motion.longest))


def _least_by_tray(scene: Scene, velocity: np.ndarray, acceleration: np.ndarray) -> float:
    """Duration in which a motion keeps the limits of the tray's centre, s, from its rates (m, 3) over a second."""
    rules, fastest, hardest = scene.motion, *(np.max(np.linalg.norm(part, axis=1)) for part in (velocity, acceleration))
    by_speed = 0.0 if rules.max_speed is None else fastest / rules.max_speed
    by_acceleration = 0.0 if rules.max_acceleration is None else np.sqrt(hardest / rules.max_acceleration)
    return float(max(by_speed, by_acceleration))


def smooth_start(scene: Scene, joint_path: JointPath, intervals: int, start: Start = Start()) -> Stages:
    """A smooth motion along the path with the liquids at rest, on a grid of `intervals`."""
    if scene.initial_state is not None:
        return _going_on(scene, scene.initial_state, joint_path, intervals, start)
    estimate = min(estimate_duration(scene, joint_path) * start.stretch, 0.95 * scene.motion.max_duration)
    duration = scene.motion.duration or estimate
    tau = np.linspace(0.0, 1.0, intervals + 1)
    # Time is warped by w(tau) = tau + skew tau (1 - tau), monotone for |skew| < 1.
    warp, warp_rate = tau + start.skew * tau * (1 - tau), 1 + start.skew * (1 - 2 * tau)
    s, rate, change = quintic(warp)
    chains = [(s, rate * warp_rate / duration, (change * warp_rate**2 - 2 * start.skew * rate) / duration**2)]
    layout = layout_of(structure_of(scene))
    for amplitude in start.tilt if layout.freedom.tilt else ():
        bump = 64 * tau**3 * (1 - tau) ** 3
        slope = 192 * tau**2 * (1 - tau) ** 2 * (1 - 2 * tau)
        bend = 384 * tau * (1 - tau) * (1 - 5 * tau + 5 * tau**2)
        chains.append((amplitude * bump, amplitude * slope / duration, amplitude * bend / duration**2))
    chains += [(np.zeros_like(tau),) * 3] * (layout.freedom.chains - len(chains))
    return motion_along(scene, joint_path, [np.column_stack(chain) for chain in chains], duration)


def _going_on(scene: Scene, state: InitialState, joint_path: JointPath, intervals: int, start: Start) -> Stages:
    """A smooth motion from a state to rest, at the end of the path or, for a stop, half as far as its speed leads."""
    left = 1.0 - state.s
    estimate = estimate_duration(scene, joint_path) * start.stretch * np.sqrt(left)
    if state.s_rate > 0.0:  # longer, and it would pass the end and come back
        estimate = min(estimate, 2.0 * left / state.s_rate)
    duration = scene.motion.duration or float(np.clip(estimate, 0.05, 0.95 * scene.motion.max_duration))
    return motion_to_rest(scene, state, joint_path, intervals, duration)


def motion_to_rest(scene: Scene, state: InitialState, joint_path: JointPath, intervals: int, duration: float) -> Stages:
    """A smooth motion of a duration, s, from a state to rest, on a grid of `intervals`.

    It ends at the end of the path or, a stop, where its speed leads if it falls evenly.
    """
    end = min(1.0, state.s + 0.5 * state.s_rate * duration) if scene.motion.stop else 1.0
    tau = np.linspace(0.0, 1.0, intervals + 1)
    freedom = layout_of(structure_of(scene)).freedom
    first = state.chains(tilt=freedom.tilt, offset=freedom.offset, yaw=freedom.yaw)
    goals = np.append(end, np.zeros(len(first) - 1))
    chains = [to_rest(tau, chain, goal, duration) for chain, goal in zip(first, goals, strict=True)]
    motion = motion_along(scene, joint_path, chains, duration)
    return with_joints_solved(scene, motion) if scene.motion.leaves_path else motion


def to_rest(tau: np.ndarray, state: np.ndarray, goal: float, duration: float) -> np.ndarray:
    """The quintic (m, 3) from value, rate and acceleration (3,) to rest at a goal, at parts tau (m,) of a time, s."""
    value, rate, change = state * np.array([1.0, duration, duration**2])
    way, slope, bend = quintic(tau)
    # what rest to rest lacks: the least polynomials with the rate, and the acceleration, at 0 and nothing else
    powers = np.array([tau**power for power in range(6)])
    of_rate, of_change = np.array([0, 1, 0, -6, 8, -3.0]), np.array([0, 0, 0.5, -1.5, 1.5, -0.5])
    own = rate * of_rate + change * of_change
    rises = np.arange(1, 6)
    first, second = own[1:] * rises, (own[1:] * rises)[1:] * rises[:4]
    return np.column_stack(
        [
            value + (goal - value) * way + own @ powers,
            ((goal - value) * slope + first @ powers[:5]) / duration,
            ((goal - value) * bend + second @ powers[:4]) / duration**2,
        ]
    )


def motion_along(scene: Scene, joint_path: JointPath, chains: Sequence[np.ndarray], duration: float) -> Stages:
    """A motion along the path with the liquids at rest, from its path parameter and tilt angles at every node.

    Args:
        scene: of the motion.
        joint_path: the arm's way along the path.
        chains: of the path parameter and of every free tilt angle, (N + 1, 3): value, rate and acceleration, which the
            motion follows as closely as jerks that are constant in every interval can.
        duration: s.
    """
    intervals, layout = len(chains[0]) - 1, layout_of(structure_of(scene))
    table = np.zeros((intervals + 1, layout.size))
    closed = [_close(chain, duration / intervals) for chain in chains]
    s, rate = closed[0][0][:, 0], closed[0][0][:, 1]
    slopes = np.array([np.interp(s, joint_path.s, column) for column in joint_path.dq_ds.T]).T
    joints, speeds = joint_path.at(np.clip(s, 0.0, 1.0)), slopes * rate[:, None]
    direction = self_motion(scene.robot, joints) if layout.redundant else None
    if direction is not None:
        change = np.gradient(speeds @ direction, duration / intervals)
        own = np.column_stack([joints @ direction, speeds @ direction, change])
        closed.append(_close(own, duration / intervals))
    for index, (states, jerks) in enumerate(closed):
        table[:, 3 * index : 3 * index + 3] = states
        table[:-1, layout.jerks.start + index] = jerks
    table[:, layout.interval] = duration / intervals
    table[:, layout.joint_position], table[:, layout.joint_speed] = joints, speeds
    for order in range(2, layout.orders + 1):
        table[:, layout.joint_derivative(order)] = np.gradient(
            table[:, layout.joint_derivative(order - 1)], duration / intervals, axis=0
        )
    return Stages(duration / intervals, table, direction)


def coarse_start(scene: Scene, joint_path: JointPath, start: Start = USUAL_START) -> Stages:
    """A smooth motion along the path on the coarse grid, on which starts are compared."""
    fewest = resolving_intervals(scene, estimate_duration(scene, joint_path), COARSE_SWING)
    return smooth_start(scene, joint_path, max(COARSEST, scene.planning.intervals // 4, fewest), start)


def _close(states: np.ndarray, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """States (N + 1, 3) and jerks (N,) of a chain near the given states, each state following from the one before.

    The jerks are the differences of the accelerations, with the least change that leads to the given end.
    """
    count, h = len(states) - 1, interval
    step = np.array([[1.0, h, h * h / 2], [0.0, 1.0, h], [0.0, 0.0, 1.0]])
    push = np.array([h**3 / 6, h * h / 2, h])
    remaining = h * np.arange(count - 1, -1, -1)
    # effect of each jerk on the end: the push of its interval, carried over what remains
    reach = np.array([push[0] + push[1] * remaining + push[2] * remaining**2 / 2, push[1] + push[2] * remaining])
    reach = np.vstack([reach, np.full(count, push[2])])
    jerks = np.diff(states[:, 2]) / h
    total = h * count
    drift = np.array([[1.0, total, total * total / 2], [0.0, 1.0, total], [0.0, 0.0, 1.0]]) @ states[0]
    jerks = jerks + np.linalg.lstsq(reach, states[-1] - drift - reach @ jerks, rcond=None)[0]
    closed = np.empty_like(states)
    closed[0] = states[0]
    for index in range(count):
        closed[index + 1] = step @ closed[index] + push * jerks[index]
    return closed, jerks


def starting_motions(scene: Scene, count: int) -> Iterator[Start]:
    """Starting motions: three fixed ones (even, early, late), then random ones from the scene's seed."""
    yield from _FIXED_STARTS
    random = np.random.default_rng(scene.planning.seed)
    for _ in range(count - len(_FIXED_STARTS)):
        lean = random.uniform(-0.3, 0.3, 2) * min(1.0, scene.motion.max_tilt / 0.3)
        yield Start(
            stretch=float(random.uniform(0.4, 1.6)),
            skew=float(random.uniform(-0.6, 0.6)),
            tilt=(float(lean[0]), float(lean[1])),
        )
