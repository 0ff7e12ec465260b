"""How soon a motion could stop at best: what joints, friction and one liquid alone set, whatever way the arm takes.

Each bound keeps one part of the problem and drops the rest, so that no motion is sooner than the largest of them:

path, tilt: progress and tilt come to rest with the jerks that they may have, see `chains`.
joints, tray: a joint falls from its speed to rest at its largest acceleration, the tray likewise where it has one.
friction: the momentum of an object and its liquid has to go, and the tray takes it by contact alone. With the force
    never farther than psi from the vertical, |F_h| <= tan(psi) F_z, integrated from now to rest:
    |P_h| - |P_h at rest| <= tan(psi) (m g T - P_z). Psi is the angle of friction, plus what the tray may tilt.
liquid: see `straight`; on level trays and level paths, for bodies of revolution.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nospill.certification.replay import tray_from_joints
from nospill.laws.constraints.tilt import TILT_ANGLES
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.scene_parameters import numbers_of
from nospill.plans.state import MotionState
from nospill.plans.stops import NO_BOUND, Bound
from nospill.robots.kinematics.forward import ToolMotions
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.scene.swing import Swing
from nospill.stopping.chains import soonest_rest
from nospill.stopping.straight import Straight, soonest

_LEVEL = 1e-3
"""Slope of a path up to which it counts as level."""


@dataclass(frozen=True, slots=True)
class _Carried:
    """One object as it moves at an instant, base axes: velocity of its bottom centre, how it turns, its axes, swing."""

    cargo: Cargo
    numbers: ObjectNumbers
    velocity: np.ndarray
    turning: np.ndarray
    axes: np.ndarray
    displacement: np.ndarray
    rate: np.ndarray


def bound_of(scene: Scene, state: MotionState) -> Bound:
    """The largest of the bounds from a state.

    Args:
        scene: of the stop, with the limits on what swings on after it (`stopping_scene`).
        state: from which it begins.
    """
    motions = tray_from_joints(scene, [column[None] for column in state.arm.joints])[0]
    objects = _objects(scene, state, motions)
    bounds = [*_of_arm(scene, state, motions), *(_of_friction(scene, item) for item in objects if _stands(item.cargo))]
    # by linear programs, each asked only whether it says more than those before
    largest = _with_chains(scene, state, max(bounds, key=_duration, default=NO_BOUND))
    if _level(scene, state):
        for item in objects:
            if item.cargo.filling is not None and not item.cargo.filling.lid and _round(item.cargo):
                found = _of_slosh(scene, item, state, largest.duration)
                largest = max(largest, Bound(found, f"friction and liquid of {item.cargo.name}"), key=_duration)
    return largest


def _duration(bound: Bound) -> float:
    return bound.duration


def _objects(scene: Scene, state: MotionState, motions: ToolMotions) -> list[_Carried]:
    """Every object that friction holds on the tray, or that is fixed there, with its liquid; no racks of liquids."""
    found = []
    for cargo, numbers in zip(scene.cargo, numbers_of(scene).objects, strict=True):
        if cargo.carrier or cargo.contents is not None:
            continue
        tray, turning = motions.rotation[0], motions.angular_velocity[0]
        cosine, sine = math.cos(cargo.yaw), math.sin(cargo.yaw)
        axes = tray @ np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        velocity = motions.velocity[0] + np.cross(turning, tray @ numbers.position)
        found.append(_Carried(cargo, numbers, velocity, turning, axes, *_swing(cargo, state.swings.get(cargo.name))))
    return found


def _stands(cargo: Cargo) -> bool:
    return not cargo.fixed


def _round(cargo: Cargo) -> bool:
    """Whether its liquid swings alike in all directions."""
    return all(mode.directions == ("x", "y") for mode in cargo.oscillators)


def _swing(cargo: Cargo, swing: Swing | None) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity of its modes (k, 2), container axes; zero where none is known."""
    place, rate = np.zeros((2, len(cargo.oscillators), 2))
    if swing is not None:
        for table, values in ((place, swing.displacement), (rate, swing.velocity)):
            known = np.array(values).reshape(-1, 2)[: len(table)]
            table[: len(known)] = known
    return place, rate


def _level(scene: Scene, state: MotionState) -> bool:
    """Whether the tray stays level, and at one height on what is left of its path."""
    slopes = scene.path.derivative(np.linspace(state.arm.s, 1.0, 101), 1)
    flat = np.all(np.abs(slopes[:, 2]) <= _LEVEL * np.linalg.norm(slopes[:, :3], axis=1))
    return scene.motion.is_given and scene.path.joint_curve is None and bool(flat)


def _with_chains(scene: Scene, state: MotionState, largest: Bound) -> Bound:
    """The largest of a bound and those of progress, wherever it ends, and of the tilt angles, which end at zero."""
    rules, along, tilts = scene.motion, state.arm.along[0], state.arm.tilts
    tilting = zip(TILT_ANGLES, tilts, strict=True) if rules.tilt_free else ()
    chains = [(f"jerk of {name}", tilt, rules.tilt_jerk_limit, rules.max_tilt) for name, tilt in tilting]
    for name, chain, jerk, most in (*chains, ("jerk along the path", along[1:], rules.path_jerk_limit, math.inf)):
        found = soonest_rest(chain, jerk, most, above=largest.duration)
        largest = max(largest, Bound(found, name), key=_duration)
    return largest


def _of_arm(scene: Scene, state: MotionState, motions: ToolMotions) -> list[Bound]:
    bounds = []
    if scene.robot.max_acceleration is not None:
        times = np.abs(state.arm.joints[1]) / scene.robot.max_acceleration
        slowest = int(np.argmax(times))
        bounds.append(Bound(float(times[slowest]), scene.robot.joints[slowest]))
    if scene.motion.max_acceleration is not None:
        speed = float(np.linalg.norm(motions.velocity[0]))
        bounds.append(Bound(speed / scene.motion.max_acceleration, "acceleration of the tray"))
    return bounds


def _of_friction(scene: Scene, item: _Carried) -> Bound:
    """The momentum of an object and its liquid over what friction can take of it."""
    numbers, name = item.numbers, f"friction of {item.cargo.name}"
    if scene.path.joint_curve is not None:  # the tray leans as the joints have it
        return Bound(0.0, name)
    lean = math.acos(math.cos(scene.motion.max_tilt) ** 2) if scene.motion.tilt_free else 0.0
    steepest = math.atan(float(numbers.planned_friction)) + lean
    if steepest >= math.pi / 2:
        return Bound(0.0, name)
    momentum = float(numbers.mass) * item.velocity + np.cross(
        item.turning, item.axes @ np.asarray(numbers.first_moment)
    )
    left = 0.0
    if scene.fidelity == "full":
        for mode, place, rate in zip(numbers.oscillators, item.displacement, item.rate, strict=True):
            arm = item.axes @ np.array([*place, float(mode.height)])
            own = item.velocity + np.cross(item.turning, arm) + item.axes @ np.array([*rate, 0.0])
            momentum = momentum + float(mode.mass) * own
            limit = scene.motion.residual_fraction * float(numbers.max_slosh_height)
            if mode.surface_gain:
                most = float(mode.mass) * float(mode.frequency) * limit / abs(float(mode.surface_gain))
                left = max(left, most)
    weight = float(numbers.weight)
    time = (math.hypot(*momentum[:2]) - left) / (math.tan(steepest) * weight) + momentum[2] / weight
    return Bound(max(0.0, float(time)), name)


def _of_slosh(scene: Scene, item: _Carried, state: MotionState, above: float) -> float:
    """The bound of one cup on a straight way of its own, s; 0 where its liquid alone says no more than `above`."""
    numbers, speed = item.numbers, float(np.hypot(*item.velocity[:2]))
    if speed < 1e-6:
        return 0.0
    along = np.array([*(item.velocity[:2] / speed), 0.0]) @ item.axes
    # velocities against axes that do not turn: those of the container turn with it
    turned = item.rate + item.turning[2] * np.column_stack([-item.displacement[:, 1], item.displacement[:, 0]])
    full = scene.fidelity == "full"
    case = Straight(
        speed=speed,
        most=float(numbers.planned_friction) * scene.gravity if _stands(item.cargo) else math.inf,
        frequency=np.array([float(mode.frequency) for mode in numbers.oscillators]),
        damping=np.array([float(mode.damping) for mode in numbers.oscillators]),
        gain=np.array([float(mode.surface_gain) for mode in numbers.oscillators]),
        part=np.array(
            [float(mode.mass) * full * scene.gravity / float(numbers.weight) for mode in numbers.oscillators]
        ),
        displacement=item.displacement @ along[:2],
        rate=turned @ along[:2],
        highest=float(numbers.max_slosh_height),
        residual=scene.motion.residual_fraction * float(numbers.max_slosh_height),
    )
    return soonest(case, state.rest.end_time, above=above)
