"""The page of all keys: complete, in the reader's own words, and as it was committed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from nospill.cli import app
from nospill.scenario import scenario_schema
from nospill.scenario.reference import scenario_page, scenario_reference, sections

PAGE = Path(__file__).parents[2] / "docs" / "scenario-keys.md"
SCHEMA = scenario_schema()


def defined_keys(schema: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Every (table, key) that the schema defines, found without following a single reference."""
    for table, definition in {"Scenario": schema, **schema["$defs"]}.items():
        for key in definition.get("properties", {}):
            yield table, key


def test_every_key_of_every_table_is_explained() -> None:
    found, tables = list(sections(SCHEMA)), {"Scenario": SCHEMA, **SCHEMA["$defs"]}
    explained = set(re.findall(r"^\| `([^`]+)` \| [^|]+ \| [^|]+ \|", scenario_reference(), re.MULTILINE))
    for table, key in sorted(set(defined_keys(SCHEMA))):
        wanted = tables[table]["properties"][key]
        assert key in explained and any(section.rows.get(key) == wanted for section in found), (table, key)


def test_no_row_has_a_key_that_the_schema_has_not() -> None:
    rows = set(re.findall(r"^\| `([^`]+)` \|", scenario_reference(), re.MULTILINE))
    assert rows == {key for _, key in defined_keys(SCHEMA)}


def test_bounds_units_and_defaults_are_those_of_the_reader() -> None:
    rows = {line.split("|")[1].strip(): line for line in scenario_reference().splitlines() if line.startswith("| `")}
    assert "| 30 deg | above 0 deg, below 60 deg |" in rows["`max_tilt`"]
    assert "length (m, cm, mm, um, in, ft)" in rows["`liquid_height`"]
    assert "at least 0, below 1" in rows["`friction_reserve`"]
    assert "| `100` | at least 20, at most 1000 |" in rows["`intervals`"]
    assert "**required**" in rows["`size`"]
    assert '`"auto"`, `"ldl"`, `"mumps"`' in rows["`linear_solver`"]


def test_no_table_row_is_broken_by_a_bar() -> None:
    for table in re.split(r"\n\n", scenario_reference()):
        lines = [line for line in table.splitlines() if line.startswith("|")]
        assert len({len(re.findall(r"(?<!\\)\|", line)) for line in lines}) <= 1, table


def test_the_committed_page_is_fresh() -> None:
    refresh = "refresh it: .venv/bin/nospill schema --markdown > docs/scenario-keys.md"
    assert PAGE.read_text(encoding="utf-8") == scenario_page(), refresh


def test_the_command_prints_it() -> None:
    assert CliRunner().invoke(app, ["schema", "--markdown"]).stdout == scenario_page()
