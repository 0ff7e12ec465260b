"""The keys of a scenario file, their types and bounds: what pydantic checks and what the JSON schema says."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field

from nospill.core.arrays import read_only
from nospill.robots.tool import Tool
from nospill.scenario.approach_entry import ApproachTable
from nospill.scenario.arrays import MOST_OBJECTS
from nospill.scenario.cargo_entries import CargoEntry, CargoTable
from nospill.scenario.controller_entry import ControllerTable
from nospill.scenario.fields import ANGLE, SIDE, Angle, Friction, Measured, Name, Reserve, Vector
from nospill.scenario.initial_state_entry import InitialStateTable
from nospill.scenario.leg_entry import MOST_LEGS, LegTable
from nospill.scenario.obstacle_entries import MOST_OBSTACLES, ObstacleEntry, ObstacleTable
from nospill.scenario.path_entries import PathEntry
from nospill.scenario.robot_entry import RobotTable
from nospill.scenario.tables import Given, OptionalQuantities, OptionalQuantity, Quantities, Quantity, Table, default
from nospill.scenario.tracking_entry import ToleranceTable
from nospill.scene.heights import HeightOrder
from nospill.scene.scene import FULL_MODES, EndCondition, Fidelity
from nospill.scene.tray import Tray

SHORTEST_DURATION = 0.1
"""s; least value of max_duration, twice the shortest motion that is considered."""

DEFAULT_JERK = 2000.0
"""m/s^3; of the tray along its path. Arms that state a limit reach a few hundred; it only keeps the motion smooth."""


LEAST_SPEED = 0.05
"""Least part of its speed for which a motion is planned; below that it is a position, not a motion."""


class TrayTable(Table):
    """`[tray]`: the board on the flange."""

    size: Annotated[
        Quantities,
        Vector(entry=SIDE, axes=("x", "y")),
        Field(description='side lengths along x and y, for example ["335 mm", "250 mm"]'),
    ]
    friction: Annotated[Friction, Field(description="measured coefficient of friction between tray and cargo")]
    friction_reserve: Annotated[Reserve, Field(description="fraction of the friction that is kept back")] = default(0.1)
    footprint_reserve: Annotated[
        Reserve, Field(description="fraction of every footprint that is kept back: objects tip over a smaller one")
    ] = default(0.05)
    offset: Annotated[
        Quantities,
        Vector(
            entry=Measured(dimension="length", at_least=-2.0, at_most=2.0), axes=("x", "y", "z"), scalar_is_last=True
        ),
        Field(description="centre of the surface in the flange frame, or just its height along the flange's axis"),
    ] = default((0.0, 0.0, 0.0))
    rotation: Annotated[
        Quantities,
        Vector(entry=ANGLE, axes=("roll", "pitch", "yaw")),
        Field(
            description="turn of the tray on the flange about the flange's x (roll), then y (pitch), then z (yaw), for "
            "a tray on a bracket"
        ),
    ] = default((0.0, 0.0, 0.0))
    yaw_on_flange: Annotated[
        Angle, Field(description="turn of the tray about the flange's axis, after that of `rotation`")
    ] = default(0.0)
    mass: Annotated[
        Quantity,
        Measured(dimension="mass", at_least=0.0, at_most=1000.0),
        Field(description="mass of the board without its load"),
    ] = default(0.0)

    def build(self) -> Tray:
        """The tray on its flange."""
        roll, pitch, yaw = self.rotation
        tool = Tool(read_only(self.offset), yaw + self.yaw_on_flange, roll, pitch)
        return Tray(size=read_only(self.size), tool=tool, mass=self.mass)


HOLD = Measured(dimension="time", at_least=0.0, at_most=60.0)
"""How long the arm may stand still before and after a motion."""


class MotionTable(Table):
    """`[motion]`: what the motion may do."""

    tilt: Annotated[Literal["fixed", "free"], Field(description="whether the tray may pitch and roll")] = "fixed"
    max_tilt: Annotated[
        Quantity,
        Measured(dimension="angle", above=0.0, below=math.radians(60.0)),
        Field(description="bound on each tilt angle; the slosh model and the angles themselves end at 60 deg"),
    ] = default(math.radians(30.0))
    max_jerk: Annotated[
        OptionalQuantity,
        Measured(dimension="jerk", above=0.0, at_most=1e6),
        Field(
            description="bound on the jerk along the path (where it turns on the spot, of the tray's corners), "
            f"{DEFAULT_JERK:g} m/s^3 when left out"
        ),
    ] = default(None)
    path_jerk_limit: Annotated[
        OptionalQuantity,
        Measured(dimension="path_jerk", above=0.0, at_most=1e6),
        Field(description="bound on the third derivative of the path parameter, in the place of max_jerk"),
    ] = default(None)
    max_speed: Annotated[
        OptionalQuantity,
        Measured(dimension="speed", above=0.0, at_most=100.0),
        Field(description="bound on the speed of the tray's centre"),
    ] = default(None)
    max_acceleration: Annotated[
        OptionalQuantity,
        Measured(dimension="acceleration", above=0.0, at_most=1000.0),
        Field(description="bound on the acceleration of the tray's centre, gravity not counted"),
    ] = default(None)
    tilt_jerk_limit: Annotated[
        Quantity,
        Measured(dimension="angular_jerk", above=0.0, at_most=1e6),
        Field(description="bound on each tilt angle's third derivative"),
    ] = default(1000.0)
    end: Annotated[EndCondition, Field(description="terminal condition on the liquids")] = "residual"
    residual_fraction: Annotated[
        Quantity,
        Measured(dimension="ratio", above=0.0, at_most=1.0),
        Field(description="greatest surface height after the end, as a fraction of max_slosh_height"),
    ] = default(0.2)
    slosh_height: Annotated[
        HeightOrder | None,
        Field(
            description="what max_slosh_height bounds: the linear height, or, at full fidelity and in upright "
            "cylinders and boxes, that of second order, to which real crests are nearer, or the higher of that and of "
            "the nonlinear flow; when left out the last where heights after the end are of the flow, elsewhere the "
            "second where it is known, and the certificate says where not"
        ),
    ] = None
    residual_height: Annotated[
        HeightOrder | None,
        Field(
            description="what residual_fraction bounds: the linear height after the end, or, where slosh_height is "
            "not linear, that of second order or that of the nonlinear flow; when left out the last, or linear where "
            "the flow does not follow every liquid whose second order is known"
        ),
    ] = None
    duration: Annotated[
        OptionalQuantity,
        Measured(dimension="time", at_least=SHORTEST_DURATION, at_most=600.0),
        Field(description="how long the motion takes: the gentlest one of this duration in the place of the shortest"),
    ] = default(None)
    max_duration: Annotated[
        Quantity,
        Measured(dimension="time", at_least=SHORTEST_DURATION, at_most=600.0),
        Field(description="longest motion that is considered"),
    ] = default(20.0)
    speed_range: Annotated[
        OptionalQuantities,
        Vector(entry=Measured(dimension="ratio", at_least=LEAST_SPEED, at_most=1.0), axes=("least", "greatest")),
        Field(
            description='speeds at which a controller may play the motion, for example ["25 %", "100 %"]; the limits '
            "on objects hold at every one of them"
        ),
    ] = default(None)
    stop: Annotated[
        bool,
        Field(
            strict=True,
            description="whether the motion may come to rest anywhere on its path, level and as soon as the limits "
            "allow; needs [initial_state]",
        ),
    ] = False
    stoppable: Annotated[
        OptionalQuantity,
        Measured(dimension="time", at_least=SHORTEST_DURATION, at_most=600.0),
        Field(
            description="the fastest motion that can be stopped without a spill within this time at every instant, by "
            "a bound on the speed of the tray's centre that planning finds"
        ),
    ] = default(None)
    hold_before: Annotated[
        Quantity, HOLD, Field(description="how long the arm stands still before it moves, in exported files")
    ] = default(0.0)
    hold_after: Annotated[
        Quantity, HOLD, Field(description="how long the arm stands still after the end, in exported files")
    ] = default(0.0)


_JerkWeight = Annotated[
    OptionalQuantity,
    Measured(dimension="number", at_least=0.0, at_most=1.0),
    Field(
        description="weight of the mean square of the jerk, added to the duration in seconds; "
        "when left out, as much as adds some thousandths to the cost at any duration"
    ),
]


class PlanningTable(Table):
    """`[planning]`: how to look for the motion."""

    path_jerk_weight: _JerkWeight = default(None)
    tilt_jerk_weight: _JerkWeight = default(None)
    intervals: Annotated[
        int,
        Field(
            strict=True,
            ge=20,
            le=1000,
            description="fewest time intervals; long motions of liquids get more",
        ),
    ] = 100
    linear_solver: Annotated[
        Literal["auto", "ldl", "mumps"],
        Field(description="of IPOPT's steps; auto takes ldl where it can be compiled, and mumps otherwise"),
    ] = "auto"
    max_iterations: Annotated[int, Field(strict=True, ge=1, le=100_000, description="iterations of one solve")] = 1000
    max_solve_time: Annotated[
        Quantity,
        Measured(dimension="time", above=0.0, at_most=86400.0),
        Field(description="longest time that one solve may take"),
    ] = default(120.0)
    max_plan_time: Annotated[
        Quantity,
        Measured(dimension="time", above=0.0, at_most=86400.0),
        Field(description="longest time to look for a motion; why there is none may take a little more"),
    ] = default(600.0)
    starts: Annotated[
        int,
        Field(
            strict=True,
            ge=1,
            le=100,
            description="starting motions that are compared; further ones are tried while none converges",
        ),
    ] = 1
    seed: Annotated[int, Field(strict=True, ge=0, le=2**31 - 1, description="seed of the random starting points")] = 0
    slosh_modes: Annotated[
        int | None,
        Field(
            strict=True,
            ge=1,
            le=FULL_MODES,
            description="liquid modes in each direction that are judged and recorded, 20 at full fidelity and 1 at "
            "deliverable unless stated; a search begins with one and ends with up to six at full fidelity",
        ),
    ] = None


class OutputTable(Table):
    """`[output]`: what is written."""

    rate: Annotated[
        Quantity,
        Measured(dimension="frequency", at_least=10.0, at_most=20e3),
        Field(description="rate of the exported samples"),
    ] = default(500.0)


class Scenario(Table):
    """A scenario file of nospill: one planning task."""

    fidelity: Annotated[
        Fidelity, Field(description="the physics: the published equations, or the whole contact and slosh model")
    ] = "full"
    name: Annotated[Name | None, Field(description="short name of the task; the file's name when not given")] = None
    description: Annotated[str, Field(strict=True, description="one line about the task")] = ""
    robot: Annotated[RobotTable, Field(description="the arm, with the key model or urdf")]
    tray: Annotated[TrayTable, Field(description="the board, with the keys size and friction")]
    cargo: Annotated[
        Given[list[CargoEntry], Sequence[CargoTable]],
        Field(max_length=MOST_OBJECTS, description="the objects on the tray, one [[cargo]] each; none: it is empty"),
    ] = default([])
    path: Annotated[
        PathEntry, Field(description="the way the tray goes; type preset, line, arc, bspline, waypoints or free")
    ]
    obstacle: Annotated[
        Given[list[ObstacleEntry], Sequence[ObstacleTable]],
        Field(max_length=MOST_OBSTACLES, description="what stands around the arm, one [[obstacle]] each"),
    ] = default([])  # pydantic copies it and the table is frozen
    motion: Annotated[MotionTable, Field(description="the table [motion]")] = MotionTable()
    tolerance: Annotated[
        ToleranceTable | None,
        Field(description="the table [tolerance]: how far the numbers of the objects, and the joints, may be off"),
    ] = None
    approach: Annotated[
        ApproachTable | None, Field(description="the table [approach]: how the arm gets to the start")
    ] = None
    initial_state: Annotated[
        InitialStateTable | None,
        Field(description="the table [initial_state]: how arm and tray move when the motion begins"),
    ] = None
    controller: Annotated[
        ControllerTable | None,
        Field(description="the table [controller]: how late the joints follow what they are asked for"),
    ] = None
    planning: Annotated[PlanningTable, Field(description="the table [planning]")] = PlanningTable()
    output: Annotated[OutputTable, Field(description="the table [output]")] = OutputTable()
    leg: Annotated[
        Given[list[LegTable], Sequence[LegTable]],
        Field(max_length=MOST_LEGS, description="the motions of a cycle in the place of [path], one [[leg]] each"),
    ] = default([])
