"""The frozen whole: everything a plan depends on, in SI units, checked by the reader that made it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from nospill.cargo import Cargo
from nospill.paths import Path
from nospill.robots.robot import Robot
from nospill.tray import Tray

Fidelity = Literal["deliverable", "full"]
EndCondition = Literal["still", "published", "residual"]


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
    """

    tilt_free: bool
    max_tilt: float
    path_jerk_limit: float
    tilt_jerk_limit: float
    end: EndCondition
    residual_fraction: float
    max_duration: float


@dataclass(frozen=True, slots=True)
class PlanningOptions:
    """How to look for it: cost weights k (cost is t_e + sum k mean(u^2)), grid, solver, number of starts."""

    path_jerk_weight: float
    tilt_jerk_weight: float
    intervals: int
    solver: str
    max_iterations: int
    max_solve_time: float
    starts: int
    seed: int


@dataclass(frozen=True, slots=True)
class Scene:
    """One planning task, complete.

    Attributes:
        name: short name, from the file or its key `name`.
        fidelity: which physics: the report's equations or the whole wrench.
        robot, tray, cargo, path, motion, planning: the parts.
        output_rate: rate of the exported samples, Hz.
        gravity: m/s^2.
        source: the scenario as a plain table (strings and numbers as the user wrote them, files already read in), from
            which `scenario.write_scenario` writes the copy that is kept with a plan.
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
    source: dict[str, object] = field(repr=False)
