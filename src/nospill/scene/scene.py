"""The frozen whole: everything a plan depends on, in SI units, checked by the reader that made it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import Any, Literal, Protocol

import numpy as np

from nospill.core.attitudes import angles_between
from nospill.core.files import atomic_text
from nospill.errors import ScenarioError
from nospill.paths.path import Path
from nospill.robots.robot import Robot
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import with_modes
from nospill.scene.controller import Controller
from nospill.scene.heights import HeightOrder
from nospill.scene.initial_state import InitialState
from nospill.scene.limits import Limit, LimitRecord
from nospill.scene.obstacles import Obstacle
from nospill.scene.places import Region, Via
from nospill.scene.tracking import Tracking
from nospill.scene.tray import Tray

Fidelity = Literal["deliverable", "full"]

FULL_MODES = 20
"""Modes of a liquid in each direction in the full model. One more changes no peak by half a percent of its limit."""
EndCondition = Literal["still", "published", "residual"]


SPEED_STEP = 0.0125
"""Distance of the 1/v of the speeds v of a range that are looked at, parts of the planned one. What a mode of frequency
omega does in the time T is a function of 1/v of bandwidth omega T, and this determines it up to omega T = 250: the
fastest of twenty modes of a cup of 35 mm radius in 1.9 s."""

_LEAST_LEVER = 0.01
"""m; a tray that moves less than this for a radian of the joints counts as moved so far."""
_PLANNED_MODES = 3
"""Modes with which liquids join a problem at full fidelity; where the faster ones alone break a limit, it gets twice as
many."""


@dataclass(frozen=True, slots=True)
class MotionRules:
    """What the motion may do.

    Attributes:
        tilt_free: whether tray pitch and roll are free.
        max_tilt: bound on each of the two tilt angles, rad.
        path_jerk_limit: bound on |s'''|, 1/s^3.
        tilt_jerk_limit: bound on each tilt angle's third derivative, rad/s^3.
        end: end condition for the liquids.
        residual_fraction: height after the end over max_slosh_height.
        max_duration: longest motion that is considered, s.
        hold_before: how long the arm stands still at the start of an exported motion, s.
        hold_after: likewise, at its end.
        duration: of the motion, s; None for the shortest that keeps the limits.
        corridor: greatest distance of the tray's centre from its path between the ends, m; None where it keeps to it.
        yaw_free: whether the tray turns as it likes between the ends.
        max_speed: of the tray's centre, m/s; None where only other limits bound it.
        max_acceleration: likewise, m/s^2, gravity not counted.
        speed_range: least and greatest part of its speed at which it keeps the limits too; None for its own speed.
        via: places that the tray's centre passes, in this order.
        corridor_shares: parts of `corridor` at even steps of the path parameter, where it is not as wide everywhere.
        slosh_height: to which order the heights of the liquids are judged, as far as it is known of them.
        linear_since: why all of them are linear, as the end of a sentence; empty where they are not, or as published.
        residual_height: likewise, of heights after the end; linear where `slosh_height` is.
        residual_linear_since: why these alone are linear, as the end of a sentence; empty elsewhere.
        stop: whether it may come to rest anywhere on its path.
        stoppable: s, within which a certified stop exists at every instant; None where that is not asked for.
    """

    tilt_free: bool
    max_tilt: float
    path_jerk_limit: float
    tilt_jerk_limit: float
    end: EndCondition
    residual_fraction: float
    max_duration: float
    hold_before: float = 0.0
    hold_after: float = 0.0
    duration: float | None = None
    corridor: float | None = None
    yaw_free: bool = False
    max_speed: float | None = None
    max_acceleration: float | None = None
    speed_range: tuple[float, float] | None = None
    via: tuple[Via, ...] = ()
    corridor_shares: tuple[float, ...] = ()
    slosh_height: HeightOrder = "linear"
    linear_since: str = ""
    residual_height: HeightOrder = "linear"
    residual_linear_since: str = ""
    stop: bool = False
    stoppable: float | None = None

    @property
    def speeds(self) -> tuple[float, ...]:
        """Parts of its speed, other than all of it, at which the motion is judged, from the greatest to the least."""
        if self.speed_range is None:
            return ()
        least, greatest = self.speed_range
        count = math.ceil((1.0 / least - 1.0 / greatest) / SPEED_STEP - 1e-9) + 1
        grid = 1.0 / np.linspace(1.0 / greatest, 1.0 / least, count)
        return tuple(speed for speed in (round(float(item), 5) for item in grid) if speed < 1.0)

    @property
    def is_given(self) -> bool:
        """Whether the path alone says where the tray is: it has no freedom beside its way along it."""
        return not (self.tilt_free or self.leaves_path)

    @property
    def leaves_path(self) -> bool:
        """Whether the tray may be beside the path, or turned otherwise than it."""
        return self.yaw_free or self.corridor is not None

    def on_path(self) -> MotionRules:
        """The same with place and yaw as the path has them."""
        return replace(self, corridor=None, corridor_shares=(), yaw_free=False, via=())

    def without_freedom(self) -> MotionRules:
        """The same on the path itself, level."""
        return replace(self.on_path(), tilt_free=False)

    @property
    def without_flow(self) -> MotionRules:
        """The same with heights of second order where they are those of the nonlinear flow."""
        orders = {"slosh_height": self.slosh_height, "residual_height": self.residual_height}
        by_flow = [name for name, order in orders.items() if order == "nonlinear"]
        return replace(self, **dict.fromkeys(by_flow, "second order")) if by_flow else self

    @property
    def longest(self) -> float:
        """What the motion may take, s."""
        return self.max_duration if self.duration is None else self.duration


@dataclass(frozen=True, slots=True)
class ApproachRules:
    """How the arm gets from where it is to the start of the motion.

    Attributes:
        start: (n,) joint positions it comes from, rad.
        loaded: whether the cargo is on the tray already.
        max_speed: (n,) limits that it is judged by, rad/s.
        max_acceleration: (n,) likewise, rad/s^2.
        max_jerk: (n,) likewise, rad/s^3.
        speed_scale: part of `max_speed` that it is planned with, above 0 and at most 1.
        acceleration_scale: likewise, of `max_acceleration`.
    """

    start: np.ndarray
    loaded: bool
    max_speed: np.ndarray
    max_acceleration: np.ndarray
    max_jerk: np.ndarray
    speed_scale: float
    acceleration_scale: float


@dataclass(frozen=True, slots=True)
class PlanningOptions:
    """How to look for it: cost weights k (cost is t_e + sum k mean(u^2)), grid, linear solver, times (s), starts.

    A weight that is None follows from the duration (`transcription.weights`).
    """

    path_jerk_weight: float | None
    tilt_jerk_weight: float | None
    intervals: int
    linear_solver: str
    max_iterations: int
    max_solve_time: float
    max_plan_time: float
    starts: int
    seed: int


class Origin(Protocol):
    """The scenario that a scene was read from, which its reader knows; equal to another one that says the same."""

    @property
    def table(self) -> dict[str, Any]:
        """Its keys and values as in a file that needs no other; the caller's own."""
        ...

    def changed(self, changes: Mapping[str, object]) -> Scene:
        """See `Scene.changed`."""
        ...

    def text(self) -> str:
        """As TOML."""
        ...


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Scene:
    """One planning task, complete. Scenes are equal that were read from equal tables and have equal constraints.

    A copy by `dataclasses.replace` is for the functions that compute with it: it equals itself alone, and is neither
    planned nor saved, for its parts are not what its origin says. `changed` makes another scene.

    Attributes:
        name: short name, from the file or its key `name`.
        fidelity: which physics: the report's equations or the whole wrench.
        robot: the arm with its limits.
        tray: on the flange.
        cargo: the objects on the tray.
        path: of the tray.
        motion: what the motion must keep to.
        planning: how it is looked for.
        output_rate: rate of the exported samples, Hz.
        gravity: m/s^2.
        slosh_modes: modes of a liquid in each direction that are judged and recorded.
        origin: the scenario that it was read from, files already read in.
        approach: how the arm gets to the start, or None where the scenario has no [approach].
        start_near: (n,) rad, what the scenario says of where the arm comes from: the start of the approach, else the
            robot's `home` if it is given there, else None. The inverse kinematics prefers the branch nearest to it.
        obstacles: what stands around the arm.
        regions: boxes that tray and cargo stay in.
        initial_state: how arm and tray move when the motion begins; None where they stand still.
        controller: how the joints follow their command; None where they do what they are asked for.
        tracking: how late each joint may be besides; None where that is certain.
        as_read: whether it is the very scene that was read; a copy by `dataclasses.replace` is not.
        constraints: limits given from Python, beside those of the scenario (`with_constraints`).
        unjudged: limits of the same kind that a plan was saved with and that are not at hand; no verdict holds without.
    """

    name: str
    fidelity: Fidelity
    robot: Robot
    tray: Tray
    cargo: tuple[Cargo, ...]
    path: Path
    motion: MotionRules
    planning: PlanningOptions
    output_rate: float
    gravity: float
    slosh_modes: int
    origin: Origin = field(repr=False)
    approach: ApproachRules | None = None
    start_near: np.ndarray | None = None
    obstacles: tuple[Obstacle, ...] = ()
    controller: Controller | None = None
    tracking: Tracking | None = None
    regions: tuple[Region, ...] = ()
    initial_state: InitialState | None = None
    constraints: tuple[Limit, ...] = ()
    unjudged: tuple[LimitRecord, ...] = ()
    as_read: bool = field(default=False, init=False, repr=False)

    def __repr__(self) -> str:
        return f"<Scene {self.name}: {self.robot.name}, {', '.join(item.name for item in self.cargo) or 'no cargo'}>"

    def __eq__(self, other: object) -> bool:
        if self is other or not isinstance(other, Scene):
            return self is other
        same = self.constraints == other.constraints and self.unjudged == other.unjudged
        return same and self.as_read and other.as_read and self.origin == other.origin

    def __hash__(self) -> int:
        return hash(self.name)

    def marked_as_read(self) -> Scene:
        """The scene itself, which its reader has just made."""
        object.__setattr__(self, "as_read", True)
        return self

    @property
    def source(self) -> dict[str, Any]:
        """The scenario as a plain table, as its file says it and with the files it names read in; the caller's own."""
        return self.origin.table

    def changed(self, changes: Mapping[str, object]) -> Scene:
        """The scene of the scenario with other values, checked like a file.

        Args:
            changes: dotted key -> value as in the file (with a unit, or in SI units), a table of keys or one of the
                classes of `ns.Scenario`; None for the default, or to remove an object. Objects go by their name or by
                their number from 0: "motion.tilt", "cargo.c1.friction", "obstacle.0.clearance"; "cargo.*.friction"
                is every object that states the key, or all where none does. A table under a new name is a new object:
                "cargo.c5". Files are
                looked up in the working folder.

        Raises:
            ScenarioError: a key is unknown, an object is not there, or the scenario describes no possible task.
        """
        return self.require_as_read().origin.changed(changes).limited_as(self)

    def save(self, file: str | FilePath) -> None:
        """Write the scenario as TOML that needs no other file, whole or not at all; reading it gives an equal scene.

        Raises:
            ScenarioError: the scene is a changed copy.
            PlanFolderError: the file cannot be written.
        """
        atomic_text(file, self.text())

    def text(self) -> str:
        """What `save` writes; raises likewise."""
        return self.require_as_read().origin.text()

    def require_as_read(self) -> Scene:
        """The scene itself.

        Raises:
            ScenarioError: its parts are not what was read.
        """
        if not self.as_read:
            raise ScenarioError(
                f"{self.name}: this scene is a copy with other parts than its scenario says, as dataclasses.replace "
                'makes it; use scene.changed({"cargo.c1.friction": 0.4}), which is checked like a file'
            )
        return self

    def with_constraints(self, constraints: Iterable[Limit], unjudged: Iterable[LimitRecord] = ()) -> Scene:
        """The scene with limits beside those of its scenario, in the place of those it has; the objects know theirs."""
        limits = tuple(constraints)
        named = [(limit, limit.named(self)) for limit in limits if limit.is_of_objects]
        cargo = tuple(
            replace(item, constraints=tuple(limit for limit, names in named if item.name in names))
            if named or item.constraints
            else item
            for item in self.cargo
        )
        made = replace(self, cargo=cargo, constraints=limits, unjudged=tuple(unjudged))
        return made.marked_as_read() if self.as_read else made

    def limited_as(self, other: Scene) -> Scene:
        """The scene with the limits another one has beside its scenario; one read from a changed table has none."""
        if not (other.constraints or other.unjudged):
            return self
        return self.with_constraints(other.constraints, other.unjudged)

    @property
    def has_surroundings(self) -> bool:
        """Whether there is anything that arm, tray or cargo keep away from beside themselves: obstacles, or regions."""
        return bool(self.obstacles or self.regions)

    @property
    def leaves_time_alone(self) -> bool:
        """Whether the path fixes every pose of the tray and every joint of the arm, and the motion is free in time."""
        by_path = self.path.joint_curve is not None or len(self.robot.joints) <= 6
        return self.motion.is_given and by_path

    @property
    def stays_level(self) -> bool:
        """Whether the tray is level all the way: it may not tilt, and no path of the joints leans it."""
        return not self.motion.tilt_free and self.path.joint_curve is None

    @property
    def keeps_distances(self) -> bool:
        """Whether any bodies are judged for their distance: to what is around, or of the arm to itself and its load."""
        return self.has_surroundings or self.robot.self_collision

    @property
    def standing(self) -> tuple[Cargo, ...]:
        """The objects that stand on the tray itself, and not in another one."""
        return tuple(item for item in self.cargo if not item.carrier)

    @property
    def fewer_modes(self) -> int | None:
        """Modes of each liquid in each direction where the full model has more; None where not, or without liquids."""
        fewer = self.slosh_modes < FULL_MODES and any(item.filling for item in self.cargo)
        return self.slosh_modes if fewer else None

    @property
    def planned_modes(self) -> int:
        """Modes in each direction with which a liquid joins a problem where the judge objects; it may get more."""
        return self.slosh_modes if self.fidelity == "deliverable" else min(self.slosh_modes, _PLANNED_MODES)

    @property
    def path_length(self) -> float:
        """Length of the path, m: the tray centre's, or that of its corners about it where that is longer."""
        return path_length_of(self.path, self.tray)

    def with_one_mode(self) -> Scene:
        """The scene with one mode of each liquid in each direction, with which a search begins."""
        cargo = tuple(with_modes(item, 1) for item in self.cargo)
        same = self.slosh_modes == 1 and all(a is b for a, b in zip(cargo, self.cargo, strict=True))
        return self if same else replace(self, cargo=cargo, slosh_modes=1)


def path_length_of(path: Path, tray: Tray) -> float:
    """`Scene.path_length` of a path and a tray.

    Of a path of the joints on which the tray hardly moves that of a point at a lever arm from them.
    """
    s, corner = np.linspace(0.0, 1.0, 101), float(np.hypot(*tray.size)) / 2
    if path.joint_curve is None:
        return max(path.length, float(np.ptp(path.at(s)[:, 3])) * corner)
    rotations = path.joint_curve.poses(path.joint_curve.pieces.breaks)[1]
    turn = float(np.sum(angles_between(rotations[:-1], rotations[1:])))
    joints = float(np.sum(np.abs(np.diff(path.joint_curve.joints(s), axis=0))))
    return max(path.length, turn * corner, _LEAST_LEVER * joints)
