"""Height of the liquid in one container that is moved in a given way.

The sampled poses become a quintic spline, the spline the container's rates and apparent gravity, and these drive the
same laws that plan and certify: the modal masses (`nospill.laws.slosh.motion`) and the height at the wall
(`nospill.laws.slosh.height`). The damping is measured against the wall.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import casadi as ca
import numpy as np

from nospill.core.frames import SX, FrameMotion
from nospill.errors import ModelError, ScenarioError
from nospill.laws.parameters import ObjectNumbers, ObjectStructure, OscillatorNumbers, constants
from nospill.laws.slosh.height import crest, surface_vector
from nospill.laws.slosh.integrate import integrate, refined, runge_kutta_step
from nospill.laws.slosh.motion import OscillatorState, modal_acceleration
from nospill.scene.cargo import Cargo, Filling
from nospill.scene.containers.base import DiscFootprint
from nospill.scene.containers.modes import STANDARD_GRAVITY, Oscillator, SloshModes
from nospill.simulation.cup_file import cup_from_table, read_cup
from nospill.simulation.motion_file import Heights, Motion, checked_motion

HeightRule = Literal["one-mode", "corrected"]
"""Height at the wall: of the carried modes alone, or with the quasi-static part of all the others."""

KNOT_SPACING = 0.010
"""s; least distance of the spline's knots. Motion below 50 Hz passes, far above any mode that matters; rounding and
noise between the samples does not: derived twice at 500 Hz it would be 50 times larger."""

_DEGREE = 5
_LONGEST_STEP = 0.002
_LEAST_SAMPLES_PER_PERIOD = 5
_LARGEST_MODE_COUNT = 20
_LARGEST_FORCE = 200.0
"""m/s^2; twenty times gravity is a jump in the record or millimetres taken for metres, not a cup on its way."""


@dataclass(frozen=True, slots=True)
class SloshSimulation:
    """What the liquid does.

    Attributes:
        t: (m,) s, the times of the motion's samples.
        height: (m,) m, of the free surface above rest at the wall, where it is highest, along the container's axis.
        displacement, velocity: (m, k) of the modal masses along the container's axes, m and m/s.
        room: m, from the rest level to the rim.
        error: estimated integration error of the displacements, m.
    """

    t: np.ndarray
    height: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    room: float
    error: float

    @property
    def peak(self) -> float:
        """Greatest height, m."""
        return float(np.max(self.height))

    @property
    def peak_time(self) -> float:
        """When it is reached, s."""
        return float(self.t[np.argmax(self.height)])

    @property
    def heights(self) -> Heights:
        """Time and height alone."""
        return Heights(self.t, self.height)


def simulate_slosh(
    container: Cargo | Mapping[str, Any] | str | os.PathLike[str],
    t: np.ndarray,
    position: np.ndarray,
    quaternion: np.ndarray,
    *,
    modes: int = 2,
    height: HeightRule | str = "one-mode",
    gravity: float = STANDARD_GRAVITY,
) -> SloshSimulation:
    """Height of the liquid in a container along any motion.

    The liquid starts level and at rest.

    Args:
        container: an object of a scene, the keys of a cargo entry (as in `[[cargo]]`, name and place may be left out),
            or a TOML file with these keys at top level. An object's own number of modes does not matter here.
        t: (m,) s, increasing without gaps.
        position: (m, 3) of the centre of the container's bottom in the world (z up), m.
        quaternion: (m, 4), (x, y, z, w), container axes to world axes; length 1 within 1e-3, either sign.
        modes: liquid modes in each direction; two predict measured peaks best, one their course (docs/slosh-model.md).
        height: "one-mode" adds the carried modes; "corrected" adds the quasi-static part of those not carried.
        gravity: m/s^2.

    Raises:
        ScenarioError: container or motion wrong or incomplete, samples too far apart.
        ModelError: somewhere the apparent gravity does not press the liquid into the container, or it does not stay in.
    """
    cargo = _filled(container, modes)
    motion = checked_motion(t, position, quaternion)
    return _simulated(cargo, motion, corrected=_is_corrected(height), gravity=gravity)


def _simulated(cargo: Cargo, motion: Motion, *, corrected: bool, gravity: float) -> SloshSimulation:
    assert cargo.filling is not None  # _filled
    filling = cargo.filling
    structure, numbers = _laws(cargo, filling)
    _check_rate(motion, filling.modes)
    spline = _pose_spline(motion)
    count = structure.coordinates
    # Twice as many intervals as steps: the middle of a Runge-Kutta step needs the motion too.
    per_sample = 2 * max(1, int(np.ceil(float(np.max(np.diff(motion.t))) / _LONGEST_STEP - 1e-9)))

    def rate(state: SX, body: SX, _: SX) -> SX:
        accelerations = _accelerations(structure, numbers, _frame_motion(body), state[:count], state[count:])
        return ca.vertcat(state[count:], accelerations)

    step = runge_kutta_step(rate, states=2 * count, inputs=9, parameters=0)

    def solve(refinement: int) -> np.ndarray:
        grid = _divided(motion.t, per_sample * refinement)
        body = _body(spline, grid, gravity)
        _check_pressed(grid, body, filling.liquid_height)
        start = np.concatenate([_level(structure, filling.modes, _world_up(motion)), np.zeros(count)])
        return integrate(step, start, inputs=body, lengths=np.diff(grid[::2]), parameters=np.zeros(0))

    integral = refined(solve, displacements=count)
    states = integral.states[:: (per_sample // 2) * integral.refinement]
    heights = _heights(structure, numbers, corrected, states, _body(spline, motion.t, gravity))
    if not np.isfinite(heights).all():
        raise ModelError("the liquid's height grows without bound along this motion: it leaves its cup")
    return SloshSimulation(
        t=motion.t,
        height=heights,
        displacement=states[:, :count],
        velocity=states[:, count:],
        room=cargo.container.height - filling.liquid_height,
        error=integral.error,
    )


def _filled(container: Cargo | Mapping[str, Any] | str | os.PathLike[str], modes: int) -> Cargo:
    """The container with the wanted number of modes."""
    if isinstance(modes, bool) or not isinstance(modes, int | np.integer) or not 1 <= modes <= _LARGEST_MODE_COUNT:
        raise ScenarioError(f"modes = {modes}: a whole number from 1 to {_LARGEST_MODE_COUNT} is needed")
    if isinstance(container, Mapping):
        return cup_from_table(container, slosh_modes=int(modes))
    if not isinstance(container, Cargo):
        return read_cup(Path(container), slosh_modes=int(modes))
    filling = container.filling
    if filling is None:
        raise ScenarioError(f"{container.name} is solid: there is nothing to slosh; take a container with a liquid")
    slowest = min(filling.modes.oscillators, key=lambda mode: mode.frequency)
    wanted = container.container.slosh_modes(filling.liquid, filling.liquid_height, int(modes), damping=slowest.damping)
    return dataclasses.replace(container, filling=dataclasses.replace(filling, modes=wanted))


def _is_corrected(height: str) -> bool:
    if height not in ("one-mode", "corrected"):
        raise ScenarioError(f'height = "{height}": "one-mode" or "corrected" is needed')
    return height == "corrected"


def _laws(cargo: Cargo, filling: Filling) -> tuple[ObjectStructure, ObjectNumbers]:
    """What the laws of the liquid read; what only the contact with a tray reads is zero."""
    axes, modes = {"x": 0, "y": 1}, filling.modes
    structure = ObjectStructure(
        footprint="disc" if isinstance(cargo.container.footprint, DiscFootprint) else "rectangle",
        oscillators=tuple(tuple(axes[axis] for axis in mode.directions) for mode in modes.oscillators),
    )
    liquid = {
        "liquid_height": filling.liquid_height,
        "static_correction": modes.static_correction,
        "oscillators": tuple(_oscillator(mode) for mode in modes.oscillators),
    }
    unread = {field.name: 0.0 for field in dataclasses.fields(ObjectNumbers) if field.name not in liquid}
    return structure, constants(ObjectNumbers(**unread, **liquid))


def _oscillator(mode: Oscillator) -> OscillatorNumbers:
    return OscillatorNumbers(
        **{field.name: getattr(mode, field.name) for field in dataclasses.fields(OscillatorNumbers)}
    )


def _check_rate(motion: Motion, modes: SloshModes) -> None:
    step = float(np.max(np.diff(motion.t)))
    period = 2 * np.pi / min(mode.frequency for mode in modes.oscillators)
    if step * _LEAST_SAMPLES_PER_PERIOD > period:
        raise ScenarioError(
            f"motion: samples are {step:.3g} s apart, but the liquid swings once in {period:.3g} s; give at least "
            f"{_LEAST_SAMPLES_PER_PERIOD} samples in that time"
        )


def _pose_spline(motion: Motion) -> Any:
    """Quintic spline t -> (..., 7) of position and quaternion; least squares where samples outnumber the knots."""
    from scipy.interpolate import make_interp_spline, make_lsq_spline

    poses = np.hstack([motion.position, motion.quaternion])
    usual = float(np.median(np.diff(motion.t)))
    every = max(1, round(KNOT_SPACING / usual))
    inner = motion.t[every : len(motion.t) - every : every]
    if every == 1 or len(inner) + _DEGREE + 1 > len(motion.t):
        return make_interp_spline(motion.t, poses, k=_DEGREE)
    ends = np.repeat(motion.t[0], _DEGREE + 1), np.repeat(motion.t[-1], _DEGREE + 1)
    return make_lsq_spline(motion.t, poses, np.concatenate([ends[0], inner, ends[1]]), k=_DEGREE)


def _divided(t: np.ndarray, parts: int) -> np.ndarray:
    """Every interval of `t` (m,) cut into equal parts: ((m - 1) parts + 1,)."""
    inside = t[:-1, None] + np.diff(t)[:, None] * (np.arange(parts) / parts)
    return np.append(inside.ravel(), t[-1])


def _body(spline: Any, t: np.ndarray, gravity: float) -> np.ndarray:
    """Angular velocity, angular acceleration and specific force of the container frame in its own axes, shape (9, m).

    With an unnormalised quaternion Q(t) = (v, w): R' = R [omega]x gives omega = 2 vec(Q* Q')/|Q|^2 and, derived once
    more, alpha = 2 vec(Q* Q'')/|Q|^2 - 2 omega (Q.Q')/|Q|^2.
    """
    from scipy.spatial.transform import Rotation

    pose, speed, change = spline(t), spline(t, 1), spline(t, 2)
    q, qd, qdd = pose[:, 3:], speed[:, 3:], change[:, 3:]
    square = np.sum(q * q, axis=1)[:, None]
    omega = 2 * _relative(q, qd) / square
    alpha = 2 * _relative(q, qdd) / square - 2 * omega * np.sum(q * qd, axis=1)[:, None] / square
    lifted = change[:, :3] + np.array([0.0, 0.0, gravity])
    return np.hstack([omega, alpha, Rotation.from_quat(q).inv().apply(lifted)]).T


def _relative(q: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Vector part of conj(q) other for quaternions (m, 4), scalar last: (m, 3)."""
    v, w = q[:, :3], q[:, 3:]
    return w * other[:, :3] - other[:, 3:] * v - np.cross(v, other[:, :3])


def _frame_motion(body: SX) -> FrameMotion:
    return FrameMotion(angular_velocity=body[:3], angular_acceleration=body[3:6], specific_force=body[6:])


def _accelerations(structure: ObjectStructure, numbers: ObjectNumbers, motion: FrameMotion, q: SX, qd: SX) -> SX:
    """Accelerations of all modal masses, (k, 1) m/s^2."""
    parts, start = [], 0
    for oscillator, directions in zip(numbers.oscillators, structure.oscillators, strict=True):
        part = slice(start, start + len(directions))
        start = part.stop
        parts.append(modal_acceleration(oscillator, directions, motion, q[part], qd[part], damp_against_spin=False))
    return ca.vertcat(*parts)


def _world_up(motion: Motion) -> np.ndarray:
    """The world's vertical in the container's axes at the first sample, (3,)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(motion.quaternion[0]).inv().apply([0.0, 0.0, 1.0])


def _level(structure: ObjectStructure, modes: SloshModes, up: np.ndarray) -> np.ndarray:
    """Displacements (k,) of the modal masses at rest in a container that leans: f_xy + P f_z q = 0."""
    places = [
        -up[axis] / (mode.curvature * up[2])
        for mode, directions in zip(modes.oscillators, structure.oscillators, strict=True)
        for axis in directions
    ]
    return np.array(places)


def _check_pressed(t: np.ndarray, body: np.ndarray, liquid_height: float) -> None:
    """The record must be a motion, and its apparent gravity press the liquid down from the surface to the bottom."""
    force = np.linalg.norm(body[6:], axis=0)
    hardest = int(np.argmax(force))
    if force[hardest] > _LARGEST_FORCE:
        raise ScenarioError(
            f"motion: at t = {t[hardest]:.3f} s the container is accelerated by {force[hardest]:.3g} m/s^2 (at most "
            f"{_LARGEST_FORCE:g} are taken for a motion); give positions in metres and without jumps"
        )
    spin = np.sum(body[:2] ** 2, axis=0)
    pressing = np.minimum(body[8], body[8] - spin * liquid_height)
    worst = int(np.argmin(pressing))
    if pressing[worst] <= 0.0:
        raise ModelError(
            f"motion: at t = {t[worst]:.3f} s the apparent gravity along the container's axis is {pressing[worst]:.3g} "
            "m/s^2: it does not press the liquid into its container and the slosh model is void; move it more gently"
        )


def _heights(
    structure: ObjectStructure, numbers: ObjectNumbers, corrected: bool, states: np.ndarray, body: np.ndarray
) -> np.ndarray:
    """Height at the wall at every sample, (m,) m, from states (m, 2 k) and body rows (9, m)."""
    count = structure.coordinates
    state, row = SX.sym("x", 2 * count), SX.sym("b", 9)
    own, start = [], 0
    for directions in structure.oscillators:
        part = slice(start, start + len(directions))
        start = part.stop
        # The height reads displacements only.
        own.append(OscillatorState(state[part], state[count:][part], SX.zeros(len(directions))))
    eta = surface_vector(numbers, structure, _frame_motion(row), tuple(own), corrected=corrected)
    function = ca.Function("height", [state, row], [crest(structure, eta)], {"cse": True})
    return np.array(function(ca.DM(states.T), ca.DM(body)).full())[0]
