"""Replay of exported joint samples on a dense grid: the motion of tray and liquids between the samples.

Only the joint samples, the scene's numbers and the laws are read; nothing of the optimiser. A position controller sees
joint positions, so speeds and accelerations are the derivatives of the quintic spline through the position samples,
with the arm at rest before and after; a receiver that moves otherwise between its samples brings its own motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.compiled import codegen
from nospill.core.frames import SX, FrameMotion, body_motion
from nospill.core.hermite import cubic_hermite
from nospill.laws.kinds import numbers_of_object, object_kind, symbolic_object
from nospill.laws.parameters import SceneNumbers, Structure, flatten
from nospill.laws.sample import coordinate_count, object_motion
from nospill.laws.scene_parameters import initial_coordinates, numbers_of, structure_of
from nospill.laws.slosh.integrate import SHARED, STEPS, Integral, integrate, refined, runge_kutta_step, step_sequence
from nospill.laws.slosh.motion import modal_accelerations
from nospill.motion.interpolation import JointMotion, planned_motion
from nospill.motion.trajectory import Trajectory
from nospill.robots.kinematics.forward import ToolMotions, kinematics
from nospill.scene.scene import Scene

MINIMUM_RATE = 2000.0
"""Hz; the grid on which a trajectory is judged is at least this fine, unless another rate is given."""


@dataclass(frozen=True, slots=True)
class Replay:
    """Dense reconstruction of an exported trajectory.

    Attributes:
        t: (m,) s.
        rate: of this grid, Hz.
        joint_position: (m, n), rad.
        joint_speed: (m, n), rad/s.
        joint_acceleration: (m, n), rad/s^2.
        tray: pose and motion of the tray frame in base axes.
        body: (9, m) angular velocity, angular acceleration, specific force in tray axes.
        slosh_displacement: (m, k) modal coordinates, re-integrated, m.
        slosh_velocity: (m, k) their rates, m/s.
        slosh_error: estimated integration error of the displacements, m.
    """

    t: np.ndarray
    rate: float
    joint_position: np.ndarray
    joint_speed: np.ndarray
    joint_acceleration: np.ndarray
    tray: ToolMotions
    body: np.ndarray
    slosh_displacement: np.ndarray
    slosh_velocity: np.ndarray
    slosh_error: float


def replay(
    trajectory: Trajectory, scene: Scene, *, motion: JointMotion | None = None, rate: float = MINIMUM_RATE
) -> Replay:
    """Play an exported trajectory again.

    Args:
        trajectory: its times set the grid.
        scene: the scene it belongs to.
        motion: what the joints do; the quintic spline through the trajectory's positions when left out.
        rate: Hz, the grid is at least this fine; a higher one gives a second opinion between the usual instants.

    Raises:
        ModelError: the slosh integration does not converge (the liquid would leave its cup).
    """
    structure = structure_of(scene)
    # The slosh integration compares two grids, so the coarser one starts at half the rate that is wanted.
    per_sample = int(np.ceil(rate / trajectory.rate / (2 if coordinate_count(structure) else 1) - 1e-9))
    spline = motion or planned_motion(trajectory)
    count = coordinate_count(structure)
    grid, joints, tray, body, finest = np.empty(0), [], None, np.empty((9, 0)), 0

    def play(refinement: int) -> np.ndarray:
        nonlocal grid, joints, tray, body, finest
        if refinement > finest:
            # Two intervals of the motion grid make one Runge-Kutta step, whose middle needs the motion too. The first
            # grid is made as fine as the second needs it, since two are compared at least.
            finest = max(refinement, 2 if count else 1)
            grid = _grid(trajectory, 2 * per_sample * finest)
            joints = [spline(grid, order) for order in range(3)]
            tray, body = tray_from_joints(scene, joints)
        every = finest // refinement
        if not count:
            return grid[::2, None][:, :0]
        return _integrate(scene, body[:, ::every], float(grid[2 * every] - grid[0]))

    slosh = refined(play, displacements=count) if count else Integral(play(1), refinement=1, error=0.0)
    assert tray is not None  # play was called
    every = slice(None, None, 2)
    kept = grid[every]
    return Replay(
        t=kept,
        rate=1.0 / float(kept[1] - kept[0]),
        joint_position=joints[0][every],
        joint_speed=joints[1][every],
        joint_acceleration=joints[2][every],
        tray=ToolMotions(
            position=tray.position[every],
            rotation=tray.rotation[every],
            velocity=tray.velocity[every],
            acceleration=tray.acceleration[every],
            angular_velocity=tray.angular_velocity[every],
            angular_acceleration=tray.angular_acceleration[every],
        ),
        body=body[:, ::2],
        slosh_displacement=slosh.states[:, :count],
        slosh_velocity=slosh.states[:, count:],
        slosh_error=slosh.error,
    )


def states_at(played: Replay, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slosh displacements and velocities (k, m) at times (m,) between grid points, by the cubics through both ends."""
    left = np.clip(np.searchsorted(played.t, t, side="right") - 1, 0, len(played.t) - 2)
    width = (played.t[left + 1] - played.t[left])[:, None]
    u = (t - played.t[left])[:, None] / width
    q, qd = (np.stack([of[left], of[left + 1]]) for of in (played.slosh_displacement, played.slosh_velocity))
    return cubic_hermite(u, width, q, qd).T, ((1.0 - u) * qd[0] + u * qd[1]).T


def between(played: Replay, scene: Scene, motion: JointMotion, t: np.ndarray) -> Replay:
    """A replay at further times (m,), s, between its instants, which need not be even; `motion` is of its joints."""
    joints = [motion(t, order) for order in range(3)]
    tray, body = tray_from_joints(scene, joints)
    q, qd = states_at(played, t)
    return Replay(
        t=t,
        rate=played.rate,
        joint_position=joints[0],
        joint_speed=joints[1],
        joint_acceleration=joints[2],
        tray=tray,
        body=body,
        slosh_displacement=q.T,
        slosh_velocity=qd.T,
        slosh_error=played.slosh_error,
    )


def tray_from_joints(scene: Scene, joints: list[np.ndarray]) -> tuple[ToolMotions, np.ndarray]:
    """Motion of the tray that the joints carry.

    Args:
        scene: with the robot, and the tray on its flange.
        joints: positions, speeds and accelerations of the joints, (m, n) each, rad, rad/s, rad/s^2.

    Returns:
        The motion in base axes; and (9, m) angular velocity, angular acceleration and specific force in tray axes.
    """
    motions = kinematics(scene.robot).motions(*joints, tool=scene.tray.tool)
    lifted = motions.acceleration + np.array([0.0, 0.0, scene.gravity])
    vectors = np.stack([vector.T for vector in (motions.angular_velocity, motions.angular_acceleration, lifted)])
    # numbers of one kind side by side: products of many small matrices take 2.5 times as long
    rotation = np.ascontiguousarray(motions.rotation.transpose(1, 2, 0))
    return motions, np.einsum("jim,kjm->kim", rotation, vectors).reshape(9, -1)


def _grid(trajectory: Trajectory, per_sample: int) -> np.ndarray:
    count = (len(trajectory.t) - 1) * per_sample + 1
    return np.linspace(trajectory.t[0], trajectory.t[-1], count)


def slosh_accelerations(structure: Structure, numbers: SceneNumbers, tray: FrameMotion, q: SX, qd: SX) -> SX:
    """Accelerations of all slosh coordinates (k, 1) from displacements and velocities, m/s^2."""
    deliverable = structure.fidelity == "deliverable"
    rates = [
        modal_accelerations(item, own, object_motion(own, tray), q[part], qd[part], damp_against_spin=deliverable)
        for item, own, part in zip(structure.objects, numbers.objects, structure.slosh_slices, strict=True)
    ]
    return ca.vertcat(*rates)


@lru_cache(maxsize=64)
def liquid_steps(kind: Structure) -> Any:
    """Steps of liquids of a kind, for `integrate`: the body rows are the inputs, `numbers_of_object` the parameters."""

    def build() -> tuple[codegen.Functions, None]:
        count, (vector, numbers) = coordinate_count(kind), symbolic_object(kind)

        def rate(state: SX, body: SX, parameters: SX) -> SX:
            q, qd = state[:count], state[count:]
            change = ca.vertcat(qd, slosh_accelerations(kind, numbers, body_motion(body), q, qd))
            return ca.substitute(change, vector, parameters)

        return {"step": runge_kutta_step(rate, states=2 * count, inputs=9, parameters=vector.numel())}, None

    step = codegen.functions("steps", kind, build, of_columns={"step": SHARED}, steps=STEPS)[0]["step"]
    return step if step.size2_in(1) == STEPS else step_sequence(step)


def _integrate(scene: Scene, body: np.ndarray, length: float) -> np.ndarray:
    """All liquids along a motion sampled at half steps: (m, 2 k), displacements, then velocities."""
    structure, numbers = structure_of(scene), numbers_of(scene)
    initial, half, count = initial_coordinates(scene), coordinate_count(structure), (body.shape[1] - 1) // 2
    alike: dict[Structure, list[int]] = {}
    for index, item in enumerate(structure.objects):
        if item.coordinates:
            alike.setdefault(object_kind(structure, item), []).append(index)
    states = np.empty((count + 1, 2 * half))
    for kind, indices in alike.items():
        own = [np.r_[structure.slosh_slices[index]] for index in indices]
        places = np.array([np.concatenate([part, half + part]) for part in own])
        states[:, places] = integrate(
            liquid_steps(kind),
            np.array([initial[:, part].ravel() for part in own]),
            inputs=body,
            lengths=np.full(count, length),
            parameters=np.array([flatten(numbers_of_object(numbers, index)) for index in indices]),
        )
    return states
