"""The state of a plan at one instant, and the scene of a motion that goes on from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace

import numpy as np

from nospill.errors import ScenarioError
from nospill.motion.trajectory import SloshTrack, Trajectory
from nospill.plans.swings import swing_table, swings_at, with_own_second_order
from nospill.scene.initial_state import InitialState
from nospill.scene.scene import Scene
from nospill.scene.swing import Swing

STOP_INTERVALS = 25
"""Of the grid of a stop; where liquids are in the problem with several modes, which are faster, there are more."""


@dataclass(frozen=True, slots=True)
class MotionState:
    """How arm, tray and liquids move at an instant of a plan.

    Attributes:
        t: s, of a sample of the plan's record.
        arm: the tray on its path, and the joints.
        swings: of every liquid, all its modes, by object.
        rest: what is left of the plan's record, on a clock that begins there.
    """

    t: float
    arm: InitialState
    swings: Mapping[str, Swing]
    rest: Trajectory = field(repr=False)


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
        ScenarioError: a time is outside the motion, or as `require_known_state`.
        ModelError: the liquids cannot be integrated.
    """
    times = np.atleast_1d(record.require_times(t))
    require_known_state(scene)
    rows = np.rint((times - record.t[0]) * record.rate).astype(int)
    swings = swings_at(record, scene, record.t[rows], following=scene.cargo)
    swings = with_own_second_order(swings, record, scene, record.t[rows])
    return [
        MotionState(float(record.t[row]), _recorded(record, row), own, rest_of(record, float(record.t[row])))
        for row, own in zip(rows, swings, strict=True)
    ]


def beginning_in(scene: Scene, state: MotionState, *, stop: bool = False) -> Scene:
    """The scene whose motion begins in a state: its path leads through there, and its liquids swing as they do then.

    Args:
        scene: of the motion. Objects that the state does not know have liquids at rest.
        state: of a plan on the same path, with the same objects.
        stop: whether the motion may come to rest anywhere on the path; weights of smoothness, which would hold it back,
            are left out then, and the grid is that of stops.

    Raises:
        ScenarioError: the joints are off the path, a liquid stands above its limit, or the scene states what does not
            go together with a beginning in motion.
    """
    known = {item.name for item in scene.cargo if item.filling is not None}
    swings = {
        f"cargo.{name}.initial_swing": swing_table(swing) for name, swing in state.swings.items() if name in known
    }
    arm = {key: list(value) if isinstance(value, tuple) else value for key, value in asdict(state.arm).items()}
    weights = dict.fromkeys(("planning.path_jerk_weight", "planning.tilt_jerk_weight"))
    halting = {**weights, "planning.intervals": STOP_INTERVALS, "motion.stop": True}
    return scene.changed({"initial_state": arm, **swings, **(halting if stop else {})})


def require_known_state(scene: Scene) -> None:
    """Refuse a motion whose record does not say in which state the tray is at an instant of it.

    Raises:
        ScenarioError: as `require_known_joints`, or the tray may leave its path.
    """
    require_known_joints(scene)
    if scene.motion.leaves_path:
        raise ScenarioError(
            f"{scene.name}: the tray may leave its path or turn on it, and a motion from the midst of the plan keeps "
            "to its path; plan along a given path (not a free one), without corridor and with a given yaw. Stops along "
            "its own way are found all the same: nospill stops DIR"
        )


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


def _recorded(trajectory: Trajectory, row: int) -> InitialState:
    def pair(values: np.ndarray) -> tuple[float, float]:
        return float(values[row, 0]), float(values[row, 1])

    def joints(values: np.ndarray) -> tuple[float, ...]:
        return tuple(values[row].tolist())

    return InitialState(
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
