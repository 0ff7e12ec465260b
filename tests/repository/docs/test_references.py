"""The generated references are complete: what the package has, the pages have."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from nospill_docs import tables
from nospill_docs.scenario_reference import scenario_reference, sections

import nospill
from nospill.cli import app
from nospill.export import EXPORTERS
from nospill.laws.constraints import CONSTRAINTS
from nospill.robots.description.catalog import robot_table
from nospill.scenario import scenario_schema
from nospill.scene.containers import CONTAINERS
from nospill.scene.liquids import LIQUIDS

DOCS = Path(__file__).parents[3] / "docs"
SCHEMA = scenario_schema()


def defined_keys(schema: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Every (table, key) that the schema defines, found without following a single reference."""
    for table, definition in {"Scenario": schema, **schema["$defs"]}.items():
        for key in definition.get("properties", {}):
            yield table, key


@pytest.mark.parametrize(("table", "key"), sorted(set(defined_keys(SCHEMA))))
def test_every_key_of_every_table_is_explained(table: str, key: str) -> None:
    wanted = {"Scenario": SCHEMA, **SCHEMA["$defs"]}[table]["properties"][key]
    assert any(section.rows.get(key) == wanted for section in sections(SCHEMA))
    assert re.search(rf"^\| `{re.escape(key)}` \| [^|]+ \| [^|]+ \|", scenario_reference(), re.MULTILINE)


def test_no_row_has_a_key_that_the_schema_has_not() -> None:
    rows = set(re.findall(r"^\| `([^`]+)` \|", scenario_reference(), re.MULTILINE))
    assert rows == {key for _, key in defined_keys(SCHEMA)}


def test_bounds_units_and_defaults_are_those_of_the_reader() -> None:
    rows = {line.split("|")[1].strip(): line for line in scenario_reference().splitlines() if line.startswith("| `")}
    assert "above 0 deg, below 60 deg | 30 deg |" in rows["`max_tilt`"]
    assert "length (m, cm, mm, um, in)" in rows["`liquid_height`"]
    assert "at least 0, below 1" in rows["`friction_reserve`"]
    assert "at least 20, at most 1000 | `100`" in rows["`intervals`"]
    assert "**required**" in rows["`size`"]
    assert '`"auto"`, `"ldl"`, `"mumps"`' in rows["`linear_solver`"]


def test_no_table_row_is_broken_by_a_bar() -> None:
    for table in re.split(r"\n\n", scenario_reference()):
        lines = [line for line in table.splitlines() if line.startswith("|")]
        assert len({len(re.findall(r"(?<!\\)\|", line)) for line in lines}) <= 1, table


def test_tables_name_every_member() -> None:
    assert all(f"**{item.name}**" in tables.constraints_table() for item in CONSTRAINTS)
    assert all(item.description in tables.constraints_table().replace(r"\|", "|") for item in CONSTRAINTS)
    assert all(f"`{name}`" in tables.exporters_table() for name in EXPORTERS)
    assert all(f'`"{name}"`' in tables.shapes_table() for name in CONTAINERS)
    assert all(f'`"{name}"`' in tables.liquids_table() for name in LIQUIDS)
    page = tables.robots_page()
    for arm in robot_table():
        assert f"`{arm['name']}`" in page
        assert all(f"| `{joint}` |" in page for joint in arm["joints"])  # type: ignore[union-attr]


def test_the_command_line_is_whole() -> None:
    page = tables.command_line()
    root: Any = typer.main.get_command(app)
    for name, command in root.commands.items():
        part = page[page.index(f"\n## nospill {name}\n") :].split("\n## ", 2)[1]
        for item in command.params:
            if "--help" not in item.opts and item.param_type_name == "option":
                assert all(word in part for word in item.opts), (name, item.opts)


def test_the_python_page_has_every_public_name() -> None:
    page = (DOCS / "reference" / "python.md").read_text(encoding="utf-8")
    named = set(re.findall(r"^\.\. auto\w+:: nospill\.(?:\w+\.)*(\w+)$", page, re.MULTILINE))
    public = {"read_scenario" if name == "load" else name for name in nospill.__all__}
    assert public <= named
    assert "``nospill.load``" in page
