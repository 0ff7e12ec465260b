"""retime: the fastest certified timing of a path of the joints that another program made."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.planning import print_plan
from nospill.cli.progress import LOADING, PLANNING_STEPS, ProgressLine
from nospill.cli.reporting import one_line
from nospill.cli.tables import say
from nospill.errors import NoSolutionError, ScenarioError

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.scene.scene import Scene


def retime(
    motion: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Joint positions: CSV, a JointTrajectory as YAML or JSON, or a plan folder. Times are left out.",
        ),
    ],
    scenario: Annotated[
        str, typer.Option("--scenario", metavar="S", help="Arm, tray, cargo and limits: a file or an example.")
    ],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="DIR", help="Write the plan folder here.", show_default=False),
    ] = None,
    join: Annotated[
        str, typer.Option(metavar="HOW", help="Corners between points: rounded, stops, or a spline through them.")
    ] = "rounded",
    joint_tolerance: Annotated[
        str, typer.Option(metavar="ANGLE", help="How far a rounded corner is from the points, of a joint.")
    ] = "1 deg",
    tray_tolerance: Annotated[str, typer.Option(metavar="LENGTH", help="The same of the tray's centre.")] = "5 mm",
) -> int:
    """Time a path of the joints anew: as fast as arm, liquids and objects allow, and certified.

    The path of the scenario is replaced; the tray leans as the joints say. Exit code 0 only if certified.
    """
    with ProgressLine(PLANNING_STEPS) as progress:
        from nospill.core.files import require_replaceable
        from nospill.plans.loading import require_no_own_limits
        from nospill.plans.names import is_plan_folder
        from nospill.scenario import read_scenario

        if output is not None:
            require_replaceable(output, replaceable=is_plan_folder)
        require_no_own_limits(scenario)
        scene = _with_path(
            motion,
            read_scenario(scenario),
            join=join,
            joint_tolerance=joint_tolerance,
            tray_tolerance=tray_tolerance,
        )
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


def _with_path(motion: Path, scene: Scene, **keys: str) -> Scene:
    from nospill.planning.retiming import retimed_scene

    return retimed_scene(motion, scene, **keys)
