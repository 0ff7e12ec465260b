"""Joint torques under the worst load that the tolerances of the objects allow.

Torque is linear in the ten numbers of a load (mass, first moment, inertia), and the load is a sum over objects that are
off independently of each other. So at every joint and instant the largest torque is that of the stated load plus, for
each object, the largest of what its own extremes add: as many evaluations as there are numbers, for any number of
objects. Extremes of an object are the ends of its mass and fill and the corners of its place in every combination. In
mass and in all of the load but the inertia of the place, m delta^2 of a shift delta, this is exact.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from nospill.certification.replay import Replay
from nospill.certification.verdict import Trace
from nospill.laws.constraints.joint_torque import JointTorque
from nospill.laws.scene_parameters import flange_load, object_load
from nospill.robots.kinematics.dynamics import NO_LOAD, Load, dynamics, torque_joints
from nospill.scene.cargo import Cargo
from nospill.scene.perturbation import Perturbation, perturbed, without_swing
from nospill.scene.scene import Scene

WORST_LOAD = "the worst masses and places"
"""What these rows are called."""

_SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def worst_load_traces(scene: Scene, played: Replay) -> tuple[Trace, ...]:
    """Torque of every joint under the load that is worst for it, instant by instant; none where torque is not limited.

    Args:
        scene: with tolerances.
        played: its replay.
    """
    subjects = JointTorque().subjects(scene)
    if not subjects:
        return ()
    motion = (played.joint_position, played.joint_speed, played.joint_acceleration)
    arm = dynamics(scene.robot)
    bare = arm.torques(*motion, NO_LOAD, gravity=scene.gravity)
    per_number = np.stack([arm.torques(*motion, unit, gravity=scene.gravity) - bare for unit in _unit_loads()], axis=-1)
    highest = bare + per_number @ _numbers(flange_load(scene, ()))
    lowest = highest.copy()
    for cargo in (item for item in scene.cargo if not item.carrier):
        torques = per_number @ np.array([_numbers(object_load(item, scene.tray)) for item in extremes(cargo, scene)]).T
        highest += np.max(torques, axis=-1)
        lowest += np.min(torques, axis=-1)
    limited, limit = list(torque_joints(scene.robot)), scene.robot.max_torque
    assert limit is not None  # it has subjects
    values = np.where(highest >= -lowest, highest, lowest)[:, limited]
    return tuple(
        Trace(
            JointTorque.name,
            name,
            JointTorque.unit,
            played.t,
            value,
            np.copysign(bound, value),
            bound - abs(value),
            WORST_LOAD,
        )
        for name, value, bound in zip(subjects, values.T, limit[limited], strict=True)
    )


def extremes(cargo: Cargo, scene: Scene) -> list[Cargo]:
    """The object with every combination of the ends of its mass and fill and the corners of its place."""
    tolerance = cargo.tolerance
    if tolerance is None:
        return [cargo]
    signs = (-1.0, 1.0)
    rise = tolerance.liquid_height if cargo.oscillators else 0.0
    masses = [sign * tolerance.mass * cargo.empty.mass for sign in signs] if tolerance.mass else [0.0]
    levels = [sign * rise for sign in signs] if rise else [0.0]
    side = tolerance.position
    places = [(side * x, side * y) for x, y in product(signs, signs)] if side else [(0.0, 0.0)]
    return [
        perturbed(
            without_swing(cargo),
            Perturbation(mass=mass, liquid_height=level, position=place),
            fidelity=scene.fidelity,
        )
        for mass, level, place in product(masses, levels, places)
    ]


def _unit_loads() -> list[Load]:
    """Ten loads, each with one of the numbers at 1 in SI units."""
    nothing, flat = np.zeros(3), np.zeros((3, 3))
    loads = [Load(1.0, nothing, flat), *(Load(0.0, axis, flat) for axis in np.eye(3))]
    for row, column in _SYMMETRIC:
        inertia = np.zeros((3, 3))
        inertia[row, column] = inertia[column, row] = 1.0
        loads.append(Load(0.0, nothing, inertia))
    return loads


def _numbers(load: Load) -> np.ndarray:
    """The ten numbers of a load in the order of `_unit_loads`."""
    inertia = np.asarray(load.inertia)
    return np.array([load.mass, *np.asarray(load.first_moment), *(inertia[place] for place in _SYMMETRIC)], dtype=float)
