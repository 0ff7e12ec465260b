"""identify: what a run teaches of liquids, joints and friction, as tables of a scenario."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.reporting import only_stderr, print_json
from nospill.cli.run_options import (
    Log,
    Measured,
    Offset,
    PlanFolder,
    Rate,
    ScenarioName,
    Topic,
    Unit,
    assigned,
    read_run,
)
from nospill.cli.tables import print_lines, print_table

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.identification.estimates import Estimate
    from nospill.identification.identified import Identified


def identify(
    log: Log,
    plan: PlanFolder = None,
    scenario: ScenarioName = None,
    measured: Measured = None,
    stayed: Annotated[
        list[str] | None,
        typer.Option("--stayed", metavar="OBJECT", help="It did not slide; may be repeated.", show_default=False),
    ] = None,
    slid: Annotated[
        list[str] | None,
        typer.Option("--slid", metavar="OBJECT", help="It slid; may be repeated.", show_default=False),
    ] = None,
    offset: Offset = None,
    unit: Unit = "rad",
    rate: Rate = None,
    topic: Topic = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE.toml", help="Write the tables here.", show_default=False),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the record as JSON and nothing else.")] = False,
) -> int:
    """Learn from a run: clock, fill, damping and gauge of measured cups, delay and lag of the joints, friction.

    Prints the tables "controller" and "tolerance" of a scenario.
    """
    from nospill.core.files import atomic_text
    from nospill.identification.identified import identified, identified_table, scenario_text
    from nospill.simulation.motion_file import read_heights

    files = assigned("--measured", measured or (), "FILE.csv")
    with only_stderr() if as_json else nullcontext():
        recorded, scene, planned = read_run(log, plan, scenario, offset or (), unit, rate, topic)
        heights = {name: read_heights(text) for name, text in files.items()}
        learnt = identified(recorded, scene, plan=planned, measured=heights, stayed=stayed or (), slid=slid or ())
        if output is not None:
            atomic_text(output, scenario_text(learnt))
    if as_json:
        print_json(identified_table(learnt))
        return 0
    print_lines(f"read: {recorded.read}")
    _print(learnt)
    print(scenario_text(learnt), end="")
    if output is not None:
        print(f"written to {output}")
    return 0


SHOWN = {"s": (1e3, "ms", 3), "m": (1e3, "mm", 2), "1": (1.0, "", 5), "rad/s": (1.0, "rad/s", 3)}
"""SI unit -> factor, unit and decimals as shown."""


def estimate_rows(estimates: Sequence[Estimate]) -> list[tuple[str, ...]]:
    """Rows of a table: number, of what, value, unit, interval."""
    rows = []
    for estimate in estimates:
        factor, unit, digits = SHOWN[estimate.unit]
        value = f"{factor * estimate.value:.{digits}f}" if estimate.identifiable else "-"
        wide = f"± {factor * estimate.half_width:.{digits}f}"
        if estimate.ends is not None:
            wide = " to ".join(f"{factor * end:.{digits}f}" for end in estimate.ends)
        wide = wide if estimate.identifiable else "not identifiable from this motion"
        rows.append((estimate.name, estimate.subject, value, unit, wide))
    return rows


def _print(learnt: Identified) -> None:
    from nospill.identification.identified import second_order_text

    estimates = [own for fit in learnt.liquids for own in fit.estimates]
    estimates += [own for fit in learnt.joints for own in (fit.delay, fit.lag)]
    if estimates:
        print_table(("number", "of", "value", "unit", "95 %"), estimate_rows(estimates), right=("value",))
        print()
    for fit in learnt.liquids:
        print_lines(f"{fit.subject}: {1e3 * fit.left:.2f} mm rms are left of the measured height")
    if learnt.joints and not learnt.of_command:
        print_lines("delays are against the joint that begins first: the clocks of plan and log are not the same")
    print_lines(*(text for text in map(second_order_text, learnt.joints) if text))
    for fit in learnt.unexplained:
        left = fit.left if fit.second is None else fit.second.left
        print_lines(
            f"{fit.joint}: {1e3 * left:.2g} mrad rms are left, more than noise: delay and lag are not all of it"
        )
    for bound in learnt.frictions:
        word = "slid: its friction is below" if bound.slid else "stayed: its friction is above"
        print_lines(f"{bound.subject} {word} {bound.friction:.3f}")
    print()
