"""Height of the liquid in one container that is moved in a given way.

The sampled poses become a quintic spline, the spline the container's rates and apparent gravity, and these drive the
same laws that plan and certify: the modal masses (`nospill.laws.slosh.motion`) and the height at the wall
(`nospill.laws.slosh.height`). The damping is measured against the wall.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import casadi as ca
import numpy as np

from nospill.certification.replay import liquid_steps
from nospill.core.frames import SX, body_motion
from nospill.core.trees import constants, flatten
from nospill.errors import ModelError, ScenarioError
from nospill.laws.kinds import lone_object_kind
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.sample import object_states
from nospill.laws.scene_parameters import object_numbers, object_structure
from nospill.laws.slosh.height import crest, surface_vector, yaw_heights
from nospill.laws.slosh.integrate import integrate, refined
from nospill.laws.structure import YAW_AXES, ObjectStructure
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import with_modes
from nospill.scene.sloshing.modes import STANDARD_GRAVITY, Oscillator, SloshModes
from nospill.scene.turning import turning
from nospill.simulation.container_motion import body_rows, check_pressed, pose_spline, world_up
from nospill.simulation.cup_file import cup_from_table, read_cup
from nospill.simulation.motion_file import Heights, Motion, checked_motion
from nospill.simulation.readings import Model, Reading, reading_of

HeightRule = Literal["one-mode", "corrected"]
"""Height at the wall: of the carried modes alone, or with the quasi-static part of all the others."""

_LONGEST_STEP = 0.002
_LEAST_SAMPLES_PER_PERIOD = 5
_LARGEST_MODE_COUNT = 20


@dataclass(frozen=True, slots=True)
class SloshSimulation:
    """What the liquid does.

    Attributes:
        t: (m,) s, the times of the motion's samples.
        height: (m,) m, of the free surface above rest at the wall, where it is highest, along the container's axis.
        reading: (m,) m, what a gauge at the wall shows of it (`nospill.simulation.readings`).
        displacement: (m, k) of the modal masses along the container's axes, m; of yaw modes, height in a box's corner.
        velocity: (m, k) likewise, m/s.
        freeboard: m, from the rest level to the rim.
        error: estimated integration error of the displacements, m.
    """

    t: np.ndarray
    height: np.ndarray
    reading: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    freeboard: float
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
        """Times and readings, to be compared with measured heights."""
        return Heights(self.t, self.reading)


def simulate_slosh(
    container: Cargo | Mapping[str, Any] | str | os.PathLike[str],
    t: np.ndarray,
    position: np.ndarray,
    quaternion: np.ndarray,
    *,
    modes: int | None = None,
    height: HeightRule | str = "one-mode",
    gravity: float = STANDARD_GRAVITY,
    azimuth: float | None = None,
    model: Model | str = "surface",
) -> SloshSimulation:
    """Height of the liquid in a container along any motion.

    The liquid starts level and at rest, one of a scene with the initial swing that the scene states.

    Args:
        container: an object of a scene, the keys of a cargo entry (as in `[[cargo]]`, name and place may be left out),
            or a TOML file with these keys at top level. An object's own number of modes does not matter here.
        t: (m,) s, increasing without gaps.
        position: (m, 3) of the centre of the container's bottom in the world (z up), m.
        quaternion: (m, 4), (x, y, z, w), container axes to world axes; length 1 within 1e-3, either sign.
        modes: liquid modes in each direction, by default 2 for the surface and 20 for the contact line
            (docs/slosh-model.md compares them with measured runs).
        height: "one-mode" adds the carried modes; "corrected" adds the quasi-static part of those not carried.
        gravity: m/s^2.
        azimuth: rad, from the container's x towards its y: the height at the wall there, with its sign; the crest when
            left out.
        model: what a gauge at the wall reads: the "surface", or the "contact-line", which stays behind it.

    Raises:
        ScenarioError: container or motion wrong or incomplete, samples too far apart.
        ModelError: somewhere the apparent gravity does not press the liquid into the container, or it does not stay in.
    """
    reading = reading_of(model)
    cargo = _container_with_modes(container, reading.modes if modes is None else modes)
    motion = checked_motion(t, position, quaternion)
    if azimuth is not None and cargo.shape == "box":
        raise ScenarioError("azimuth: a box has corners; heights at an azimuth are of round containers")
    return _simulate(cargo, motion, corrected=_is_corrected(height), gravity=gravity, azimuth=azimuth, reading=reading)


def _simulate(
    cargo: Cargo, motion: Motion, *, corrected: bool, gravity: float, azimuth: float | None, reading: Reading
) -> SloshSimulation:
    assert cargo.filling is not None  # _filled
    filling = cargo.filling
    structure = object_structure(cargo)
    own = object_numbers(cargo, fidelity="full", gravity=gravity)
    numbers = constants(own)
    _check_rate(motion, filling.modes)
    spline = pose_spline(motion)
    count = structure.coordinates
    # Twice as many intervals as steps: the middle of a Runge-Kutta step needs the motion too.
    per_sample = 2 * max(1, int(np.ceil(float(np.max(np.diff(motion.t))) / _LONGEST_STEP - 1e-9)))

    # The motion is that of the container itself, wherever on a tray it is said to stand.
    parameters = flatten((gravity, 0.0, replace(own, position=np.zeros_like(own.position), yaw=0.0)))
    steps = liquid_steps(lone_object_kind(structure))

    def solve(refinement: int) -> np.ndarray:
        grid = _divide(motion.t, per_sample * refinement)
        body = body_rows(spline, grid, gravity)
        check_pressed(grid, body, filling.liquid_height)
        displaced, moving = cargo.initial_coordinates
        start = np.concatenate([_level(structure, filling.oscillators, world_up(motion)) + displaced, moving])
        lengths = np.diff(grid[::2])
        return integrate(steps, start[None], inputs=body, lengths=lengths, parameters=parameters[None])[:, 0]

    integral = refined(solve, displacements=count)
    states = integral.states[:: (per_sample // 2) * integral.refinement]
    heights = _heights(structure, numbers, corrected, states, body_rows(spline, motion.t, gravity), azimuth)
    if not np.isfinite(heights).all():
        raise ModelError("the liquid's height grows without bound along this motion: it leaves its cup")
    return SloshSimulation(
        t=motion.t,
        height=heights,
        reading=reading.of(heights, filling.liquid),
        displacement=states[:, :count],
        velocity=states[:, count:],
        freeboard=cargo.container.height - filling.liquid_height,
        error=integral.error,
    )


def _container_with_modes(container: Cargo | Mapping[str, Any] | str | os.PathLike[str], modes: int) -> Cargo:
    """The container with the wanted number of modes, and yaw modes if it is a box: any motion may turn it."""
    if isinstance(modes, bool) or not isinstance(modes, int | np.integer) or not 1 <= modes <= _LARGEST_MODE_COUNT:
        raise ScenarioError(f"modes = {modes}: a whole number from 1 to {_LARGEST_MODE_COUNT} is needed")
    if isinstance(container, Mapping):
        return turning(cup_from_table(container, slosh_modes=int(modes)))
    if not isinstance(container, Cargo):
        return turning(read_cup(Path(container), slosh_modes=int(modes)))
    if container.filling is None:
        raise ScenarioError(f"{container.name} is solid: there is nothing to slosh; take a container with a liquid")
    return turning(with_modes(container, int(modes)))


def _is_corrected(height: str) -> bool:
    if height not in ("one-mode", "corrected"):
        raise ScenarioError(f'height = "{height}": "one-mode" or "corrected" is needed')
    return height == "corrected"


def _check_rate(motion: Motion, modes: SloshModes) -> None:
    step = float(np.max(np.diff(motion.t)))
    period = 2 * np.pi / min(mode.frequency for mode in modes.oscillators)
    if step * _LEAST_SAMPLES_PER_PERIOD > period:
        raise ScenarioError(
            f"motion: samples are {step:.3g} s apart, but the liquid swings once in {period:.3g} s; give at least "
            f"{_LEAST_SAMPLES_PER_PERIOD} samples in that time"
        )


def _divide(t: np.ndarray, parts: int) -> np.ndarray:
    """Every interval of `t` (m,) cut into equal parts: ((m - 1) parts + 1,)."""
    inside = t[:-1, None] + np.diff(t)[:, None] * (np.arange(parts) / parts)
    return np.append(inside.ravel(), t[-1])


def _level(structure: ObjectStructure, modes: Sequence[Oscillator], up: np.ndarray) -> np.ndarray:
    """Displacements (k,) of the modal masses at rest in a container that leans: f_xy + (omega^2/g) f_z q = 0."""
    places = [
        0.0 if directions == YAW_AXES else -up[axis] / (mode.stiffness * up[2])
        for mode, directions in zip(modes, structure.oscillators, strict=True)
        for axis in directions
    ]
    return np.array(places)


def _heights(
    structure: ObjectStructure,
    numbers: ObjectNumbers,
    corrected: bool,
    states: np.ndarray,
    body: np.ndarray,
    azimuth: float | None,
) -> np.ndarray:
    """Height at the wall at every sample, (m,) m, from states (m, 2 k) and body rows (9, m)."""
    count = structure.coordinates
    state, row = SX.sym("x", 2 * count), SX.sym("b", 9)
    # The height reads displacements only.
    own = object_states(structure, state[:count], state[count:], SX.zeros(count))
    eta = surface_vector(numbers, structure, body_motion(row), own, corrected=corrected)
    yaw = yaw_heights(numbers, structure, body_motion(row), own, corrected=corrected)
    shown = crest(structure, eta, yaw) if azimuth is None else np.cos(azimuth) * eta[0] + np.sin(azimuth) * eta[1]
    function = ca.Function("height", [state, row], [shown], {"cse": True})
    return np.array(function(ca.DM(states.T), ca.DM(body)).full())[0]
