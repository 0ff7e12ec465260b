"""The generated references are complete: what the package has, the pages have."""

from __future__ import annotations

from typing import Any

import typer
from nospill_docs import api, tables
from nospill_docs.blocks import DOCS, blocks

import nospill
from nospill.cli import app
from nospill.export import EXPORTERS
from nospill.laws.constraints import CONSTRAINTS
from nospill.robots.description.catalog import robot_table
from nospill.scene.containers import CONTAINERS
from nospill.scene.liquids import LIQUIDS


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
        part = page[page.index(f"\n### nospill {name}\n") :].split("\n### ", 2)[1]
        for item in command.params:
            if "--help" not in item.opts and item.param_type_name == "option":
                assert all(word in part for word in item.opts), (name, item.opts)


def test_the_python_page_has_every_public_name() -> None:
    named = [name for block in blocks(DOCS / "reference" / "python.md") for name in block.words]
    assert len(named) == len(set(named))
    assert {f"nospill.{name}" for name in dir(nospill)} <= set(named)


def test_a_name_of_the_python_page_leads_to_its_file_and_to_its_directive() -> None:
    entry = api.names_table("nospill.plan")
    assert entry.startswith("- [`nospill.plan`](../../src/nospill/planning/planner.py) `(scene, *, constraints=None")
    assert api.directives("nospill.Plan") == ".. autoclass:: nospill.Plan\n   :members:\n\n"
    assert api.directives("nospill.ScenarioError", "nospill.plan").count("autoexception") == 1
