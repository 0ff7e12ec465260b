"""design-test: the most informative test motion for damping, fill and lag."""

from __future__ import annotations

from typing import Annotated

import typer

from nospill.cli.identifying import SHOWN
from nospill.cli.planning import print_plan
from nospill.cli.run_options import PlanOutput
from nospill.cli.tables import print_lines, print_table


def design_test(
    scenario: Annotated[str, typer.Argument(metavar="SCENARIO", help="A file, or the name of an example.")],
    rest: Annotated[
        str, typer.Option("--rest", metavar="TIME", help="How long the liquids are filmed after the motion.")
    ] = "10 s",
    noise: Annotated[
        str, typer.Option("--noise", metavar="LENGTH", help="Standard deviation of a measured height.")
    ] = "0.5 mm",
    rate: Annotated[float, typer.Option("--rate", metavar="HZ", help="Measured heights a second.")] = 60.0,
    output: PlanOutput = None,
) -> int:
    """Find the most informative test motion along the path (D-optimal for damping, fill and lag), safe by certificate.

    It ends with the liquids swinging, up to the limit of their height. Exit code 3 if no motion is certified.
    """
    from nospill.core.files import require_replaceable
    from nospill.core.units import quantity
    from nospill.errors import ScenarioError
    from nospill.identification.design import Records, experiment_scene, optimal_experiment
    from nospill.plans.names import is_plan_folder
    from nospill.scenario import read_scenario

    values = {}
    for option, text, dimension in (("--rest", rest, "time"), ("--noise", noise, "length")):
        try:
            values[option] = quantity(text, dimension)
        except ScenarioError as error:
            raise ScenarioError(f"{option}: {error}") from None
        if values[option] <= 0.0:
            raise ScenarioError(f"{option} {text}: must be above zero")
    if not 5.0 <= rate <= 10_000.0:
        raise ScenarioError(f"--rate {rate:g}: 5 to 10000 are allowed")
    if output is not None:
        require_replaceable(output, replaceable=is_plan_folder)
    records = Records(rest=values["--rest"], rate=rate, height_noise=values["--noise"])
    design = optimal_experiment(experiment_scene(read_scenario(scenario)), records)
    if output is not None:
        design.plan.save(output)
        print_plan(design.plan, output)
    rows = []
    for estimate in design.expected:
        factor, unit, digits = SHOWN[estimate.unit]
        rows.append((estimate.name, estimate.subject, f"± {factor * estimate.half_width:.{digits}f}", unit))
    print_table(("number", "of", "expected 95 %", "unit"), rows, right=("expected 95 %",))
    print()
    print_lines(
        f"the motion takes {design.plan.duration:.3f} s; film {values['--rest']:g} s of rest after it",
        f"{design.tried} motions were looked at; {design.refused} that tell more are not certified",
    )
    return 0
