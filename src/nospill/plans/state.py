"""The state of a plan at one instant, and the scene of a motion that goes on from it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace

import numpy as np

from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.motion.trajectory import SloshTrack, Trajectory
from nospill.plans.same_bodies import require_same_bodies
from nospill.plans.swings import swing_table, swings_at, with_own_second_order
from nospill.scenario.about_the_path import state_about, tray_of
from nospill.scenario.fields import FREE
from nospill.scenario.initial_state_entry import OFF_PATH
from nospill.scene.initial_state import InitialState
from nospill.scene.scene import Scene
from nospill.scene.swing import Swing

_SAME_PLACE, _SAME_YAW = 1e-3, math.radians(0.5)
"""m and rad: how far a free path may begin from where the tray is without a word."""
_ALONG = ("s", "s_rate", "s_acceleration")
STOP_INTERVALS = 25
"""Of the grid of a stop that is planned as a motion of its own; where liquids are in the problem with several modes,
which are faster, there are more."""


@dataclass(frozen=True, slots=True)
class MotionState:
    """How arm, tray and liquids move at an instant of a plan.

    Attributes:
        t: s, of a sample of the plan's record.
        arm: the tray on its path, and the joints.
        swings: of every liquid, all its modes, by object.
        rest: what is left of the plan's record, on a clock that begins there.
        scene: of the plan; None where nobody says.
    """

    t: float
    arm: InitialState
    swings: Mapping[str, Swing]
    rest: Trajectory = field(repr=False)
    scene: Scene | None = field(default=None, repr=False)


def rest_of(record: Trajectory, t: float) -> Trajectory:
    """What is left of a record from the sample nearest to a time, s, on a clock that begins there."""
    first = round((t - record.t[0]) * record.rate)
    columns = {
        item.name: getattr(record, item.name)[first:]
        for item in fields(record)
        if item.name not in ("t", "joints", "slosh", "in_motion")
    }
    slosh = {
        name: SloshTrack(track.displacement[first:], track.velocity[first:], track.height[first:])
        for name, track in record.slosh.items()
    }
    return replace(record, t=record.t[first:] - record.t[first], slosh=slosh, in_motion=True, **columns)


def states_of(record: Trajectory, scene: Scene, t: Sequence[float] | np.ndarray) -> list[MotionState]:
    """The states of a planned motion at the samples of its record that are nearest to some times (m,), s.

    Tray and joints are as recorded there, the liquids are integrated as for the certificate.

    Raises:
        ScenarioError: a time is outside the motion, or as `require_known_joints`.
        ModelError: the liquids cannot be integrated.
    """
    times = np.atleast_1d(record.require_times(t))
    require_known_joints(scene)
    rows = np.rint((times - record.t[0]) * record.rate).astype(int)
    swings = swings_at(record, scene, record.t[rows], following=scene.cargo)
    swings = with_own_second_order(swings, record, scene, record.t[rows])
    return [
        MotionState(
            float(record.t[row]), _recorded(record, scene, row), own, rest_of(record, float(record.t[row])), scene
        )
        for row, own in zip(rows, swings, strict=True)
    ]


def beginning_in(scene: Scene, state: MotionState, *, stop: bool = False) -> Scene:
    """The scene whose motion begins in a state: its path leads through there, and its liquids swing as they do then.

    Args:
        scene: of the motion. Objects that the state does not know have liquids at rest.
        state: of a plan with the same objects, on the same path, or on any where the tray may leave the scene's.
        stop: whether the motion may come to rest anywhere on the path; weights of smoothness, which would hold it back,
            are left out then, and the grid is that of stops.

    Raises:
        ScenarioError: the joints are off the path, a liquid stands above its limit, arm, tray or an object is another
            one than the state is of, or the scene states what does not go together with a beginning in motion.
    """
    if state.scene is not None:
        require_same_bodies(scene, state.scene)
    known = {item.name for item in scene.cargo if item.filling is not None}
    swings = {
        f"cargo.{name}.initial_swing": swing_table(swing) for name, swing in state.swings.items() if name in known
    }
    arm = asdict(state.arm)
    del arm["offset"], arm["turn"]  # they follow from the joints
    on_the_way = dict[str, object]()
    if scene.motion.leaves_path:
        arm, on_the_way = _about_path(scene, state.arm, arm)
    arm = {key: list(value) if isinstance(value, tuple) else value for key, value in arm.items()}
    weights = dict.fromkeys(("planning.path_jerk_weight", "planning.tilt_jerk_weight"))
    halting = {**weights, "planning.intervals": STOP_INTERVALS, "motion.stop": True}
    return scene.changed({**on_the_way, "initial_state": arm, **swings, **(halting if stop else {})})


def _about_path(
    scene: Scene, state: InitialState, keys: dict[str, object]
) -> tuple[dict[str, object], dict[str, object]]:
    """The keys of a state about a path that the tray may leave, and what changes of the path.

    A path whose way is open begins where the tray is, so that it is looked for from there. On any other one than the
    state's own the place nearest to the tray counts.
    """
    tray = tray_of(state, scene.robot, scene.tray.tool)
    placeless = {key: value for key, value in keys.items() if key not in _ALONG}
    path = scene.source["path"]
    if path.get("type") == "free" and "way" not in path:
        return placeless, {"path.start": {"position": tray[0, :3].tolist(), "yaw": float(tray[0, 3])}}
    own = np.append(np.array(state.offset[0]), state.turn[0])
    same = np.max(np.abs(scene.path.at(state.s)[0] + own - tray[0])) <= OFF_PATH
    return (keys if same else placeless), {}


def start_moved(scene: Scene, state: MotionState) -> str:
    """That a free path does not begin at the `start` it states, but where the tray is; empty where that is the same."""
    path = scene.source["path"]
    if path.get("type") != "free" or "way" in path:
        return ""
    here, stated = tray_of(state.arm, scene.robot, scene.tray.tool)[0], scene.path.at([0.0])[0]
    away = float(np.linalg.norm(here[:3] - stated[:3]))
    turned = 0.0 if path["start"].get("yaw") == FREE else abs(math.remainder(float(here[3] - stated[3]), 2.0 * math.pi))
    if away <= _SAME_PLACE and turned <= _SAME_YAW:
        return ""
    shown, angle = format_quantity(away, "length", digits=3), format_quantity(turned, "angle", digits=3)
    return f"path.start is {shown} and {angle} from where the tray is at {state.t:g} s; the motion begins where it is"


def require_known_joints(scene: Scene) -> None:
    """Refuse a motion whose record does not say how the joints move at an instant of it.

    Raises:
        ScenarioError: they follow a controller late, or may be late.
    """
    if scene.controller is not None and scene.controller.is_late:
        raise ScenarioError(
            f"{scene.name}: [controller] has a delay or lag, and its command runs ahead of the joints; a motion from "
            "the midst of the plan is known only without them"
        )
    if scene.tracking is not None:
        raise ScenarioError(
            f"{scene.name}: tolerance.tracking leaves open how late the joints are; a motion from the midst of the "
            "plan is known only without it"
        )


def _recorded(trajectory: Trajectory, scene: Scene, row: int) -> InitialState:
    def pair(values: np.ndarray) -> tuple[float, float]:
        return float(values[row, 0]), float(values[row, 1])

    def joints(values: np.ndarray) -> tuple[float, ...]:
        return tuple(values[row].tolist())

    state = InitialState(
        s=float(trajectory.s[row]),
        s_rate=float(trajectory.s_rate[row]),
        s_acceleration=float(trajectory.s_acceleration[row]),
        tilt=pair(trajectory.tilt),
        tilt_rate=pair(trajectory.tilt_rate),
        tilt_acceleration=pair(trajectory.tilt_acceleration),
        joint_position=joints(trajectory.joint_position),
        joint_speed=joints(trajectory.joint_speed),
        joint_acceleration=joints(trajectory.joint_acceleration),
    )
    if not scene.motion.leaves_path:
        return state
    return state_about(state, True, scene.robot, scene.tray.tool, scene.path, scene.motion)[0]
