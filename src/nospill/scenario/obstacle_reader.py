"""From the `[[obstacle]]` entries to obstacles: each by itself, then among what else the scenario has."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nospill.core.units import as_written, format_quantity
from nospill.errors import ScenarioError
from nospill.paths.path import Path
from nospill.robots.description.urdf import base_pose
from nospill.robots.robot import Robot
from nospill.scenario.messages import entry_place
from nospill.scenario.obstacle_entries import ObstacleTable
from nospill.scenario.sentences import Fault, report
from nospill.scene.cargo import Cargo
from nospill.scene.obstacles import Obstacle
from nospill.scene.places import Region, Via

RESERVED_NAMES = ("tray",)
"""Names of bodies that are in every scenario."""


def read_obstacles(
    entries: Sequence[ObstacleTable],
    *,
    robot: Robot,
    cargo: Sequence[Cargo],
    path: Path,
    passed: Sequence[Via],
    regions: Sequence[Region],
    label: str,
) -> tuple[Obstacle, ...]:
    """The obstacles of a scenario.

    Args:
        entries: as they are in the file.
        robot: the arm, whose foot none of them may hold.
        cargo: objects, whose names are taken.
        path: of the tray's centre, whose ends none of them may hold.
        passed: places on the way, which none of them may hold either.
        regions: whose names are taken.
        label: what messages call the scenario.

    Raises:
        ScenarioError: an entry contradicts itself or the rest; names it.
    """
    obstacles: list[Obstacle] = []
    faults: list[Fault] = []
    owners = {item.name: f"cargo {as_written(item.name)}" for item in cargo} | {
        name: f"the {name}" for name in RESERVED_NAMES
    }
    owners |= {item.name: f"region {as_written(item.name)}" for item in regions}
    for index, entry in enumerate(entries):
        place = entry_place("obstacle", index, {"name": entry.name})
        if entry.name in owners:
            text = f"name {as_written(entry.name)} is already taken by {owners[entry.name]}; give every body its own"
            faults.append((f"obstacle {index + 1}", text))
        owners.setdefault(entry.name, f"obstacle {index + 1}")
        try:
            obstacle = entry.build()
        except ScenarioError as error:
            faults.append((place, str(error)))
            continue
        fault = _fault(obstacle, robot, path) or _place_in_obstacle(obstacle, passed)
        faults += [(place, fault)] if fault else []
        obstacles.append(obstacle)
    if faults:
        raise report(label, faults)
    return tuple(obstacles)


def _fault(obstacle: Obstacle, robot: Robot, path: Path) -> str | None:
    """Why an obstacle cannot stand where it does, whatever the arm does; None where nothing speaks against it."""
    foot, _ = base_pose(robot.urdf)
    depth = -obstacle.distance(foot)
    if depth > 1e-9:
        inside = f"{_point(foot)}, which is {_length(depth)} inside"
        return f"swallows the foot of the arm, {inside}; the arm must stand outside"
    ends = path.at(np.array([0.0, 1.0]))[:, :3]
    for name, end in zip(("start", "end"), ends, strict=True):
        short = obstacle.clearance - obstacle.distance(end)
        if short > 1e-9:
            gap = obstacle.distance(end)
            where = f"{_length(-gap)} inside it" if gap < 0.0 else f"{_length(gap)} from it"
            return (
                f"stands in the way of the path's {name} {_point(end)}: the tray's centre is {where} there; "
                f"the clearance {_length(obstacle.clearance)} must be kept: move the obstacle or the path"
            )
    return None


def _place_in_obstacle(obstacle: Obstacle, passed: Sequence[Via]) -> str | None:
    """Why the tray cannot pass a place on its way."""
    for item in passed:
        gap = obstacle.distance(np.array(item.position))
        if gap + item.radius < obstacle.clearance - 1e-9:
            where = f"{_length(-gap)} inside it" if gap < 0.0 else f"{_length(gap)} from it"
            return (
                f"holds via {as_written(item.name)} {_point(np.array(item.position))}: that is {where}, the tray's "
                f"centre passes it within {_length(item.radius)}, and the clearance {_length(obstacle.clearance)} must "
                "be kept: move one of them"
            )
    return None


def _point(point: np.ndarray) -> str:
    return "(" + ", ".join(format_quantity(float(value), "length", digits=4) for value in point) + ")"


def _length(length: float) -> str:
    return format_quantity(length, "length", digits=3)
