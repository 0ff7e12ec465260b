"""slow: from a plan to a slower one, planned anew, since the same motion at a lower speed is another motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nospill.cli.planning import print_plan
from nospill.cli.progress import LOADING, PLANNING_STEPS, ProgressLine
from nospill.cli.reporting import one_line
from nospill.cli.tables import say
from nospill.errors import NoSolutionError, ScenarioError


def slow(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
    to: Annotated[str, typer.Option(metavar="SPEED", help='Part of its speed, as "50%" or 0.5.')],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="DIR", help="Write here, not beside the plan.", show_default=False),
    ] = None,
) -> int:
    """Plan the gentlest motion that takes as long as a plan at a lower speed, and certify it.

    A controller's speed override plays the same joint path in another time: liquids then swing on after the end, and a
    tray leans against an acceleration that is not there. Exit code 0 only if certified.
    """
    with ProgressLine(PLANNING_STEPS) as progress:
        from nospill.core.files import require_replaceable
        from nospill.core.units import quantity
        from nospill.plans.loading import load_plan
        from nospill.plans.names import is_plan_folder

        speed = quantity(to, "ratio")
        if not 0.0 < speed <= 1.0:
            raise ScenarioError(f"--to {to} is out of range: it must be above 0 and at most 100 %")
        target = output or folder.with_name(f"{folder.resolve().name}-{100 * speed:.3g}-percent")
        require_replaceable(target, replaceable=is_plan_folder)
        planned = load_plan(folder)
        scene = planned.scene.changed({"motion.duration": planned.duration / speed})
        progress.say(LOADING)
        from nospill.planning.planner import plan

        try:
            found = plan(scene, progress=progress.show).with_second_looks()
        except NoSolutionError as error:
            raise NoSolutionError(f"{folder}: {error}", error.reason) from error
        found.save(target)
    print_plan(found, target)
    if not found.certificate.ok:
        say(one_line(found.message))
    return 0 if found.certificate.ok else 1
