"""slow: from a plan to a slower one on the same way, or, where that cannot be, to another motion that takes as long."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.planning import print_plan
from nospill.cli.progress import LOADING, PLANNING_STEPS, ProgressLine
from nospill.cli.reporting import one_line
from nospill.cli.tables import print_lines, say
from nospill.errors import NoSolutionError, ScenarioError

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.plans.plan import Plan


def slow(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
    to: Annotated[str, typer.Option(metavar="SPEED", help='Part of its speed, as "50%" or 0.5.')],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="DIR", help="Write here, not beside the plan.", show_default=False),
    ] = None,
    another_way: Annotated[
        bool, typer.Option("--another-way", help="Plan the gentlest motion of that duration, on a way of its own.")
    ] = False,
) -> int:
    """Make a slower motion of a plan on the same way, and certify it.

    Tray and joints pass the poses of the plan, at other times. A controller's speed override plays them at one rate:
    liquids then swing on after the end, and a tray leans against an acceleration that is not there. Exit code 0 only if
    certified.
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
        progress.say(LOADING)
        try:
            slower_plan = _replan(planned, speed, progress) if another_way else _on_its_way(planned, speed)
        except NoSolutionError as error:
            raise NoSolutionError(f"{folder}: {error}", error.reason) from error
        slower_plan = slower_plan.with_second_looks()
        slower_plan.save(target)
    print_plan(slower_plan, target)
    print_lines(_comparison_line(planned, slower_plan))
    if not slower_plan.certificate.ok:
        say(one_line(slower_plan.message))
    return 0 if slower_plan.certificate.ok else 1


def _on_its_way(planned: Plan, speed: float) -> Plan:
    from nospill.planning.slower import slower

    try:
        return slower(planned, speed)
    except NoSolutionError as error:
        raise NoSolutionError(
            f"{error}; --another-way plans the gentlest motion that takes as long, whose poses are others"
        ) from error


def _replan(planned: Plan, speed: float, progress: ProgressLine) -> Plan:
    from nospill.planning.planner import plan

    return plan(planned.scene.changed({"motion.duration": planned.duration / speed}), progress=progress.show)


def _comparison_line(planned: Plan, found: Plan) -> str:
    """At which speed it is, and how far its poses are from the planned ones, in one line."""
    from nospill.planning.slower import apart

    gaps, speed = apart(planned, found), 100 * planned.duration / found.duration
    angles = f"{math.degrees(gaps.angle):.2f} deg, of a joint {math.degrees(gaps.joints):.2f} deg"
    text = f"{speed:.3g} % of the speed; from the way of the plan at most {1e3 * gaps.distance:.2f} mm and {angles}"
    return text if gaps.is_same else f"{text}: this is another motion than the plan"
