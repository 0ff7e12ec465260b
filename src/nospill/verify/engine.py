"""The objects in MuJoCo, seen from the tray: the tray is a fixed plane, the world moves.

Every object that is not fixed is a free rigid body that stands on small spheres along the outline of its bottom. A
single cylinder would touch the plane at three points that are chosen anew, by rounding, while it stands upright; under
a yaw moment of 60 % of what friction can hold it starts to spin. Fixed points do not wander. They lie on the rim, so
friction resists a turn on the spot with mu N R, as it does for a cup that stands on its rim; a flat bottom under
uniform pressure has two thirds of that, which is what the planner counts on.

A mode of a liquid is a point mass in a bowl, a paraboloid fixed to the container: two slides, sideways and up, with the
height tied to the square of the displacement. Apparent gravity in the bowl is the spring, so the frequency follows it,
and falls with the amplitude as that of a swinging liquid does (a straight spring of m omega^2 would swing too far and
push the cup 5 % too hard where the surface rises by half the radius).
"""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from nospill.errors import MissingExtraError, ModelError
from nospill.verify.bodies import Body, ModalMass
from nospill.verify.inertial import carrying, inertial_forces, inertial_torques, skew
from nospill.verify.tray_motion import TrayMotion

STEP = 1e-3
"""s; of the simulation, where nothing asks for a shorter one."""

CONTACT_RADIUS = 1e-3
"""m; of the spheres an object stands on."""

_LINK_FRACTION = 1e-3
"""Of a modal mass that moves in two directions: what the body between the two slides weighs."""

_AXES = ("1 0 0", "0 1 0")

_POINT_INERTIA = 1e-10
"""kg m^2; of a modal mass, which is a point, for an engine that wants some."""

_OPTIONS = (
    'integrator="implicitfast" solver="Newton" cone="elliptic" impratio="100" noslip_iterations="0"><flag '
    'autoreset="disable"/></option>'
)
_TIED = 'solref="0.002 1" solimp="0.9999 0.9999 0.001 0.5 2"'
_CONTACT = 'solref="0.005 1" solimp="0.99 0.999 0.0001 0.5 2" condim="3"'


@dataclass(frozen=True, slots=True)
class Simulation:
    """Poses of k objects relative to the tray at m instants.

    Attributes:
        t: (m,) s.
        position: (m, k, 3) bottom centres, m.
        quaternion: (m, k, 4), (w, x, y, z), object to tray axes.
        modes: (m, j) displacement of every modal mass along its axes, object by object, m.
    """

    t: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    modes: np.ndarray


def mujoco() -> Any:
    """The library.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        return importlib.import_module("mujoco")
    except ImportError as error:
        raise MissingExtraError(
            f"MuJoCo cannot be loaded ({error}); install it with: pip install 'nospill[verify]'"
        ) from error


def build(bodies: tuple[Body, ...], step: float = STEP) -> Any:
    """The model: tray frame = world frame; the tray has no end. `step`: of the simulation, s."""
    engine = mujoco()
    parts = "".join(_body_text(index, body) for index, body in enumerate(bodies))
    text = (
        f'<mujoco><option timestep="{step}" {_OPTIONS}<worldbody>'
        f'<geom name="tray" type="plane" size="1 1 0.01" friction="0 0 0" {_CONTACT} '
        f'contype="1" conaffinity="0"/>{parts}</worldbody>'
        f"<equality>{_bowls(bodies)}</equality></mujoco>"
    )
    model = engine.MjModel.from_xml_string(text)
    for index, body in enumerate(bodies):
        # Written past the compiler, which refuses the inertia of a liquid, that about its axis being none.
        number = model.body(f"object{index}").id
        values, axes = np.linalg.eigh(body.inertia)
        axes *= np.sign(np.linalg.det(axes))
        model.body_mass[number], model.body_ipos[number], model.body_inertia[number] = body.mass, body.centre, values
        engine.mju_mat2Quat(model.body_iquat[number], axes.ravel())
    with quiet(engine):
        engine.mj_setConst(model, engine.MjData(model))
    return model


def simulate(model: Any, bodies: tuple[Body, ...], motion: TrayMotion) -> Simulation:
    """Let the objects go at the first instant and follow them along the tray's motion, in its steps.

    Raises:
        ModelError: the engine lost the solution.
    """
    # What is lost is reported once, at the end.
    with quiet(mujoco()), np.errstate(all="ignore"):
        return Stepper(model, bodies, motion).run()


class Stepper:
    """One run, step by step.

    Attributes:
        data: the engine's state.
        index: the next instant.
    """

    def __init__(self, model: Any, bodies: tuple[Body, ...], motion: TrayMotion) -> None:
        engine = mujoco()
        self._engine, self._model, self._motion = engine, model, motion
        self.data = engine.MjData(model)
        self.index = 0
        self._turning = skew(motion.angular_velocity)
        self._carried = carrying(motion.angular_velocity, motion.angular_acceleration)
        self._loose = [index for index, body in enumerate(bodies) if not body.fixed]
        self._places = np.array([_place(body) for body in bodies]).reshape(-1, 7)
        self._free = np.array([model.joint(f"free{i}").qposadr[0] for i in self._loose], dtype=int)
        across = [i for i in range(model.njnt) if model.joint(i).name.startswith("across")]
        self._slots = model.jnt_qposadr[across]
        self._root = model.body_rootid[1:]
        for address, index in zip(self._free, self._loose, strict=True):
            self.data.qpos[address : address + 7] = self._places[index]
        curvature = np.array([mode.curvature for body in bodies for mode in body.modes for _ in mode.axes])
        displacement, velocity = np.hstack([np.zeros((2, 0)), *(body.swing for body in bodies)])
        up = [i for i in range(model.njnt) if model.joint(i).name.startswith("up")]
        for joints, places, rates in (
            (across, displacement, velocity),
            (up, curvature / 2 * displacement**2, curvature * displacement * velocity),
        ):
            self.data.qpos[model.jnt_qposadr[joints]] = places
            self.data.qvel[model.jnt_dofadr[joints]] = rates

    def step(self) -> None:
        """One step from the instant `index` to the next."""
        engine, model, data, motion, now = self._engine, self._model, self.data, self._motion, self.index
        model.opt.gravity[:] = -motion.specific_force[now]
        engine.mj_step1(model, data)
        centre, relative = data.xipos[1:], data.cvel[1:, :3]
        arm = centre - data.subtree_com[self._root]
        velocity = data.cvel[1:, 3:] + (skew(relative) @ arm[:, :, None])[:, :, 0]
        axes = data.ximat[1:].reshape(-1, 3, 3)
        inertia = (axes * model.body_inertia[1:, None, :]) @ np.swapaxes(axes, 1, 2)
        spin, turning = motion.angular_velocity[now], self._turning[now]
        data.xfrc_applied[1:, :3] = inertial_forces(
            model.body_mass[1:], centre, velocity, turning=turning, carried=self._carried[now]
        )
        data.xfrc_applied[1:, 3:] = inertial_torques(
            inertia, relative, spin=spin, spin_rate=motion.angular_acceleration[now], turning=turning
        )
        engine.mj_step2(model, data)
        self.index += 1

    def run(self) -> Simulation:
        """To the end.

        Raises:
            ModelError: the engine lost the solution.
        """
        count = len(self._motion.t)
        poses = np.tile(self._places, (count, 1, 1))
        modes = np.empty((count, len(self._slots)))
        columns = self._free[:, None] + np.arange(7)
        for now in range(count):
            poses[now, self._loose], modes[now] = self.data.qpos[columns], self.data.qpos[self._slots]
            if now + 1 < count:
                self.step()
        warnings = self._engine.mjtWarning
        lost = [warnings.mjWARN_BADQPOS, warnings.mjWARN_BADQVEL, warnings.mjWARN_BADQACC, warnings.mjWARN_INERTIA]
        if any(self.data.warning[int(kind)].number for kind in lost) or not np.all(np.isfinite(poses)):
            raise ModelError(
                "MuJoCo lost the objects: their motion is not a number; the plan's accelerations are too large"
            )
        return Simulation(self._motion.t, poses[:, :, :3], poses[:, :, 3:], modes)


def _place(body: Body) -> tuple[float, ...]:
    """Where a body stands: bottom centre on the tray, m, and the quaternion (w, x, y, z) of its yaw."""
    half = body.yaw / 2
    return (*map(float, body.position[:2]), 0.0, float(np.cos(half)), 0.0, 0.0, float(np.sin(half)))


def _body_text(index: int, body: Body) -> str:
    touch = (
        f'type="sphere" size="{CONTACT_RADIUS}" mass="0" friction="{body.friction} 0 0" {_CONTACT} '
        'contype="0" conaffinity="1"'
    )
    contacts = "".join(f'<geom {touch} pos="{x:.17g} {y:.17g} {CONTACT_RADIUS}"/>' for x, y in body.contacts)
    modes = "".join(_mode_text(f"{index}-{number}", mode) for number, mode in enumerate(body.modes))
    held = f'<freejoint name="free{index}"/>'
    if body.fixed:  # a body without a joint is welded to the world, which is the tray here
        held, contacts = "", ""
    x, y, z, *turn = _place(body)
    pose = f'pos="{x:.17g} {y:.17g} {z:.17g}" quat="{" ".join(f"{value:.17g}" for value in turn)}"'
    return (
        f'<body name="object{index}" simple="false" {pose}>{held}'
        '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        f"{contacts}{modes}</body>"
    )


def _mode_text(label: str, mode: ModalMass) -> str:
    """One body per direction, nested, each with a slide across and one up; the mass is on the last."""
    text = ""
    for depth, axis in reversed(list(enumerate(mode.axes))):
        last, first = depth == len(mode.axes) - 1, depth == 0
        foot = (*mode.place, mode.height) if first else (0.0, 0.0, 0.0)
        share = 1.0 - _LINK_FRACTION * (len(mode.axes) - 1) if last else _LINK_FRACTION
        text = (
            f'<body simple="false" pos="{" ".join(f"{value:.17g}" for value in foot)}">'
            f'<inertial pos="0 0 0" mass="{share * mode.mass:.17g}" '
            f'diaginertia="{_POINT_INERTIA} {_POINT_INERTIA} {_POINT_INERTIA}"/>'
            f'<joint name="across{label}-{axis}" type="slide" axis="{_AXES[axis]}" damping="{mode.damping:.17g}" '
            f'stiffness="{mode.spring:.17g}"/>'
            f'<joint name="up{label}-{axis}" type="slide" axis="0 0 1" damping="{mode.damping:.17g}"/>{text}</body>'
        )
    return text


def _bowls(bodies: tuple[Body, ...]) -> str:
    """Rise over the bowl's lowest point: curvature/2 times the square of the displacement, for each direction."""
    return "".join(
        f'<joint joint1="up{index}-{number}-{axis}" joint2="across{index}-{number}-{axis}" '
        f'polycoef="0 0 {mode.curvature / 2:.17g} 0 0" {_TIED}/>'
        for index, body in enumerate(bodies)
        for number, mode in enumerate(body.modes)
        for axis in mode.axes
    )


@contextlib.contextmanager
def quiet(engine: Any) -> Iterator[None]:
    """Warnings of the engine go nowhere; without this it writes a log file into the folder we stand in."""
    before = engine.get_mju_user_warning()
    engine.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        engine.set_mju_user_warning(before)
