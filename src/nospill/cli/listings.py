"""examples, robots, schema: what there is."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from nospill.cli.reporting import print_json
from nospill.cli.tables import print_table


def examples() -> int:
    """List the bundled examples."""
    from nospill.scenario.examples import CYCLES, EXAMPLES

    print_table(("example", "what it shows"), list(EXAMPLES.items()))
    print()
    print_table(("cycle", "what it shows"), list(CYCLES.items()))
    return 0


def robots(
    as_json: Annotated[
        bool, typer.Option("--json", help="Print everything, limits and their sources too, as JSON.")
    ] = False,
) -> int:
    """List the robots in the catalogue."""
    from nospill.robots.description.catalog import robot_table

    table = robot_table()
    if as_json:
        print_json(table)
        return 0
    known = ("acceleration_rad_s2", "jerk_rad_s3", "torque_nm")
    rows = [
        (
            *(row[key] for key in ("name", "title", "joint_count", "reach_m", "payload_kg")),
            ", ".join(key.split("_")[0] for key in known if row[f"max_{key}"] is not None) or None,
        )
        for row in table
    ]
    columns = ("robot", "what it is", "joints", "reach m", "payload kg", "limits: position, speed and")
    print_table(columns, rows, drop=("what it is", "joints", "payload kg"))
    print()
    print_table(
        ("robot", "base frame, the root of the arm"),
        [
            (row["name"], row["base_frame"] or "that of its description; compare it with the controller's")
            for row in table
        ],
    )
    print()
    print_table(
        ("robot", "interfaces, for controller.interface"),
        [(row["name"], ", ".join(row["interfaces"]) or "none known") for row in table],
    )
    print()
    known = [(row["name"], item["by"], _late(item)) for row in table for item in row["tracking"]]
    print_table(("robot", "asked by", "known to be late by"), known, drop=("asked by",))
    print()
    print_table(("robot", "not known"), [(row["name"], "; ".join(map(str, row["not_known"]))) for row in table])
    return 0


def schema(
    markdown: Annotated[bool, typer.Option("--markdown", help="Print a page with tables of all keys.")] = False,
) -> int:
    """Print the JSON schema of a scenario file."""
    from nospill.scenario import scenario_schema
    from nospill.scenario.reference import scenario_page

    if markdown:
        print(scenario_page(), end="")
    else:
        print_json(scenario_schema())
    return 0


def _late(known: dict[str, Any]) -> str:
    """How late an arm is known to be: "0.3 to 3.1 ms between joints"."""
    first, last = known["late_ms"]
    return f"{first:.3g} to {last:.3g} ms between joints" if known["between_known"] else f"{last:.3g} ms in all joints"
