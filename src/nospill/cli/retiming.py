"""retime: the fastest certified timing of a path of the joints that another program made."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nospill.cli.planning import print_plan
from nospill.cli.progress import LOADING, PLANNING_STEPS, ProgressLine
from nospill.cli.reporting import one_line
from nospill.cli.run_options import PlanOutput
from nospill.cli.tables import say
from nospill.errors import NoSolutionError, ScenarioError


def retime(
    motion: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Joint positions: CSV, arrays, JointTrajectory as YAML, JSON or bag, plan folder. Times are left out.",
        ),
    ],
    scenario: Annotated[
        str, typer.Option("--scenario", metavar="S", help="Arm, tray, cargo and limits: a file or an example.")
    ],
    output: PlanOutput = None,
    join: Annotated[
        str | None,
        typer.Option(
            metavar="HOW",
            help="Corners between points: rounded, stops, or a spline through them.",
            show_default="rounded",
        ),
    ] = None,
    joint_tolerance: Annotated[
        str | None,
        typer.Option(
            metavar="ANGLE", help="How far a rounded corner is from the points, of a joint.", show_default="1 deg"
        ),
    ] = None,
    tray_tolerance: Annotated[
        str | None, typer.Option(metavar="LENGTH", help="The same of the tray's centre.", show_default="5 mm")
    ] = None,
    freedom: Annotated[
        str | None,
        typer.Option(
            metavar="LENGTH",
            help="How far the tray may leave its way: the fastest motion near it, level or tilting as S says.",
            show_default="keep the joints",
        ),
    ] = None,
) -> int:
    """Time a path of the joints anew: as fast as arm, liquids and objects allow, and certified.

    The path of the scenario is replaced; the tray leans as the joints say. Exit code 0 only if certified.
    """
    with ProgressLine(PLANNING_STEPS) as progress:
        from nospill.core.files import require_replaceable
        from nospill.planning.retiming import retimed_scene
        from nospill.plans.loading import require_no_own_limits
        from nospill.plans.names import is_plan_folder
        from nospill.scenario import read_scenario

        if output is not None:
            require_replaceable(output, replaceable=is_plan_folder)
        require_no_own_limits(scenario)
        stated = {"join": join, "joint_tolerance": joint_tolerance, "tray_tolerance": tray_tolerance}
        keys = {key: value for key, value in stated.items() if value is not None}
        scene = retimed_scene(motion, read_scenario(scenario), freedom=freedom, **keys)
        for note in scene.path.notes:
            say(f"path: {one_line(note)}")
        progress.say(LOADING)
        from nospill.planning.planner import plan

        try:
            found = plan(scene, progress=progress.show).with_second_looks()
        except (NoSolutionError, ScenarioError) as error:
            raise type(error)(f"{motion}: {error}", error.reason) from error
        if output is not None:
            found.save(output)
    print_plan(found, output)
    if not found.certificate.ok:
        say(one_line(found.message))
    return 0 if found.certificate.ok else 1
