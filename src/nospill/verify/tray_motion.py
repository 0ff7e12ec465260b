"""What the tray does when the joints follow the exported file: forward kinematics on the grid of the simulation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.errors import PlanFolderError
from nospill.motion.control import commanded, followed, settling_after
from nospill.motion.interpolation import QUINTIC_SPLINE, Interpolation, JointMotion, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class PlayedJoints:
    """A joint motion as its receiver plays it, at rest before `start` and after `end` (s).

    Attributes:
        motion: times (m,) and order of derivative -> (m, n) rad, rad/s, rad/s^2.
        source: the file it comes from, for reports.
    """

    motion: JointMotion
    start: float
    end: float
    source: str


def replay_joints(samples: JointSamples, scene: Scene, *, interpolation: Interpolation, source: str) -> PlayedJoints:
    """What a receiver makes of joint samples.

    Raises:
        PlanFolderError: the samples are not a motion of the scene's robot.
    """
    count, wanted = samples.position.shape[1], len(scene.robot.joints)
    if count != wanted:
        raise PlanFolderError(f"{source}: {count} joints, the robot of the scenario has {wanted}")
    if len(samples.t) < 2 or not np.all(np.isfinite(samples.position)) or not np.all(np.diff(samples.t) > 0.0):
        raise PlanFolderError(f"{source}: at least two samples, finite, in the order of time, are needed")
    motion, start, end = interpolation.motion(samples), float(samples.t[0]), float(samples.t[-1])
    if scene.controller is None:
        return PlayedJoints(motion, start, end, source)
    done = followed(motion, scene.controller, start, end)
    return PlayedJoints(done, start, end + settling_after(scene.controller), source)


def planned_joints(trajectory: Trajectory, scene: Scene, *, source: str) -> PlayedJoints:
    """The joint positions of a trajectory under position control: the quintic spline through them.

    Raises:
        PlanFolderError: they are not a motion of the scene's robot.
    """
    samples = commanded(trajectory, scene.controller)
    return replay_joints(samples, scene, interpolation=QUINTIC_SPLINE, source=source)


@dataclass(frozen=True, slots=True)
class TrayMotion:
    """Motion of the tray frame at m instants, in the tray's own axes except for the pose.

    Attributes:
        t: (m,) s, evenly spaced, on the clock of the joints.
        angular_velocity: (m, 3) rad/s.
        angular_acceleration: (m, 3) rad/s^2.
        specific_force: (m, 3) R^T (acceleration of the origin + g e_z), m/s^2.
        position: (m, 3) origin in the base frame, m.
        rotation: (m, 3, 3) tray to base.
    """

    t: np.ndarray
    angular_velocity: np.ndarray
    angular_acceleration: np.ndarray
    specific_force: np.ndarray
    position: np.ndarray
    rotation: np.ndarray


def tray_motion(joints: PlayedJoints, scene: Scene, *, step: float, before: float, after: float) -> TrayMotion:
    """Recompute the tray's motion from the joints.

    Args:
        joints: their motion.
        scene: its robot, tray and gravity.
        step: of the grid, s.
        before: rest put in front of the motion, s.
        after: rest put behind it, s.
    """
    count = round((joints.end - joints.start + before + after) / step) + 1
    t = joints.start - before + step * np.arange(count)
    motion = kinematics(scene.robot).motions(
        *(joints.motion(t, order) for order in range(3)),
        tool=scene.tray.tool,
    )
    lifted = motion.acceleration + np.array([0.0, 0.0, scene.gravity])
    turned = [
        np.einsum("mji,mj->mi", motion.rotation, vectors)
        for vectors in (motion.angular_velocity, motion.angular_acceleration, lifted)
    ]
    return TrayMotion(t, *turned, position=motion.position, rotation=motion.rotation)
