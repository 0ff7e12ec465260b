"""Replay of exported joint samples on a dense grid: the motion of tray and liquids between the samples.

Only the joint samples, the scene's numbers and the laws are read; nothing of the optimiser. A position controller sees
joint positions, so speeds and accelerations are the derivatives of the quintic spline through the position samples,
with the arm at rest before and after; a receiver that moves otherwise between its samples brings its own motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import casadi as ca
import numpy as np

from nospill.compiled import codegen
from nospill.compiled.kept import kept
from nospill.core.frames import SX, FrameMotion, body_motion
from nospill.core.hermite import cubic_hermite, cubic_hermite_slope
from nospill.laws.kinds import object_kind, symbolic_object
from nospill.laws.parameters import SceneNumbers
from nospill.laws.sample import coordinate_count, object_motion
from nospill.laws.scene_parameters import flat_object_numbers, initial_coordinates, structure_of
from nospill.laws.slosh.integrate import SHARED, STEPS, pieces, refined, runge_kutta_step, step_sequence
from nospill.laws.slosh.motion import modal_accelerations
from nospill.laws.structure import Structure
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.robots.kinematics.forward import ToolMotions, kinematics
from nospill.scene.scene import Scene

MINIMUM_RATE = 2000.0
"""Hz; the grid on which a trajectory is judged is at least this fine, unless another rate is given."""
_STEPS_OF_A_PERIOD = 100
"""Of the fastest mode, with which two grids agree to 1e-7 m: with 139 they differ by 2.5e-9 and 1.5e-8 m (two examples,
one mode), with 21 to 24 by 2.3e-7 to 3.7e-7 m (three examples, 20 modes); with 2 the integration runs away."""

_AT_ONCE = 32  # instants between which middles are found, in the processor's cache


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
    spline, count = motion or trajectory.motion, coordinate_count(structure_of(scene))
    per_sample = int(np.ceil(_coarsest_rate(scene, rate) / trajectory.rate - 1e-9))
    grid, joints, tray, body, finest = np.empty(0), [], None, np.empty((9, 0)), 0

    def sampled(points: int) -> None:
        nonlocal grid, joints, tray, body
        grid = _grid(trajectory, points)
        joints = [spline(grid, order) for order in range(3)]
        tray, body = tray_from_joints(scene, joints)

    def play(refinement: int) -> np.ndarray:
        nonlocal finest
        if refinement > finest:
            # The first grid is made as fine as the second needs it, since two are compared at least.
            finest = max(refinement, 2)
            sampled(2 * per_sample * finest)
        stride = finest // refinement
        return _integrate(scene, [body[:, ::stride]], float(grid[2 * stride] - grid[0]))[0]

    if count:
        slosh = refined(play, displacements=count)
        every = 2 if per_sample * finest * trajectory.rate >= rate * (1 - 1e-9) else 1
        states = slosh.states if every == 2 else _with_middles(slosh.states, float(grid[2] - grid[0]))
        error = slosh.error
    else:
        sampled(per_sample)
        every, states, error = 1, np.empty((len(grid), 0)), 0.0
    assert tray is not None  # sampled was called
    kept = slice(None, None, every)
    return Replay(
        t=grid[kept],
        rate=1.0 / float(grid[every] - grid[0]),
        joint_position=joints[0][kept],
        joint_speed=joints[1][kept],
        joint_acceleration=joints[2][kept],
        tray=ToolMotions(
            position=tray.position[kept],
            rotation=tray.rotation[kept],
            velocity=tray.velocity[kept],
            acceleration=tray.acceleration[kept],
            angular_velocity=tray.angular_velocity[kept],
            angular_acceleration=tray.angular_acceleration[kept],
        ),
        body=body[:, kept],
        slosh_displacement=states[:, :count],
        slosh_velocity=states[:, count:],
        slosh_error=error,
    )


def coarse_replays(
    scene: Scene, motions: Sequence[JointMotion], start: float, stop: float, *, rate: float, halvings: int = 0
) -> tuple[Replay, ...]:
    """Replays of some motions on one grid of this rate, Hz, the liquids integrated once: for differences between them.

    They may go on for a few periods. The liquids take steps of 2^halvings periods, with cubics between. With 1 kHz and
    steps of one uses agree with those of `replay` within 0.2 % of a limit; what the integration is off by is not known.
    """
    longer = 2**halvings
    count = longer * max(1, int(np.ceil((stop - start) * rate / longer - 1e-6)))
    grid, step = start + np.arange(2 * count + 1) / (2.0 * rate), 1.0 / rate
    joints = [np.concatenate([motion(grid, order) for motion in motions]) for order in range(3)]
    tray, body = tray_from_joints(scene, joints)
    coordinates, found = coordinate_count(structure_of(scene)), []
    integrated = [np.empty((count + 1, 0))] * len(motions)
    if coordinates:
        bodies = np.split(body, len(motions), axis=1)
        integrated = _integrate(scene, [own[:, ::longer] for own in bodies], longer * step)
    for index, states in enumerate(integrated):
        for halving in range(halvings if coordinates else 0):
            states = _with_middles(states, longer * step / 2**halving)
        every = slice(index * len(grid), (index + 1) * len(grid), 2)
        found.append(
            Replay(
                t=grid[::2],
                rate=rate,
                joint_position=joints[0][every],
                joint_speed=joints[1][every],
                joint_acceleration=joints[2][every],
                tray=ToolMotions(*(getattr(tray, item.name)[every] for item in fields(tray))),
                body=body[:, every],
                slosh_displacement=states[:, :coordinates],
                slosh_velocity=states[:, coordinates:],
                slosh_error=float("nan"),
            )
        )
    return tuple(found)


def _coarsest_rate(scene: Scene, rate: float) -> float:
    """Of the steps on the coarser of the two grids that are compared first, Hz.

    A quarter of that of the replay, whose liquids are then interpolated in the middles of the finer grid's steps; half
    of it where that leaves the fastest mode too few steps for two grids to agree.
    """
    fastest = max((mode.frequency for cargo in scene.cargo for mode in cargo.oscillators), default=0.0)
    if not fastest:
        return rate
    return rate / 4 if rate / 4 >= _STEPS_OF_A_PERIOD * fastest / (2 * np.pi) else rate / 2


def _with_middles(states: np.ndarray, step: float) -> np.ndarray:
    """States (m + 1, 2 k) at the ends of steps of this length, s, and in their middles, by cubics: (2 m + 1, 2 k).

    A displacement is off by at most step^4/384 times its largest fourth derivative [de Boor, ch. IV].
    """
    dense, half = np.empty((2 * len(states) - 1, states.shape[1])), states.shape[1] // 2
    dense[::2] = states
    for first in range(0, len(states) - 1, _AT_ONCE):
        some = states[first : first + _AT_ONCE + 1]
        ends = [np.stack([part[:-1], part[1:]]) for part in (some[:, :half], some[:, half:])]
        middles = dense[2 * first + 1 : 2 * (first + len(some) - 1) : 2]
        middles[:, :half], middles[:, half:] = cubic_hermite(0.5, step, *ends), cubic_hermite_slope(0.5, step, *ends)
    return dense


def states_at(played: Replay, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slosh displacements and velocities (k, m) at times (m,) between grid points, by the cubics through both ends."""
    left = np.clip(np.searchsorted(played.t, t, side="right") - 1, 0, len(played.t) - 2)
    width = (played.t[left + 1] - played.t[left])[:, None]
    u = (t - played.t[left])[:, None] / width
    q, qd = (np.stack([of[left], of[left + 1]]) for of in (played.slosh_displacement, played.slosh_velocity))
    return cubic_hermite(u, width, q, qd).T, cubic_hermite_slope(u, width, q, qd).T


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


@kept(maxsize=64)
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


def _integrate(scene: Scene, bodies: Sequence[np.ndarray], length: float) -> list[np.ndarray]:
    """All liquids along some motions, each sampled at half steps: (m, 2 k), displacements, then velocities."""
    structure, numbers = structure_of(scene), flat_object_numbers(scene)
    initial, half = initial_coordinates(scene), coordinate_count(structure)
    alike: dict[Structure, list[int]] = {}
    slices = structure.slosh_slices
    for index, item in enumerate(structure.objects):
        if item.coordinates:
            alike.setdefault(object_kind(structure, item), []).append(index)
    found = [np.empty(((body.shape[1] - 1) // 2 + 1, 2 * half)) for body in bodies]
    for kind, indices in alike.items():
        own = [slices[index] for index in indices]
        steps, starts = liquid_steps(kind), np.array([initial[:, part].ravel() for part in own])
        parameters = np.array([numbers[index] for index in indices])
        count = starts.shape[1] // 2
        for states, body in zip(found, bodies, strict=True):
            states[0, :half], states[0, half:] = initial
            q, qd, lengths = states[:, :half], states[:, half:], np.full(len(states) - 1, length)
            for reached, some, part in pieces(steps, starts, inputs=body, lengths=lengths, parameters=parameters):
                for number, columns in enumerate(own[some]):  # by slices: an index of all copies number by number
                    q[reached, columns], qd[reached, columns] = part[:, number, :count], part[:, number, count:]
    return found
