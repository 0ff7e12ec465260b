"""largest: how far one number of a scenario may go for a motion, or a cycle, that is fast enough."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.progress import ProgressLine
from nospill.cli.run_options import PlanOutput, Settings
from nospill.cli.tables import print_lines, print_table, print_verdict

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.sweeps.bounds import Bound
    from nospill.sweeps.trials import Tried


def largest(
    key: Annotated[
        str, typer.Argument(metavar="KEY", help="A number of the scenario, as cargo.c1.liquid_height or tray.friction.")
    ],
    scenario: Annotated[
        str, typer.Argument(help="A scenario file (TOML), a plan folder, or the name of a bundled example.")
    ],
    within: Annotated[str, typer.Option("--within", metavar="TIME", help='Longest duration, as "1.2 s".')],
    least: Annotated[bool, typer.Option("--least", help="Find the least value instead.")] = False,
    between: Annotated[
        tuple[str, str] | None,
        typer.Option(
            "--between",
            metavar="LOW HIGH",
            help="Search between two values.",
            show_default="from the scenario's own value on",
        ),
    ] = None,
    precision: Annotated[float, typer.Option("--precision", help="Part of the value to which it is found.")] = 0.01,
    settings: Settings = None,
    output: PlanOutput = None,
) -> int:
    """Find the largest value of a number whose motion or cycle is certified and takes at most so long."""
    with ProgressLine() as progress:
        from nospill.core.files import require_replaceable
        from nospill.planning.varied import varied
        from nospill.plans.cycle import CyclePlan
        from nospill.plans.names import holds_a_plan
        from nospill.sweeps.bounds import largest

        if output is not None:
            require_replaceable(output, replaceable=holds_a_plan)
        found = largest(
            varied(scenario, settings=settings or ()),
            key,
            within,
            least=least,
            between=None if between is None else (_value(between[0]), _value(between[1])),
            precision=precision,
            progress=lambda trial: progress.say("values", f"{trial.value}: {trial.why_not or 'does'}"),
        )
        if output is not None:
            found.plan.with_second_looks().save(output)
    _print(found)
    if output is not None:
        command = "check" if isinstance(found.plan, CyclePlan) else "view"
        print_lines(f"written to {output}", f"look: nospill {command} {output}")
    print_verdict(found.text, ok=True)
    return 0


def _value(text: str) -> float | str:
    """A number as a scenario file has it: with its unit as text, without one as a number."""
    try:
        return float(text)
    except ValueError:
        return text


def _print(found: Bound) -> None:
    rows = [
        (str(item.value), "-" if item.duration is None else f"{item.duration:.3f}", _why_not(item))
        for item in found.tried
    ]
    print_table((found.key, "duration, s", "why not"), rows, right=(found.key, "duration, s"))
    if found.slope is not None:
        each, slope = (f"1 {found.unit}", found.slope) if found.unit else ("0.01", 0.01 * found.slope)
        print_lines(f"near the answer {1e3 * slope:+.2g} ms for each {each}")


def _why_not(trial: Tried) -> str:
    return "too long" if trial.is_too_long else trial.why_not
