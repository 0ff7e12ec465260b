"""The command line called in this process."""

from __future__ import annotations

from typer.testing import CliRunner, Result

from nospill.cli import app


def nospill(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments), catch_exceptions=False, prog_name="nospill")
