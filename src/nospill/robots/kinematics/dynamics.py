"""Inverse dynamics: the joint torques that move an arm and what its flange carries, as an expression and on samples.

Recursive Newton-Euler equations in the frames of `bodies` (Luh, Walker and Paul, "On-line computational scheme for
mechanical manipulators", ASME J. Dyn. Syst. Meas. Control 102, 1980), with each body's first moment and its inertia
about the frame's own origin, so that no centre of mass is ever visited, and with what a joint's turning cannot tell
from the body before it moved to that body. Gravity enters as an acceleration of the base upwards. Friction, motor
inertia and damping entries of the URDF are not in it.

Written out here, since the general floating-base algorithms of adam-robotics (mass matrix times acceleration plus bias
force) make an expression many times as large, and an optimal control problem with exact Hessians pays for every node.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from nospill.compiled import codegen
from nospill.compiled.kept import kept
from nospill.core.arrays import parallel_axis
from nospill.core.batches import evaluate
from nospill.errors import ScenarioError
from nospill.robots.description.urdf_tree import read_tree
from nospill.robots.kinematics.bodies import Body, chain_bodies
from nospill.robots.kinematics.chain import about_z, body_angles, body_rates, of_joints
from nospill.robots.kinematics.forward import ArmChain
from nospill.robots.kinematics.inertias import inertia_faults
from nospill.robots.robot import Robot

STANDARD_GRAVITY = 9.80665
"""m/s^2, along the world's -z."""

Numbers = np.ndarray | ca.SX

_NAME = "joint_torque"


@dataclass(frozen=True, slots=True)
class Load:
    """A rigid load at the flange, in flange axes; numbers, or SX for a law.

    Attributes:
        mass: kg.
        first_moment: (3,) mass times centre of mass from the flange's origin, kg m.
        inertia: (3, 3) about the flange's origin, kg m^2, symmetric.
    """

    mass: float | ca.SX
    first_moment: Numbers
    inertia: Numbers

    def __add__(self, other: Load) -> Load:
        """Two loads carried together."""
        return Load(self.mass + other.mass, self.first_moment + other.first_moment, self.inertia + other.inertia)


def load_of(
    mass: float, centre: np.ndarray, inertia: np.ndarray | None = None, *, rotation: np.ndarray | None = None
) -> Load:
    """Return a body as a load.

    Args:
        mass: kg.
        centre: (3,) its centre of mass in the flange frame, m.
        inertia: (3, 3) about its centre in its own axes, kg m^2; a point when not given.
        rotation: (3, 3) its axes to flange axes; parallel when not given.
    """
    turn = np.eye(3) if rotation is None else rotation
    about_centre = np.zeros((3, 3)) if inertia is None else turn @ inertia @ turn.T
    return Load(mass, mass * centre, about_centre + mass * parallel_axis(centre))


NO_LOAD = Load(0.0, np.zeros(3), np.zeros((3, 3)))


def joint_torque(
    robot: Robot, q: ca.SX, qd: ca.SX, qdd: ca.SX, load: Load = NO_LOAD, *, gravity: float | ca.SX = STANDARD_GRAVITY
) -> ca.SX:
    """Return the joint torques (n,), N m, as an expression.

    Args:
        robot: an arm with real inertias.
        q: (n,) joint positions, rad.
        qd: (n,) joint speeds, rad/s.
        qdd: (n,) joint accelerations, rad/s^2.
        load: what the flange carries, numbers or SX.
        gravity: m/s^2.

    Raises:
        ScenarioError: the arm's masses and inertias are not known.
    """
    return dynamics(robot).torque(q, qd, qdd, load, gravity=gravity)


def joint_torques(
    robot: Robot,
    q: np.ndarray,
    qd: np.ndarray,
    qdd: np.ndarray,
    load: Load = NO_LOAD,
    *,
    gravity: float = STANDARD_GRAVITY,
) -> np.ndarray:
    """Return the joint torques (m, n), N m, at m samples.

    Args:
        robot: an arm with real inertias.
        q: (m, n) joint positions, rad.
        qd: (m, n) joint speeds, rad/s.
        qdd: (m, n) joint accelerations, rad/s^2.
        load: what the flange carries, numbers.
        gravity: m/s^2.

    Raises:
        ScenarioError: the arm's masses and inertias are not known.
    """
    return dynamics(robot).torques(q, qd, qdd, load, gravity=gravity)


class Dynamics:
    """Inverse dynamics of one chain. Get it from `dynamics(robot)`, which keeps one per chain.

    Attributes:
        n: number of moving joints.
        torque_function: (q, qd, qdd, load (13,), gravity) -> torques (n,); `load_column` makes the fourth.
    """

    def __init__(self, urdf: str, joints: tuple[str, ...], tip: str) -> None:
        """Lump the links and build the expression; arguments as for `Kinematics`.

        Raises:
            ScenarioError: the text is no URDF.
        """
        self.n = len(joints)
        self._key = urdf, joints, tip
        chain = chain_bodies(read_tree(urdf), joints, tip)
        self._chain = replace(chain, bodies=_regrouped(chain.bodies))
        q, qd, qdd = (ca.SX.sym(name, self.n) for name in ("q", "qd", "qdd"))
        load, gravity = ca.SX.sym("load", 13), ca.SX.sym("gravity")
        torque = self.torque(q, qd, qdd, _load_from(load), gravity=gravity)
        self.torque_function: Any = ca.Function(_NAME, [q, qd, qdd, load, gravity], [ca.densify(torque)], {"cse": True})

    @cached_property
    def sampled(self) -> Any:
        """`torque_function` as it is evaluated on samples, a few at once."""
        made, columns = {_NAME: self.torque_function}, {_NAME: codegen.LAST}
        return codegen.functions("torques", self._key, lambda: (made, None), of_columns=columns)[0][_NAME]

    def torque(self, q: ca.SX, qd: ca.SX, qdd: ca.SX, load: Load, *, gravity: float | ca.SX) -> ca.SX:
        """Return the joint torques as `joint_torque` does."""
        chain = self._chain
        q, qd, qdd = body_angles(chain, q), body_rates(chain, qd), body_rates(chain, qdd)
        last = len(chain.bodies) - 1
        spin, turn_up = ca.SX(3, 1), ca.SX(3, 1)
        push = ca.vertcat(0, 0, ca.SX(gravity))
        carried = self._at_last_joint(load)
        rotations, forces, moments = [], [], []
        for joint, body in enumerate(chain.bodies):
            rotation = _constant(body.rotation) @ about_z(q[joint])
            push = rotation.T @ (push + _swing(turn_up, spin, _constant(body.position)))
            spin, turn_up = rotation.T @ spin, rotation.T @ turn_up
            rate = ca.vertcat(0, 0, qd[joint])
            turn_up = turn_up + ca.vertcat(0, 0, qdd[joint]) + ca.cross(spin, rate)
            spin = spin + rate
            own = Load(body.mass, _constant(body.first_moment), _constant(body.inertia))
            force, moment = _wrench(own + carried if joint == last else own, spin, turn_up, push)
            rotations.append(rotation)
            forces.append(force)
            moments.append(moment)

        force, moment = forces[-1], moments[-1]
        torque = [moment[2]]
        for joint in reversed(range(last)):
            force = rotations[joint + 1] @ force
            lever = _constant(chain.bodies[joint + 1].position)
            moment = rotations[joint + 1] @ moment + ca.cross(lever, force) + moments[joint]
            force = force + forces[joint]
            torque.append(moment[2])
        return of_joints(chain, ca.horzcat(*reversed(torque))).T

    def _at_last_joint(self, load: Load) -> Load:
        """The load in the frame of the last joint."""
        turn, lever = _constant(self._chain.flange_rotation), _constant(self._chain.flange_position)
        moment = turn @ ca.SX(load.first_moment)
        inertia = turn @ ca.SX(load.inertia) @ turn.T
        cross = lever @ moment.T
        inertia = inertia + (2.0 * ca.trace(cross)) * ca.SX.eye(3) - cross - cross.T
        inertia = inertia + load.mass * _constant(parallel_axis(self._chain.flange_position))
        return Load(load.mass, moment + load.mass * lever, inertia)

    def torques(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, load: Load, *, gravity: float) -> np.ndarray:
        """Return the joint torques at samples as `joint_torques` does.

        Args:
            q: (m, n) joint positions, rad.
            qd: (m, n) joint speeds, rad/s.
            qdd: (m, n) joint accelerations, rad/s^2.
            load: numbers.
            gravity: m/s^2.
        """
        count = len(q)
        for array in (q, qd, qdd):
            if np.shape(array) != (count, self.n):
                raise ValueError(f"joint samples have shape {np.shape(array)}, expected ({count}, {self.n})")
        if count == 0:
            return np.zeros((0, self.n))
        columns = [np.asarray(array, dtype=float).T for array in (q, qd, qdd)]
        column = np.repeat(ca.DM(load_column(load)).full(), count, axis=1)
        torque = evaluate(self.sampled, [*columns, column], np.array([gravity]))
        return np.ascontiguousarray(torque.T)


def torque_expression(chain: ArmChain, q: ca.SX, qd: ca.SX, qdd: ca.SX, load: Load, *, gravity: float | ca.SX) -> ca.SX:
    """`joint_torque` for a chain whose inertias are known to be real, without asking again."""
    return _dynamics(chain.urdf, chain.joints, chain.tip).torque(q, qd, qdd, load, gravity=gravity)


def dynamics(robot: Robot) -> Dynamics:
    """Return the inverse dynamics of an arm; built once per chain.

    Raises:
        ScenarioError: the arm's masses and inertias are not known; the message says why.
    """
    if not robot.inertias_known:
        fault = inertia_faults(read_tree(robot.urdf), robot.joints).reason
        reason = f" ({fault})" if fault else ""
        raise ScenarioError(
            f"robot {robot.name!r}: masses and inertias are not known{reason}, so joint torques cannot be computed; "
            "give a URDF with real inertias or leave torque limits out"
        )
    return _dynamics(robot.urdf, robot.joints, robot.tip)


def torque_joints(robot: Robot) -> tuple[int, ...]:
    """Indices of the joints whose torque has a limit and can be computed."""
    if robot.max_torque is None or not robot.inertias_known:
        return ()
    return tuple(np.flatnonzero(np.isfinite(robot.max_torque)).tolist())


def load_column(load: Load) -> np.ndarray:
    """Return a load of numbers as the column (13,) of `torque_function`: mass, first moment, inertia row by row."""
    return np.concatenate(
        [[float(load.mass)], np.asarray(load.first_moment, dtype=float), np.asarray(load.inertia, dtype=float).ravel()]
    )


_dynamics = kept(maxsize=32)(Dynamics)


def _regrouped(bodies: tuple[Body, ...]) -> tuple[Body, ...]:
    """Bodies with fewer numbers that give the same joint torques (not the same forces in the bearings).

    The part of a body that is symmetric about its joint's axis (its mass and the first moment along the axis, and a
    transverse inertia) moves as if it belonged to the body before; so it is counted there, and what the first body
    passes on stands still. Source: Gautier and Khalil, "Direct calculation of minimum set of inertial parameters of
    serial robots", IEEE Trans. Robotics and Automation 6, 1990.
    """
    kept: list[Body] = []
    mass, moment, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    for body in reversed(bodies):
        mass, moment, inertia = mass + body.mass, moment + body.first_moment, inertia + body.inertia
        along = np.array([0.0, 0.0, moment[2]])
        across = np.diag([inertia[1, 1], inertia[1, 1], 0.0])
        kept.append(replace(body, mass=0.0, first_moment=moment - along, inertia=inertia - across))
        # the symmetric part in the frame before
        turn, lever = body.rotation, body.position
        moved = turn @ along
        inertia = turn @ across @ turn.T + mass * parallel_axis(lever) + _about_moment(lever, moved)
        moment = moved + mass * lever
    return tuple(kept[::-1])


def _about_moment(lever: np.ndarray, moment: np.ndarray) -> np.ndarray:
    """What a first moment (3,) adds to an inertia (3, 3) when its origin is shifted to `lever` (3,)."""
    return 2.0 * float(lever @ moment) * np.eye(3) - np.outer(lever, moment) - np.outer(moment, lever)


def _load_from(column: ca.SX) -> Load:
    return Load(column[0], column[1:4], ca.reshape(column[4:], 3, 3))  # symmetric: rows are columns


def _swing(turn_up: ca.SX, spin: ca.SX, lever: ca.SX) -> ca.SX:
    """Acceleration of a point at `lever` against the frame's origin."""
    return ca.cross(turn_up, lever) + ca.cross(spin, ca.cross(spin, lever))


def _wrench(body: Load, spin: ca.SX, turn_up: ca.SX, push: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Force and moment about the origin that move a body whose origin accelerates by `push` (gravity included)."""
    first_moment, inertia = ca.SX(body.first_moment), ca.SX(body.inertia)
    force = body.mass * push + _swing(turn_up, spin, first_moment)
    moment = inertia @ turn_up + ca.cross(spin, inertia @ spin) + ca.cross(first_moment, push)
    return force, moment


def _constant(values: np.ndarray) -> ca.SX:
    # sparse, so that zeros make no nodes
    return ca.sparsify(ca.SX(values))
