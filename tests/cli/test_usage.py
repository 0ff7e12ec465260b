"""Lists of what comes with the program, help, wrong usage, and what is not loaded for them."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from nospill import __version__
from nospill.cli import app
from tests.cli.commands import nospill
from tests.waiting import run_python, wait_until

GROUPS = {
    "Plan": ("plan", "examples", "robots", "schema", "studio", "retime", "slow"),
    "Look": ("view", "plot", "report", "film"),
    "Judge": ("judge", "check", "executed", "verify", "stops"),
    "Hand over": ("export",),
    "Laboratory": ("identify", "design-test", "measure", "simulate", "compare"),
    "Many": ("sweep", "largest", "layout", "margins", "cache"),
}
COMMANDS = tuple(name for names in GROUPS.values() for name in names)


def test_version() -> None:
    assert nospill("--version").stdout == f"nospill {__version__}\n"


def test_every_command_is_in_the_list() -> None:
    assert {
        command.callback.__name__.replace("_", "-") for command in app.registered_commands if command.callback
    } == set(COMMANDS)


def test_help_has_the_commands_by_what_a_user_wants() -> None:
    lines = [" ".join(re.findall(r"[\w-]+", line)) for line in nospill("--help").stdout.splitlines()]
    entries = [line if line in GROUPS else line.partition(" ")[0] for line in lines[lines.index("Plan") :]]
    shown = [entry for entry in entries if entry in {*GROUPS, *COMMANDS}]
    assert shown == [word for group, names in GROUPS.items() for word in (group, *names)]


def test_the_page_on_the_commands_has_the_same_groups() -> None:
    page = (Path(__file__).parents[2] / "docs" / "commands.md").read_text(encoding="utf-8")
    parts = {part.partition("\n")[0]: part for part in page.split("\n## ")[1:]}
    named = {group: re.findall(r"^\| `nospill ([a-z-]+)", parts[group], re.MULTILINE) for group in GROUPS}
    assert {group: tuple(dict.fromkeys(names)) for group, names in named.items()} == GROUPS


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_every_command(command: str) -> None:
    result = nospill(command, "--help")
    assert result.exit_code == 0
    assert "Usage: nospill " + command in result.stdout
    assert command in nospill("--help").stdout


@pytest.mark.parametrize(
    "arguments",
    [
        ["fly"],
        ["plan"],
        ["plan", "a", "b"],
        ["plan", "a", "--quick"],
        ["plan", "a", "-o"],
        ["check"],
        ["robots", "x"],
        [],
    ],
)
def test_wrong_usage_exits_2_without_traceback(arguments: list[str]) -> None:
    result = nospill(*arguments)
    assert result.exit_code == 2
    assert "Traceback" not in result.stderr


def test_examples_lists_every_example() -> None:
    from nospill.scenario.examples import EXAMPLES

    result = nospill("examples")
    assert result.exit_code == 0
    for name, text in EXAMPLES.items():
        assert name in result.stdout
        assert text in result.stdout


def test_robots() -> None:
    result = nospill("robots", "--json")
    assert result.exit_code == 0
    for entry in json.loads(result.stdout):
        assert entry["name"] in nospill("robots").stdout


def test_schema_is_json() -> None:
    result = nospill("schema")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["properties"]["cargo"]


def test_reader_that_goes_away_is_no_fault(tmp_path: Path) -> None:
    command = "import sys; sys.argv = ['nospill', 'schema']; from nospill.cli import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    assert process.stderr.read() == ""
    process.stderr.close()
    wait_until(lambda: process.poll() is not None, "a command without a reader ends")
    assert process.returncode == 141


def test_a_sign_that_the_encoding_lacks_ends_no_command(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "nospill", "plan", "tea\u2265.toml"],
        env={**os.environ, "PYTHONIOENCODING": "ascii:strict"},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith(("tea?.toml", "tea\\u2265.toml"))


def test_help_loads_nothing_heavy() -> None:
    script = (
        "import sys\n"
        "from typer.testing import CliRunner\n"
        "from nospill.cli import app\n"
        "assert CliRunner().invoke(app, ['--help']).exit_code == 0\n"
        "print(sorted({'numpy', 'scipy', 'casadi', 'matplotlib', 'pydantic', 'adam', 'eaik'} & set(sys.modules)))\n"
    )
    done = run_python("-c", script)
    assert done.stdout == "[]\n", done.stderr
