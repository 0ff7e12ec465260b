"""A planned motion in another time: every joint on its planned way, at the times that a law says."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nospill.core.attitudes import tray_quaternions, yaw_of
from nospill.motion.interpolation import QUINTIC_SPLINE, HeldMotion, JointMotion, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.scene import Scene

SHAPES = 8
"""Coefficients of a time law: with them the liquids of most plans are brought to rest at other speeds."""


@dataclass(frozen=True, slots=True, eq=False)
class TimeLaw:
    """Planned time over time, by its rate: a cubic spline on even knots that is nowhere zero.

    Attributes:
        length: of the planned motion, s.
        duration: of the other one, s.
        shape: (k,) coefficients of the spline, above zero; the rate is proportional to it. Equal ones are the same
            motion slowed down throughout, as a controller's override does it.
    """

    length: float
    duration: float
    shape: np.ndarray

    @classmethod
    def even(cls, length: float, duration: float) -> TimeLaw:
        """The same motion at one rate."""
        return cls(length, duration, np.ones(SHAPES))

    @property
    def fastest(self) -> float:
        """Largest rate of planned time."""
        return float(np.max(self(np.linspace(0.0, self.duration, 200))[1]))

    def __call__(self, t: np.ndarray) -> list[np.ndarray]:
        """Planned time (m,), s, and its first three derivatives, at times t (m,) of the other motion, s."""
        from scipy.interpolate import BSpline

        inner = np.linspace(0.0, 1.0, len(self.shape) - 2)
        rate = BSpline(np.concatenate([np.zeros(3), inner, np.ones(3)]), self.shape, 3)
        whole = rate.antiderivative()
        size, u = self.length / float(whole(1.0)), np.clip(t / self.duration, 0.0, 1.0)
        rows = [whole(u), *(rate(u, order) for order in range(3))]
        return [size / self.duration**order * row for order, row in enumerate(rows)]


@dataclass(frozen=True, slots=True)
class RetimedMotion:
    """What joints do in another time.

    Attributes:
        motion: in its own, at rest before and after.
        law: planned time over time.
    """

    motion: JointMotion
    law: TimeLaw

    def __call__(self, t: np.ndarray, order: int = 0, /) -> np.ndarray:
        """The derivative of this order, up to 3, at times t (m,), s; by the chain rule."""
        tau, *rates = self.law(t)
        first, second, third = (rate[:, None] for rate in rates)
        if order == 0:
            return self.motion(tau)
        if order == 1:
            return self.motion(tau, 1) * first
        if order == 2:
            return self.motion(tau, 2) * first**2 + self.motion(tau, 1) * second
        return self.motion(tau, 3) * first**3 + 3.0 * self.motion(tau, 2) * first * second + self.motion(tau, 1) * third


def retimed(trajectory: Trajectory, scene: Scene, law: TimeLaw) -> Trajectory:
    """The record of a motion in another time, at its own rate; without its liquids.

    Args:
        trajectory: the planned one.
        scene: with the robot and its tray.
        law: planned time over time.
    """
    count = int(np.ceil(law.duration * trajectory.rate - 1e-6)) + 1
    t = np.arange(count) / trajectory.rate
    splined = QUINTIC_SPLINE.motion(JointSamples(trajectory.t, np.column_stack([trajectory.s, trajectory.tilt])))
    joints, others = (
        [HeldMotion(RetimedMotion(motion, law), 0.0, law.duration)(t, order) for order in range(3)]
        for motion in (trajectory.motion, splined)
    )
    still = np.zeros_like(joints[0])
    tray = kinematics(scene.robot).motions(joints[0], still, still, tool=scene.tray.tool)
    last = tray.rotation[:, 2]
    theta_x, theta_y = np.arctan2(last[:, 1], last[:, 2]), np.arcsin(np.clip(-last[:, 0], -1.0, 1.0))
    return replace(
        trajectory,
        t=t,
        s=others[0][:, 0],
        s_rate=others[1][:, 0],
        s_acceleration=others[2][:, 0],
        tilt=others[0][:, 1:],
        tilt_rate=others[1][:, 1:],
        tilt_acceleration=others[2][:, 1:],
        joint_position=joints[0],
        joint_speed=joints[1],
        joint_acceleration=joints[2],
        tray_position=tray.position,
        tray_quaternion=tray_quaternions(yaw_of(tray.rotation), theta_y, theta_x),
        slosh={},
    )
