"""The keys of `[robot]`, and the arm they describe: one of the catalogue or any URDF, mounted, locked and limited."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Annotated, Any, Literal

from pydantic import Field

from nospill.core.files import MissingFileError, UnreadableError, bounded_text
from nospill.core.units import as_written
from nospill.errors import ScenarioError
from nospill.robots.description.catalog import load_robot, moved_robot
from nospill.robots.description.limits import (
    JointLimits,
    LimitChanges,
    LimitedArm,
    changed_limits,
    limits_of,
    position_and_speed_only,
    with_home,
)
from nospill.robots.description.urdf import BasePose, UrdfArm, read_arm, standalone_urdf
from nospill.robots.description.urdf_arm_limits import torque_doubt, urdf_limits
from nospill.robots.description.urdf_tree import read_tree
from nospill.robots.robot import Robot
from nospill.scenario.capsule_entry import MOST_CAPSULES, LinkCapsuleTable, fitted_capsules, with_capsules
from nospill.scenario.fields import ANGLE, FREE, JOINT_ANGLE, Angle, JointValues, Measured, Point, Vector, WordOr
from nospill.scenario.tables import Given, OptionalQuantity, OptionalQuantityOrList, Table, Values, default

_LARGEST_URDF = 10_000_000
_SOURCES = "model (an arm of the catalogue, see `nospill robots`) or urdf (a URDF file)"

_Scale = Annotated[
    OptionalQuantity,
    Measured(dimension="ratio", above=0.0, at_most=1.0),
    Field(description="factor on this limit, for example 0.8 or 80 %"),
]


def _limit(dimension: str, at_most: float) -> JointValues:
    return JointValues(entry=Measured(dimension=dimension, above=0.0, at_most=at_most))


class JointLimitsTable(Table):
    """`[robot.limits]`: joint limits in place of the robot's data; a list with one value a joint, or one for all."""

    lower: Annotated[
        OptionalQuantityOrList, JointValues(entry=JOINT_ANGLE), Field(description="lower ends of the joints")
    ] = default(None)
    upper: Annotated[
        OptionalQuantityOrList, JointValues(entry=JOINT_ANGLE), Field(description="upper ends of the joints")
    ] = default(None)
    speed: Annotated[OptionalQuantityOrList, _limit("angular_speed", 100.0), Field(description="joint speed")] = (
        default(None)
    )
    acceleration: Annotated[
        OptionalQuantityOrList, _limit("angular_acceleration", 1e4), Field(description="joint acceleration")
    ] = default(None)
    jerk: Annotated[OptionalQuantityOrList, _limit("angular_jerk", 1e7), Field(description="joint jerk")] = default(
        None
    )
    torque: Annotated[
        OptionalQuantityOrList, _limit("torque", 1e6), Field(description="joint torque at the joint's axis")
    ] = default(None)
    speed_scale: Annotated[
        OptionalQuantity,
        Measured(dimension="ratio", above=0.0, at_most=1.0),
        Field(description="factor on every limit of speed, those near the ends of the ranges too, as 0.8 or 80 %"),
    ] = default(None)
    acceleration_scale: _Scale = default(None)
    jerk_scale: _Scale = default(None)
    torque_scale: _Scale = default(None)

    def changes(self) -> LimitChanges:
        """The same as a record."""
        scales = {
            "max_speed": self.speed_scale,
            "max_acceleration": self.acceleration_scale,
            "max_jerk": self.jerk_scale,
            "max_torque": self.torque_scale,
        }
        return LimitChanges(
            lower=self.lower,
            upper=self.upper,
            max_speed=self.speed,
            max_acceleration=self.acceleration,
            max_jerk=self.jerk,
            max_torque=self.torque,
            scales={name: scale for name, scale in scales.items() if scale is not None},
        )

    def beyond_speed(self) -> str | None:
        """The first key that is given and is no limit of position or speed, or None."""
        keys = ("acceleration", "jerk", "torque", "acceleration_scale", "jerk_scale", "torque_scale")
        return next((key for key in keys if getattr(self, key) is not None), None)


class RobotTable(Table):
    """`[robot]`: the arm."""

    model: Annotated[
        str | None, Field(strict=True, description="name of an arm in the catalogue (`nospill robots`)")
    ] = None
    urdf: Annotated[
        str | None,
        Field(strict=True, description="URDF file beside the scenario file; no xacro, meshes are not needed"),
    ] = None
    urdf_text: Annotated[
        str | None, Field(strict=True, description="the text of a URDF file, as in the copy kept with a plan")
    ] = None
    tip: Annotated[
        str | None, Field(strict=True, description="frame of the flange; tool0, flange or the only end if not given")
    ] = None
    tip_rpy: Annotated[
        tuple[float, ...],
        Vector(entry=ANGLE, axes=("roll", "pitch", "yaw")),
        Field(
            description="turn of the flange against that frame about its x (roll), then y (pitch), then z (yaw), for a "
            "frame whose z axis does not point out of the flange"
        ),
    ] = default((0.0, 0.0, 0.0))
    base_position: Annotated[Point, Field(description="origin of the arm's root in the world of path and gravity")] = (
        default(
            (
                0.0,
                0.0,
                0.0,
            )
        )
    )
    base_yaw: Annotated[
        float | str,
        WordOr(word=FREE, entry=ANGLE),
        Field(description='turn of the root about the world\'s z; "free" leaves it to the planner'),
    ] = 0.0
    base_pitch: Annotated[Angle, Field(description="turn of the root about y, before the yaw")] = default(0.0)
    base_roll: Annotated[Angle, Field(description="turn of the root about x, before pitch and yaw")] = default(0.0)
    locked: Annotated[
        dict[str, Any], Field(description='joints that stand still, for example { joint_3 = "30 deg" }')
    ] = {}  # noqa: RUF012 # pydantic copies it and the table is frozen
    home: Annotated[
        Given[list[Annotated[float, JOINT_ANGLE]] | None, Values | None],
        Field(description="configuration the arm starts from, one angle for each moving joint"),
    ] = default(None)
    limits_applied: Annotated[
        Literal["all", "position and speed"],
        Field(description="all limits that are known, or only those of position and speed, as published"),
    ] = "all"
    limits: Annotated[JointLimitsTable, Field(description="the table [robot.limits]")] = JointLimitsTable()
    capsule: Annotated[
        Given[list[LinkCapsuleTable] | None, Sequence[LinkCapsuleTable] | None],
        Field(
            min_length=1,
            max_length=MOST_CAPSULES,
            description="what the links fill, for collisions, one [[robot.capsule]] each; those of the catalogue, or "
            "fitted to the URDF's collision geometry, when not given",
        ),
    ] = default(None)
    self_collision: Annotated[
        Literal["on", "off"],
        Field(description="whether the arm is kept from touching itself, the tray and the cargo, and judged for it"),
    ] = "on"

    def standalone(self, folder: FilePath, *, capsules: bool) -> dict[str, object]:
        """Keys to replace so that the table needs no other file (None: to remove); files are looked up in `folder`.

        Args:
            folder: of the scenario file.
            capsules: whether the collision geometry of a URDF is needed.

        Raises:
            ScenarioError: not exactly one robot is named, or its file cannot be read.
        """
        given = [key for key in ("model", "urdf", "urdf_text") if getattr(self, key) is not None]
        if not given:
            raise ScenarioError(f"model is missing; name {_SOURCES}")
        if len(given) > 1:
            raise ScenarioError(f"{' and '.join(given)} are both given; keep one of {_SOURCES}")
        if self.urdf is not None:
            file = folder / self.urdf
            text = _from_file(file, self.urdf)
            read = {"urdf": None, "urdf_text": standalone_urdf(text, name=file.stem)}
            return read | self._fitted(text, file.parent, capsules)
        if self.urdf_text is not None:
            text = self.urdf_text
            return {"urdf_text": standalone_urdf(text, name="robot")} | self._fitted(text, folder, capsules)
        return {}

    def build(self) -> Robot:
        """The arm; the text of its URDF is at hand, `standalone` comes first.

        Raises:
            ScenarioError: it cannot be read, or its limits contradict each other or the keys; starts with the key.
        """
        yaw = 0.0 if isinstance(self.base_yaw, str) else self.base_yaw
        base = BasePose(self.base_position, (self.base_roll, self.base_pitch, yaw))
        if self.model is not None:
            model = load_robot(self.model)
            known = moved_robot(model, tip=self.tip, tip_rpy=self.tip_rpy, base=base, locked=self.locked)
            arm = LimitedArm(known.name, known.joints, known.inertias_known)
            robot = replace(known, **self._limits(limits_of(known), arm).fields())
            if robot.braking is not None and self.limits.speed_scale is not None:
                robot = replace(robot, braking=robot.braking.scaled(self.limits.speed_scale))
        else:
            text = self.urdf_text or ""
            robot = self._own(read_arm(text, tip=self.tip, tip_rpy=self.tip_rpy, base=base, locked=self.locked))
        robot = replace(robot, self_collision=self.self_collision == "on")
        return with_home(with_capsules(robot, self.capsule, known=self.urdf_text or robot.urdf), self.home)

    def _own(self, read: UrdfArm) -> Robot:
        """The arm of a URDF."""
        arm = LimitedArm(read.name, read.joints, read.inertia_fault is None, read.inertia_fault, read.not_set)
        applied = bool(read.torque_known.any())
        limits = self._limits(urdf_limits(read), arm)
        stated = {"joint speed"} if self.limits.speed is not None else set[str]()
        stated |= {"joint position"} if self.limits.lower is not None and self.limits.upper is not None else set()
        own_torque = self.limits.torque is not None or self.limits_applied != "all"
        return Robot(
            name=read.name,
            title=f"{read.name} (own URDF)",
            urdf=read.urdf,
            joints=read.joints,
            tip=read.tip,
            payload=None,
            reach=None,
            inertias_known=applied,
            notes=read.notes,
            doubts=(
                *(doubt for doubt in read.doubts if doubt.about not in stated),
                *(() if own_torque else torque_doubt(read)),
            ),
            **limits.fields(),
        )

    def _fitted(self, text: str, folder: FilePath, needed: bool) -> dict[str, object]:
        if not needed or self.capsule is not None:
            return {}
        return fitted_capsules(text, folder, tip=self.tip, locked=self.locked)

    def _limits(self, limits: JointLimits, arm: LimitedArm) -> JointLimits:
        published, stray = self.limits_applied != "all", self.limits.beyond_speed()
        if published and stray:
            raise ScenarioError(
                f'limits.{stray} is given, but limits_applied = "{self.limits_applied}" leaves it out; '
                "drop one of the two"
            )
        changed = changed_limits(limits, self.limits.changes(), arm)
        return position_and_speed_only(changed) if published else changed


def _from_file(file: FilePath, shown: str) -> str:
    try:
        text = bounded_text(file, _LARGEST_URDF)
    except MissingFileError as error:
        place = "the path counts from the scenario file's folder"
        raise ScenarioError(f"urdf {as_written(shown)} {error}; {place}") from None
    except UnreadableError as error:
        raise ScenarioError(f"urdf {as_written(shown)} {error}") from None
    try:
        read_tree(text)
    except ScenarioError as error:
        raise ScenarioError(f"urdf {as_written(shown)}: {error}") from None
    return text
