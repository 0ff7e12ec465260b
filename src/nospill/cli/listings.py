"""examples, robots, schema: what there is."""

from __future__ import annotations

from typing import Annotated

import typer

from nospill.cli.reporting import print_json, print_table


def examples() -> int:
    """List the bundled examples."""
    from nospill.examples import EXAMPLES

    print_table(("example", "what it shows"), [(name, text) for name, text in EXAMPLES.items()])
    return 0


def robots(
    as_json: Annotated[bool, typer.Option("--json", help="Print limits and their sources as JSON.")] = False,
) -> int:
    """List the robots in the catalogue."""
    from nospill.robots.catalog import robot_table

    table = robot_table()
    if as_json:
        print_json(table)
        return 0
    keys = ("name", "title", "reach_m", "payload_kg")
    print_table(("robot", "what it is", "reach m", "payload kg"), [[row[key] for key in keys] for row in table])
    return 0


def schema() -> int:
    """Print the JSON schema of a scenario file."""
    from nospill.scenario import scenario_schema

    print_json(scenario_schema())
    return 0
