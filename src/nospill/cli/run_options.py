"""What several commands are given: settings, a plan folder to write, times, and of a run its log and its judge."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.execution.log import JointLog
    from nospill.plans.plan import Plan
    from nospill.scene.scene import Scene

Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Another value for a key of the scenario, as motion.tilt=free or cargo.c1.friction=0.4; repeatable.",
        show_default=False,
    ),
]
PlanOutput = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="DIR", help="Write the plan folder here.", show_default=False)
]
Log = Annotated[
    Path, typer.Argument(metavar="LOG", help="What the arm did: CSV of joint positions, RTDE recording, ROS bag.")
]
PlanFolder = Annotated[
    Path | None, typer.Option("--plan", metavar="DIR", help="The plan that was executed.", show_default=False)
]
ScenarioName = Annotated[
    str | None,
    typer.Option(
        "--scenario",
        metavar="SCENARIO",
        help="Without a plan: what the motion must keep to, a file or an example.",
        show_default=False,
    ),
]
Measured = Annotated[
    list[str] | None,
    typer.Option(
        "--measured",
        metavar="CUP=FILE.csv",
        help="A measured height of a cup (t_s, height_mm); may be repeated.",
        show_default=False,
    ),
]
Offset = Annotated[
    list[str] | None,
    typer.Option(
        "--offset",
        metavar="JOINT=ANGLE",
        help='Added to a joint that the log counts from another zero, as joint_6="180 deg"; may be repeated.',
        show_default=False,
    ),
]
Unit = Annotated[str, typer.Option("--unit", metavar="rad|deg", help="Of angles whose columns do not name it.")]
Rate = Annotated[
    float | None,
    typer.Option(
        "--rate", metavar="HZ", help="Rows a second, of a log without times.", show_default="500 without a header"
    ),
]
Topic = Annotated[
    str | None,
    typer.Option("--topic", metavar="NAME", help="Of a bag.", show_default="the one with the robot's joints"),
]


def read_run(
    log: Path,
    plan: Path | None,
    scenario: str | None,
    offset: Sequence[str],
    unit: str,
    rate: float | None,
    topic: str | None,
) -> tuple[JointLog, Scene, Plan | None]:
    """A log with the scene that it is judged by, and its plan if there is one.

    Raises:
        ScenarioError: neither plan nor scenario or both, an offset or a log that cannot be read.
        PlanFolderError: no plan in the folder.
    """
    from nospill.core.units import quantity
    from nospill.errors import ScenarioError
    from nospill.execution.reading import read_log
    from nospill.plans.loading import load_plan
    from nospill.scenario import read_scenario

    if (plan is None) == (scenario is None):
        raise ScenarioError("give either --plan DIR or --scenario SCENARIO: what the log is judged by")
    offsets = {name: quantity(text, "angle") for name, text in assigned("--offset", offset, '"180 deg"').items()}
    planned = None if plan is None else load_plan(plan)
    scene = read_scenario(str(scenario)) if planned is None else planned.scene
    return read_log(log, scene.robot, offsets=offsets, rate=rate, unit=unit, topic=topic), scene, planned


def assigned(option: str, given: Sequence[str], example: str) -> dict[str, str]:
    """Values given as NAME=VALUE, by name.

    Raises:
        ScenarioError: an entry without a name or a value, or a name that is given twice.
    """
    from nospill.errors import ScenarioError

    found: dict[str, str] = {}
    for entry in given:
        name, sign, value = entry.partition("=")
        if not (name and sign and value) or name in found:
            raise ScenarioError(f"{option} {entry}: one NAME={example} for each name is needed")
        found[name] = value
    return found


def seconds(text: str) -> float:
    """A time as an option gives it: text with a unit, or a number of seconds.

    Raises:
        ScenarioError: it is no time.
    """
    from nospill.core.units import number_written, quantity

    number = number_written(text)
    return quantity(text if number is None else number, "time")
