"""What the arm did: the smoothed joints of a log from rest to rest, after a look at whether it can be this arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.certification.plausibility import lean_at
from nospill.errors import ScenarioError
from nospill.execution.log import JointLog
from nospill.execution.sampling import Sampling, sampling_of
from nospill.execution.smoothing import BANDWIDTH, SmoothJoints, smooth_joints
from nospill.motion.interpolation import HeldMotion
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene

REST = 1e-3
"""rad/s; joints slower than this stand, and those whose speed is not told from noise."""

_TOLD_FROM_NOISE, _LOOKS = 5.0, 100
"""Standard deviations of the speed that noise alone hardly reaches, and instants at which they are looked at."""
_LONGEST_STOP = 0.02
"""s; likewise, until it stands."""
_NO_SENSOR = 1e-8
"""rad; of noise: encoders of the logs at hand have 1e-7 and more, commands and computed joints 1e-9 and less."""
_RESTING = 0.05
"""s; before and after the samples, in which the arm comes to rest whatever it does in them."""
_OF_CUBIC = 4
"""Samples that a cubic goes through."""
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
        coarser: likewise, with knots twice as far apart.
        is_exact: whether the log has no noise, as no sensor writes it: it is taken as it is.
        bandwidth: of the splines, Hz.
        begin: when the first joint starts to move, s.
        end: when the last one has stopped, s.
    """

    log: JointLog
    sampling: Sampling
    smooth: SmoothJoints
    coarser: SmoothJoints
    is_exact: bool
    bandwidth: float
    begin: float
    end: float

    def reading(self, position: np.ndarray) -> SmoothJoints:
        """The splines through other positions (k, n), rad, that were taken when the samples were."""
        return _fitted(position, self.sampling, self.bandwidth, is_exact=self.is_exact)

    def held(self, smooth: SmoothJoints | None = None) -> HeldMotion:
        """All that was recorded, with the arm at rest before and after; of other splines where such are given."""
        own = smooth or self.smooth
        return HeldMotion(own, float(own.knots[0]), float(own.knots[-1]))


def recorded_motion(log: JointLog, scene: Scene, *, bandwidth: float = BANDWIDTH) -> RecordedMotion:
    """Make a motion of a log.

    Args:
        log: of the joints.
        scene: with the robot.
        bandwidth: of the motion that is followed, Hz; what is faster counts as noise.

    Raises:
        ScenarioError: it cannot be of this arm, does not move, or begins or ends in motion.
    """
    _check_positions(log, scene)
    sampling = sampling_of(log)
    smooth, coarser, followed, is_exact = _smooth(log.position[sampling.kept], sampling, bandwidth)
    t = np.arange(sampling.t[0], sampling.t[-1], sampling.period)
    speed = np.abs(smooth(t, 1))
    _check_speeds(log, scene, t, speed)
    noise = np.median(smooth.deviation(np.linspace(t[0], t[-1], _LOOKS), 1), axis=0)
    moving = np.flatnonzero(np.any(speed > np.maximum(REST, _TOLD_FROM_NOISE * noise), axis=1))
    if not len(moving):
        raise ScenarioError(f"{log.origin}: the arm never moves by more than {REST:g} rad/s; give the log of a motion")
    for index, word in ((0, "begins"), (-1, "stops")):
        fastest = int(np.argmax(speed[index]))
        if speed[index, fastest] > _MIDWAY:
            raise ScenarioError(
                f"{log.origin}: the log {word} midway: {log.joints[fastest]} moves at {speed[index, fastest]:.3g} "
                f"rad/s at t = {t[index]:.3f} s; record from rest to rest, since the liquids are known at rest only"
            )
    motion = RecordedMotion(
        log,
        sampling,
        smooth,
        coarser,
        is_exact=is_exact,
        bandwidth=followed,
        begin=float(t[moving[0]]),
        end=float(t[moving[-1]]),
    )
    _check_level(motion, scene)
    return motion


def _smooth(
    position: np.ndarray, sampling: Sampling, bandwidth: float
) -> tuple[SmoothJoints, SmoothJoints, float, bool]:
    """The splines, those with knots twice as far apart, the bandwidth, Hz, and whether the samples have no noise.

    The bandwidth is all of it where they have none.
    """
    highest = 0.5 / sampling.period
    is_exact = bool(np.max(_fitted(position, sampling, highest, is_exact=False).noise) <= _NO_SENSOR)
    bandwidth = highest if is_exact else min(bandwidth, highest)
    fine, coarse = (_fitted(position, sampling, part * bandwidth, is_exact=is_exact) for part in (1.0, 0.5))
    return fine, coarse, bandwidth, is_exact


def _fitted(position: np.ndarray, sampling: Sampling, bandwidth: float, *, is_exact: bool) -> SmoothJoints:
    """The splines through positions (k, n), rad, taken at the samples.

    Where the arm stands in the first or last sample it stood before, or stands on: in a log without noise that is known
    as well as the samples are, and a motion that begins with the log is not led up to.
    """
    t, period = sampling.t, sampling.period
    if is_exact:
        steps, ends = round(_RESTING / period), (position[:_OF_CUBIC], position[: -_OF_CUBIC - 1 : -1])
        before, after = (steps if _stands(end, period) else 0 for end in ends)
        more = period * np.arange(1, steps + 1)
        t = np.concatenate([t[0] - more[:before][::-1], t, t[-1] + more[:after]])
        position = np.pad(position, ((before, after), (0, 0)), mode="edge")
    return smooth_joints(t, position, period, bandwidth=bandwidth, rest=_RESTING)


def _stands(position: np.ndarray, period: float) -> bool:
    """Whether the arm stands in the first of four samples (4, n), rad: its speed there is that of the cubic in them."""
    speed = np.array([-11.0, 18.0, -9.0, 2.0]) @ position / (6.0 * period)
    return bool(np.all(np.abs(speed) <= REST))


def stopping_time(recorded: RecordedMotion) -> float:
    """From when the last joint is told to move until it stands, s: its speed fades as it does under a constant jerk.

    With the jerk J it is J tau^2/2 and slows down by J tau, a time tau before the end.
    """
    speed, slowing = (np.abs(recorded.smooth(np.array([recorded.end]), order)[0]) for order in (1, 2))
    joint = int(np.argmax(speed))
    return float(min(2.0 * speed[joint] / slowing[joint], _LONGEST_STOP)) if slowing[joint] > 0.0 else 0.0


def samples(motion: HeldMotion, joints: tuple[str, ...], span: Span, rate: float) -> Trajectory:
    """A motion as samples at a rate in Hz, as the judge takes them: standing still outside `begin` to `end`."""
    t = span.start + np.arange(int(np.ceil((span.stop - span.start) * rate - 1e-6)) + 1) / rate
    still = HeldMotion(motion, span.begin, span.end)
    return Trajectory.of_joints(t, joints, *(still(t, order) for order in range(3)))


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
    lean = lean_at(found.smooth(np.array([found.begin]))[0], scene)
    if lean > _LEANS:
        raise ScenarioError(
            f"{found.log.origin}: the tray leans by {np.degrees(lean):.3g} deg before the motion, where it carries "
            "liquids and loose objects: another robot, joints in another order, or counted from another zero "
            '(--offset joint_3="90 deg")'
        )
