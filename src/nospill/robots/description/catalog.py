"""The arms nospill knows: one URDF and one TOML file each in `robots/data`, and one line in the table below."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields, replace
from importlib import resources
from typing import Any

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.suggestions import nearest
from nospill.errors import ScenarioError
from nospill.robots.description.urdf import NO_LOCKS, NO_TURN, WORLD, BasePose, read_arm
from nospill.robots.robot import Braking, LinkCapsule, LinkMesh, PackagedMeshes, Robot
from nospill.robots.tracking import known_tracking

ROBOTS: dict[str, str] = {
    "comau-smart-six": "comau-smart-six",
    "comau-racer-5-080": "comau-racer-5-080",
    "ur5e": "ur5e",
    "ur10e": "ur10e",
    "franka-fr3": "franka-fr3",
    "kuka-kr6-r900": "kuka-kr6-r900",
    "abb-irb1200-5-90": "abb-irb1200-5-90",
}
"""Name in a scenario -> stem of the two data files."""


def load_robot(name: str) -> Robot:
    """Return an arm of the catalogue.

    Args:
        name: a key of `ROBOTS`.

    Returns:
        The arm; its arrays are read-only.

    Raises:
        ScenarioError: no arm has that name; the message lists the names and the nearest one.
    """
    if name not in ROBOTS:
        near = nearest(name, ROBOTS, likeness=0.5)
        hint = f"; did you mean {near!r}?" if near else ""
        raise ScenarioError(f"robot model {name!r} is not in the catalogue (known: {', '.join(sorted(ROBOTS))}){hint}")
    folder = resources.files("nospill.robots") / "data"
    facts = tomllib.loads((folder / f"{ROBOTS[name]}.toml").read_text(encoding="utf-8"))
    return Robot(
        name=name,
        title=facts["title"],
        urdf=(folder / f"{ROBOTS[name]}.urdf").read_text(encoding="utf-8"),
        joints=tuple(facts["joints"]),
        tip=facts["tip"],
        lower=read_only(np.radians(facts["lower_deg"])),
        upper=read_only(np.radians(facts["upper_deg"])),
        max_speed=read_only(np.radians(facts["max_speed_deg_s"])),
        max_acceleration=_optional(facts.get("max_acceleration_rad_s2")),
        max_jerk=_optional(facts.get("max_jerk_rad_s3")),
        max_torque=_optional(facts.get("max_torque_nm")),
        inertias_known=bool(facts.get("inertias_known", False)),
        home=read_only(np.radians(facts["home_deg"])),
        payload=facts.get("payload_kg"),
        reach=facts.get("reach_m"),
        sources=dict(facts["sources"]),
        not_known=tuple(facts["not_known"]),
        base_frame=facts.get("base_frame", ""),
        controller_base_turn=math.radians(facts["controller_base_turn_deg"]) if "base_frame" in facts else None,
        capsules=tuple(
            LinkCapsule(item["link"], tuple(map(float, item["from"])), tuple(map(float, item["to"])), item["radius"])
            for item in facts["capsules"]
        ),
        meshes=_packaged(facts["meshes"]) if "meshes" in facts else None,
        braking=_braking(facts["braking"]) if "braking" in facts else None,
        interfaces=tuple(facts["interfaces"]) if "interfaces" in facts else None,
        tracking=tuple(map(known_tracking, facts.get("tracking", ()))),
    )


def moved_robot(
    robot: Robot,
    *,
    tip: str | None = None,
    tip_rpy: Sequence[float] = NO_TURN,
    base: BasePose = WORLD,
    locked: Mapping[str, object] = NO_LOCKS,
) -> Robot:
    """Return an arm of the catalogue with another base pose, flange frame or joints that stand still.

    Args:
        robot: the arm.
        tip: another frame of its URDF, or None.
        tip_rpy: turn of the flange against that, as for `read_arm`.
        base: pose of its root in the world.
        locked: joint -> angle at which it stands still ("30 deg", rad).

    Raises:
        ScenarioError: as for `read_arm`.
    """
    if not (base.moved() or locked or any(tip_rpy) or (tip is not None and tip != robot.tip)):
        return robot
    arm = read_arm(robot.urdf, tip=tip or robot.tip, tip_rpy=tip_rpy, base=base, locked=locked)
    kept = [robot.joints.index(name) for name in arm.joints]

    def of_kept(values: np.ndarray | None) -> np.ndarray | None:
        return None if values is None else read_only(values[kept])

    return replace(
        robot,
        urdf=arm.urdf,
        joints=arm.joints,
        tip=arm.tip,
        lower=read_only(robot.lower[kept]),
        upper=read_only(robot.upper[kept]),
        max_speed=read_only(robot.max_speed[kept]),
        max_acceleration=of_kept(robot.max_acceleration),
        max_jerk=of_kept(robot.max_jerk),
        max_torque=of_kept(robot.max_torque),
        home=of_kept(robot.home),
        braking=_braking_of(robot.braking, kept),
        notes=(*robot.notes, *arm.notes),
        # limits and masses are the catalogue's, not the description's
        doubts=tuple(doubt for doubt in arm.doubts if doubt.about == "tip"),
    )


def robot_table() -> list[dict[str, Any]]:
    """Return one plain (JSON-ready) row per arm of the catalogue, for `nospill robots`.

    Returns:
        Rows with the keys name, title, joint_count, joints, tip, reach_m, payload_kg, lower_deg, upper_deg,
        max_speed_deg_s, braking_deceleration_rad_s2, braking_offset_rad_s, max_acceleration_rad_s2, max_jerk_rad_s3,
        max_torque_nm (None where nobody states it), inertias_known, home_deg, base_frame, interfaces, tracking,
        sources, not_known.
    """
    return [_row(load_robot(name)) for name in ROBOTS]


def _row(robot: Robot) -> dict[str, Any]:
    return {
        "name": robot.name,
        "title": robot.title,
        "joint_count": len(robot.joints),
        "joints": list(robot.joints),
        "tip": robot.tip,
        "reach_m": robot.reach,
        "payload_kg": robot.payload,
        "lower_deg": _degrees(robot.lower),
        "upper_deg": _degrees(robot.upper),
        "max_speed_deg_s": _degrees(robot.max_speed),
        "braking_deceleration_rad_s2": None if robot.braking is None else robot.braking.deceleration.tolist(),
        "braking_offset_rad_s": None if robot.braking is None else robot.braking.offset.tolist(),
        "max_acceleration_rad_s2": None if robot.max_acceleration is None else robot.max_acceleration.tolist(),
        "max_jerk_rad_s3": None if robot.max_jerk is None else robot.max_jerk.tolist(),
        "max_torque_nm": None if robot.max_torque is None else robot.max_torque.tolist(),
        "inertias_known": robot.inertias_known,
        "home_deg": None if robot.home is None else _degrees(robot.home),
        "base_frame": robot.base_frame,
        "interfaces": list(robot.interfaces or ()),
        "tracking": [
            {
                "by": item.by,
                "late_ms": [1e3 * late for late in item.late],
                "between_known": item.between_known,
                "source": item.source,
            }
            for item in robot.tracking
        ],
        "sources": dict(robot.sources),
        "not_known": list(robot.not_known),
    }


def _braking(table: Mapping[str, Any]) -> Braking:
    keys = ("lower_rad", "upper_rad", "deceleration_rad_s2", "offset_rad_s")
    lower, upper, deceleration, offset = (read_only(table[key]) for key in keys)
    return Braking(lower, upper, deceleration, offset)


def _braking_of(braking: Braking | None, kept: Sequence[int]) -> Braking | None:
    if braking is None:
        return None
    per_joint = [part.name for part in fields(Braking) if part.default is MISSING]
    return replace(braking, **{name: read_only(getattr(braking, name)[kept]) for name in per_joint})


def _packaged(table: Mapping[str, Any]) -> PackagedMeshes:
    links = [
        LinkMesh(
            item["link"],
            item["file"],
            tuple(map(float, item.get("at", (0, 0, 0)))),
            tuple(map(math.radians, item.get("rpy_deg", (0, 0, 0)))),
        )
        for item in table["links"]
    ]
    return PackagedMeshes(table["package"], table["folder"], tuple(links))


def _degrees(radians: np.ndarray) -> list[float]:
    # twelve digits hide the rounding of deg -> rad -> deg
    return [float(f"{value:.12g}") for value in np.degrees(radians)]


def _optional(values: Sequence[float] | None) -> np.ndarray | None:
    return None if values is None else read_only(values)
