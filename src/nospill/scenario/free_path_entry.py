"""`[path] type = "free"`: where the tray is, where it is to come, and what its way between them must keep to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain, pairwise
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from nospill.core.arrays import read_only
from nospill.core.units import as_written, format_quantity
from nospill.errors import ScenarioError
from nospill.paths.path import Path, straight_line
from nospill.paths.waypoint_paths import path_through_poses, path_through_waypoints
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool
from nospill.scenario.fields import ANGLE, POINT, SIDE, Angle, Measured, Name, Point, Vector
from nospill.scenario.freedom_entries import WIDEST, WidthAlong
from nospill.scenario.path_table import CorridorTable
from nospill.scenario.place_entry import Placed, PlaceTable, resolve_place
from nospill.scenario.tables import (
    Given,
    OptionalQuantityOrList,
    Points,
    Quantities,
    Quantity,
    Table,
    Values,
    default,
    tag,
)
from nospill.scene.places import Region, Via

LEAST_FREEDOM = 0.1
"""m; how far the tray may leave a way at least where its goal is near its start."""
SAME_PLACE = 1e-6
"""m; places that are nearer to each other are the same."""
_LEAST_LEG = 0.01
"""m; least distance from a place on the way to the next."""
_PLACES = 2001
"""Places of a path at which it is looked at."""


class ViaTable(Table):
    """A place that the tray's centre passes on its way."""

    position: Annotated[Point, Field(description="the place")]
    radius: Annotated[
        Quantity,
        Measured(dimension="length", at_least=1e-3, at_most=WIDEST),
        Field(description="how near the tray's centre has to come to it"),
    ] = default(0.05)
    name: Annotated[Name | None, Field(description="what rows call it; its number when not given")] = None


class RegionTable(Table):
    """A box that tray and cargo stay in."""

    at: Annotated[Point, Field(description="its centre, in the path's frame")]
    size: Annotated[
        Quantities, Vector(entry=SIDE, axes=("x", "y", "z")), Field(description="side lengths along x, y and z")
    ]
    yaw: Annotated[Angle, Field(description="turn of the box about z")] = default(0.0)
    name: Annotated[
        Name | None, Field(description='what rows call it; "region", "region-2" and so on when not given')
    ] = None


MOST_PLACES = 5
"""Places on a way, and regions."""
_REGION_NAMES = ("region", *(f"region-{number}" for number in range(2, MOST_PLACES + 1)))


class FreePath(CorridorTable):
    """`type = "free"`: from here to there, the way between them left to the planner."""

    type: Literal["free"] = tag()
    start: Annotated[
        PlaceTable, Field(description="where the tray is at first, with the keys position and yaw, or joints")
    ]
    goal: Annotated[PlaceTable, Field(description="where it is to come, likewise")]
    via: Annotated[
        Given[tuple[ViaTable, ...], Sequence[ViaTable]],
        Field(max_length=MOST_PLACES, description="places that it passes, in this order, with position, radius, name"),
    ] = default(())
    region: Annotated[
        Given[tuple[RegionTable, ...], Sequence[RegionTable]],
        Field(
            max_length=MOST_PLACES,
            description="boxes, each of which tray and cargo stay in, with the keys at, size, yaw and name",
        ),
    ] = default(())
    corridor: Annotated[
        OptionalQuantityOrList,
        WidthAlong(),
        Field(
            description="how far the tray's centre may be from the way along which the motion is looked for, or a list "
            "of widths along it; when not given, as far as the farthest place of goal and via is from the start"
        ),
    ] = default(None)
    way: Annotated[
        Given[list[Annotated[tuple[float, ...], POINT]] | None, Points | None],
        Field(
            min_length=2,
            max_length=100,
            description="points from start to goal about which the motion is looked for, joined smoothly; "
            "the planner chooses them when not given, and the copy kept with a plan has those",
        ),
    ] = default(None)
    way_yaw: Annotated[
        Given[list[Annotated[float, ANGLE]] | None, Values | None],
        Field(
            description="yaw of the tray at each point of `way`, which then are at even parameters of the path; even "
            "between the ends when not given"
        ),
    ] = default(None)
    way_joints: Annotated[
        Given[list[Annotated[list[Annotated[float, ANGLE]], Field(min_length=7, max_length=7)]] | None, Points | None],
        Field(description="all joints of an arm of seven at each point of `way`, with `way_yaw`"),
    ] = default(None)

    def placed(self, robot: Robot, tool: Tool, *, base_is_free: bool) -> FreePath:
        """See `PathTable`."""
        ends = {"start": self.start, "goal": self.goal}
        stated = next((key for key, entry in ends.items() if entry.joints is not None), None)
        if base_is_free and stated is not None:
            raise ScenarioError(f"{stated}.joints: where the tray is then depends on base_yaw, which is free; state it")
        free = [key for key, entry in ends.items() if entry.is_free]
        if free and base_is_free:
            raise ScenarioError(f"{free[0]}.yaw and robot.base_yaw are both free; state one of them")
        if free and self.way_yaw is not None:
            raise ScenarioError(f"{free[0]}.yaw is free, and way_yaw states it; leave one of them out")
        known = {key: resolve_place(entry, key, robot, tool) for key, entry in ends.items()}
        if len(free) == 1:  # until it is chosen, the tray does not turn
            other = next(entry for key, entry in known.items() if key not in free)
            known[free[0]] = known[free[0]].model_copy(update={"yaw": other.yaw})
        return self.model_copy(update=known)

    @property
    def width(self) -> float:
        """See `PathTable`."""
        stated = super().width
        if stated is not None:
            return stated
        farthest = max(math.dist(self.start.at, place) for place in self.stated_places[1:])
        return float(np.clip(farthest, LEAST_FREEDOM, WIDEST))

    @property
    def stated_places(self) -> list[tuple[float, ...]]:
        """Start, the places between and goal, m."""
        return [self.start.at, *(item.position for item in self.via), self.goal.at]

    @property
    def regions(self) -> tuple[Region, ...]:
        """See `PathTable`."""
        return tuple(
            Region(item.name or usual, _triple(item.at), _triple(item.size), item.yaw)
            for usual, item in zip(_REGION_NAMES, self.region, strict=False)
        )

    def places_passed(self, path: Path) -> tuple[Via, ...]:
        """See `PathTable`: each at the place of the path that is nearest to it, one after the other."""
        if not self.via:
            return ()
        s = np.linspace(0.0, 1.0, _PLACES)
        points = path.at(s)[:, :3]
        gaps = np.array([np.linalg.norm(points - item.position, axis=1) for item in self.via])
        found = []
        for number, index in enumerate(_in_order(gaps)):
            entry, gap = self.via[number], float(gaps[number, index])
            name = entry.name or str(number + 1)
            if gap > entry.radius:
                near, radius = (format_quantity(value, "length", digits=3) for value in (gap, entry.radius))
                raise ScenarioError(f"way: comes within {near} of via {name}, and {radius} is asked for; leave way out")
            found.append(Via(name, _triple(entry.position), entry.radius, float(s[index])))
        return tuple(found)

    @property
    def yaw_free(self) -> bool:
        """See `PathTable`."""
        return True

    def build(self) -> Path:
        """See `PathTable`: the straight line, or the way through the stated points."""
        ends = {key: end for key, end in (("start", self.start), ("goal", self.goal)) if isinstance(end, Placed)}
        joints = {key: read_only(np.array(end.joints)) for key, end in ends.items() if end.joints is not None}
        path, notes = self._between(), chain(*[end.note(key) for key, end in ends.items()])
        return replace(path, ends=(joints.get("start"), joints.get("goal")), notes=(*path.notes, *notes))

    def _between(self) -> Path:
        start, goal = self.start, self.goal
        yaw = (start.heading, goal.heading)
        self._check_places()
        if self.way is None:
            if self.way_yaw is not None or self.way_joints is not None:
                raise ScenarioError(
                    "way_yaw and way_joints are about the points of way, which is missing; leave them out"
                )
            if self.via:
                return path_through_waypoints(self.stated_places, yaw=yaw, smoothing=0.0)
            return straight_line(start.at, goal.at, yaw=yaw)
        for name, place, point in (("start", start, self.way[0]), ("goal", goal, self.way[-1])):
            gap = math.dist(place.at, point)
            if gap > SAME_PLACE:
                shown = format_quantity(gap, "length", digits=3)
                raise ScenarioError(f"way: its end at the {name} is {shown} away from it; leave way out")
        if self.way_yaw is None:
            return path_through_waypoints(self.way, yaw=yaw, smoothing=0.0)
        self._check_way_yaw(self.way, self.way_yaw)
        poses = np.column_stack([self.way, self.way_yaw])
        return path_through_poses(poses, None if self.way_joints is None else np.array(self.way_joints))

    def _check_places(self) -> None:
        """Refuse places that coincide, or lie outside a region; names that are taken."""
        if self.start == self.goal and not self.via:
            raise ScenarioError("goal is the start, place and yaw; give another one")
        names = [item.name or str(number) for number, item in enumerate(self.via, start=1)]
        for kind, given in (("via", names), ("region", [item.name for item in self.regions])):
            doubled = next((name for name in given if given.count(name) > 1), None)
            if doubled is not None:
                raise ScenarioError(f"{kind}: the name {as_written(doubled)} is given twice; give each its own")
        named = ["start", *(f"via {as_written(name)}" for name in names), "goal"]
        places = list(zip(named, self.stated_places, strict=True))
        for (first, here), (second, there) in pairwise(places if self.via else ()):
            gap = math.dist(here, there)
            if gap < _LEAST_LEG:
                shown, least = (format_quantity(length, "length", digits=3) for length in (gap, _LEAST_LEG))
                raise ScenarioError(f"{second} is {shown} from {first}; at least {least} must be between them")
        radii = [0.0, *(item.radius for item in self.via), 0.0]
        for region in self.regions:
            for (name, place), radius in zip(places, radii, strict=True):
                outside = -region.slack(np.array(place)) - radius
                if outside > SAME_PLACE:
                    shown = format_quantity(outside, "length", digits=3)
                    raise ScenarioError(
                        f"{name} is {shown} outside of region {as_written(region.name)}; move it, or enlarge the region"
                    )

    def _check_way_yaw(self, way: Sequence[object], way_yaw: Sequence[float]) -> None:
        for key, values in (("way_yaw", way_yaw), ("way_joints", self.way_joints)):
            if values is not None and len(values) != len(way):
                raise ScenarioError(
                    f"{key} has {len(values)} entries for the {len(way)} points of way; leave all of them out"
                )
        for name, place, angle in (("start", self.start, way_yaw[0]), ("goal", self.goal, way_yaw[-1])):
            gap = abs(math.remainder(angle - place.heading, math.tau))
            if gap > SAME_PLACE:
                shown = format_quantity(gap, "angle", digits=3)
                raise ScenarioError(f"way_yaw: its end at the {name} is turned by {shown} from it; leave it out")


def _triple(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = values
    return x, y, z


def _in_order(gaps: np.ndarray) -> list[int]:
    """Column of each row (k, m) of distances, one behind the other, with the least sum of them."""
    steps = np.arange(gaps.shape[1])
    total, before = gaps[0], list[np.ndarray]()
    for row in gaps[1:]:
        # the best column so far, up to the one before each
        best = np.maximum.accumulate(np.where(total <= np.minimum.accumulate(total), steps, 0))
        before.append(np.append(0, best[:-1]))
        total = row + np.append(np.inf, total[best[:-1]])
    found = [int(np.argmin(total))]
    for back in reversed(before):
        found.append(int(back[found[-1]]))
    return found[::-1]
