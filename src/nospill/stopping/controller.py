"""What a controller's own stop does: each joint braked by itself, or time scaled to zero along the path.

The motion is the plan until the instant, then the brake, sampled at the plan's rate. It is judged as a spill-free stop
is, from a few samples of the plan before it to a second of rest after: the quintic spline through the samples, so that
its acceleration jumps within a period.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from nospill.certification.by_flow import broken_flows
from nospill.certification.certificate import Judgement, judge_joints
from nospill.errors import ModelError
from nospill.laws.constraints import OBJECT_NAMES
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.motion.interpolation import HeldMotion, JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.plans.stops import ControllerStop
from nospill.scene.scene import Scene
from nospill.stopping.splices import Splice

_HIGHEST = 0.3
"""m; a crest so far above its limit is a figure of linear equations and of no liquid."""


@dataclass(frozen=True, slots=True)
class BrakedJoints:
    """A motion until an instant, from which each joint falls evenly to rest by itself.

    Attributes:
        before: the motion.
        at: s, the instant.
        deceleration: (n,) rad/s^2.
    """

    before: JointMotion
    at: float
    deceleration: np.ndarray

    @property
    def duration(self) -> float:
        """Until the last joint stands, s."""
        return float(np.max(np.abs(self._state[1]) / self.deceleration))

    @property
    def _state(self) -> tuple[np.ndarray, np.ndarray]:
        q, speed = (self.before(np.array([self.at]), order)[0] for order in range(2))
        return q, speed

    def __call__(self, t: np.ndarray, order: int = 0, /) -> np.ndarray:
        """The derivative of this order at times t (m,)."""
        values = self.before(np.minimum(t, self.at), order)
        late = t > self.at
        if not np.any(late):
            return values
        q, speed = self._state
        slope = -np.sign(speed) * self.deceleration
        since = (t[late] - self.at)[:, None]
        moving = since < np.abs(speed) / self.deceleration
        since = np.minimum(since, np.abs(speed) / self.deceleration)
        parts = [q + speed * since + slope * since**2 / 2, speed + slope * since, np.where(moving, slope, 0.0)]
        values[late] = parts[order] if order < 3 else 0.0
        return values


@dataclass(frozen=True, slots=True)
class SlowedClock:
    """A motion whose clock falls evenly to a stop from an instant on: the poses are those of its path.

    Attributes:
        before: the motion.
        at: s, the instant.
        duration: s, in which time comes to a stop; half of it is left of the motion's own time.
    """

    before: JointMotion
    at: float
    duration: float

    def __call__(self, t: np.ndarray, order: int = 0, /) -> np.ndarray:
        """The derivative of this order at times t (m,)."""
        since = np.clip(t - self.at, 0.0, self.duration)
        rate, change = 1.0 - since / self.duration, np.where((t > self.at) & (t < self.at + self.duration), -1.0, 0.0)
        change /= self.duration
        clock = np.minimum(t, self.at) + since - since**2 / (2.0 * self.duration)
        rate, change = rate[:, None], change[:, None]
        if order == 0:
            return self.before(clock)
        if order == 1:
            return self.before(clock, 1) * rate
        if order == 2:
            return self.before(clock, 2) * rate**2 + self.before(clock, 1) * change
        return self.before(clock, 3) * rate**3 + 3.0 * self.before(clock, 2) * rate * change


def braked(splice: Splice, deceleration: np.ndarray) -> ControllerStop:
    """The verdict on the stop in which each joint brakes by itself, with a deceleration (n,), rad/s^2."""
    motion = BrakedJoints(splice.record.motion, splice.t, deceleration)
    return _judged(splice, motion, "joints", motion.duration)


def slowed_to_rest(splice: Splice, slowing: float) -> ControllerStop:
    """The verdict on the stop in which time is scaled to zero along the path within a time `slowing`, s."""
    return _judged(splice, SlowedClock(splice.record.motion, splice.t, slowing), "path", slowing)


def scene_to_rest(scene: Scene, residual: float) -> Scene:
    """The scene of a plan and a stop of it as one motion from rest, which ends as stops do.

    Args:
        scene: of the plan.
        residual: how high liquids may swing on, over max_slosh_height; of the modes, as a stop has them.
    """
    rules = replace(scene.motion, end="residual", residual_fraction=residual, residual_height="linear")
    return replace(scene, motion=rules)


def judged_to_rest(motion: JointMotion, end: float, rate: float, scene: Scene, after: float = 1.0) -> Judgement:
    """The verdict on joints that come to rest at an end, s, and stand for a time after it, s, from samples at a rate.

    Raises:
        ModelError: the liquids cannot be integrated.
    """
    return judge_joints(_sampled(motion, 0.0, end + after, rate, scene), scene)


def _sampled(motion: JointMotion, begin: float, end: float, rate: float, scene: Scene) -> Trajectory:
    """Samples of joints from one time to another, s, on a clock that begins with them."""
    times = np.arange(int(np.ceil((end - begin) * rate)) + 1) / rate
    held = HeldMotion(motion, begin, begin + float(times[-1]))
    return Trajectory.of_joints(times, scene.robot.joints, *(held(begin + times, order) for order in range(3)))


def _judged(splice: Splice, motion: JointMotion, kind: Literal["joints", "path"], duration: float) -> ControllerStop:
    t, scene = splice.t, splice.scene
    end = t + duration + scene.motion.hold_after
    record = replace(_sampled(motion, splice.lead.t, end, splice.record.rate, scene), in_motion=True)
    try:
        judgement = judge_joints(record, scene)
        certificate = judgement.certificate
    except ModelError:  # the liquid moves as no linear one does
        return ControllerStop(t, kind, duration, False, math.inf, {})
    broken = [row for row in certificate.rows if not row.ok and row.constraint in OBJECT_NAMES]
    over = [row.worst_value - row.limit for row in broken if row.constraint == SloshHeight.name]
    if max(over, default=0.0) > _HIGHEST:
        return ControllerStop(t, kind, duration, False, math.inf, {})
    uses = {f"{row.constraint} | {row.subject}": row.use for row in broken}
    spill = math.inf if broken_flows(scene, judgement.replay) else max(over, default=0.0)
    return ControllerStop(t, kind, duration, certificate.ok, spill, uses)
