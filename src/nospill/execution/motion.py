"""What the arm did: the smoothed joints of a log from rest to rest, after a look at whether it can be this arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.errors import ScenarioError
from nospill.execution.log import JointLog
from nospill.execution.sampling import Sampling, sampling_of
from nospill.execution.smoothing import SmoothJoints, smooth_joints
from nospill.motion.interpolation import HeldMotion
from nospill.motion.trajectory import Trajectory
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.scene import Scene

REST = 1e-3
"""rad/s; joints slower than this stand."""

_RESTING = 0.05
"""s; of rest that is put before and after the samples."""
_MIDWAY = 0.05
"""rad/s; a log that begins or ends faster is not of a whole motion."""
_LEANS = np.radians(5.0)
"""A tray that leans by more when the arm stands is on another arm, or its joints are counted from another zero."""
_SPEED_FACTOR = 5.0
"""No arm is so many times as fast as its limits: degrees, or another arm."""
_OUTSIDE = 0.1
"""rad; likewise, beyond the limits of position."""


@dataclass(frozen=True, slots=True)
class Span:
    """Times that are played, from `start` to `stop`, and those of the motion within, `begin` to `end`, s."""

    start: float
    begin: float
    end: float
    stop: float


@dataclass(frozen=True, slots=True, eq=False)
class RecordedMotion:
    """A log as a motion, on the clock of the log.

    Attributes:
        log: as it was read.
        sampling: when its samples were taken.
        smooth: the splines through them.
        begin: when the first joint starts to move, s.
        end: when the last one has stopped, s.
    """

    log: JointLog
    sampling: Sampling
    smooth: SmoothJoints
    begin: float
    end: float

    def held(self, smooth: SmoothJoints | None = None) -> HeldMotion:
        """All that was recorded, with the arm at rest before and after; of other splines where such are given."""
        own = smooth or self.smooth
        return HeldMotion(own, float(own.knots[0]), float(own.knots[-1]))


def recorded_motion(log: JointLog, scene: Scene) -> RecordedMotion:
    """Make a motion of a log.

    Raises:
        ScenarioError: it cannot be of this arm, does not move, or begins or ends in motion.
    """
    _check_positions(log, scene)
    sampling = sampling_of(log)
    smooth = smooth_joints(*_with_rest(sampling, log.position[sampling.kept]), sampling.period)
    t = np.arange(sampling.t[0], sampling.t[-1], sampling.period)
    speed = np.abs(smooth(t, 1))
    _check_speeds(log, scene, t, speed)
    moving = np.flatnonzero(np.max(speed, axis=1) > REST)
    if not len(moving):
        raise ScenarioError(f"{log.origin}: the arm never moves by more than {REST:g} rad/s; give the log of a motion")
    for index, word in ((0, "begins"), (-1, "stops")):
        fastest = int(np.argmax(speed[index]))
        if speed[index, fastest] > _MIDWAY:
            raise ScenarioError(
                f"{log.origin}: the log {word} midway: {log.joints[fastest]} moves at {speed[index, fastest]:.3g} "
                f"rad/s at t = {t[index]:.3f} s; record from rest to rest, since the liquids are known at rest only"
            )
    found = RecordedMotion(log, sampling, smooth, float(t[moving[0]]), float(t[moving[-1]]))
    _check_level(found, scene)
    return found


def samples(motion: HeldMotion, joints: tuple[str, ...], span: Span, rate: float) -> Trajectory:
    """A motion as samples at a rate in Hz, as the judge takes them: standing still outside `begin` to `end`."""
    t = span.start + np.arange(int(np.ceil((span.stop - span.start) * rate - 1e-6)) + 1) / rate
    still = HeldMotion(motion, span.begin, span.end)
    return Trajectory.of_joints(t, joints, *(still(t, order) for order in range(3)))


def _with_rest(sampling: Sampling, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The samples with some at rest before the first and after the last, so that the splines begin and end at rest."""
    count = int(np.ceil(_RESTING / sampling.period))
    rest = sampling.period * np.arange(1, count + 1)
    t = np.concatenate([sampling.t[0] - rest[::-1], sampling.t, sampling.t[-1] + rest])
    return t, np.concatenate(
        [np.repeat(position[:1], count, axis=0), position, np.repeat(position[-1:], count, axis=0)]
    )


def _check_positions(log: JointLog, scene: Scene) -> None:
    robot = scene.robot
    beyond = np.maximum(log.position - robot.upper, robot.lower - log.position)
    row, joint = np.unravel_index(int(np.argmax(beyond)), beyond.shape)
    if beyond[row, joint] > _OUTSIDE:
        raise ScenarioError(
            f"{log.origin}: {log.joints[joint]} stands at {log.position[row, joint]:.4g} rad at t = {log.t[row]:.3f} "
            f"s, where {robot.name} reaches {robot.lower[joint]:.4g} to {robot.upper[joint]:.4g} rad: "
            "the log is in degrees (--unit deg, or columns named q1_deg) or of another robot"
        )


def _check_speeds(log: JointLog, scene: Scene, t: np.ndarray, speed: np.ndarray) -> None:
    use = speed / scene.robot.max_speed
    row, joint = np.unravel_index(int(np.argmax(use)), use.shape)
    if use[row, joint] > _SPEED_FACTOR:
        raise ScenarioError(
            f"{log.origin}: {log.joints[joint]} moves at {speed[row, joint]:.4g} rad/s at t = {t[row]:.3f} s, "
            f"{use[row, joint]:.0f} times its limit: angles in degrees (--unit deg), times not in s, or another robot"
        )


def _check_level(found: RecordedMotion, scene: Scene) -> None:
    position = found.smooth(np.array([found.begin]))
    rest = np.zeros_like(position)
    up = kinematics(scene.robot).motions(position, rest, rest, tool=scene.tray.tool).rotation[0, 2, 2]
    lean = float(np.arccos(np.clip(up, -1.0, 1.0)))
    if lean > _LEANS:
        raise ScenarioError(
            f"{found.log.origin}: the tray leans by {np.degrees(lean):.3g} deg before the motion, where it carries "
            "liquids and loose objects: another robot, joints in another order, or counted from another zero "
            '(--offset joint_3="90 deg")'
        )
