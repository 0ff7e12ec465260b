"""The command: what it refuses before any server starts."""

from __future__ import annotations

import builtins
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from nospill.cli import app


def run(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, ["studio", *arguments])
    return result.exit_code, result.stderr


def test_a_wrong_scenario_is_refused_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "bad.toml"
    file.write_text("[tray]\nfriction = -1\n")
    code, errors = run(str(file), "--no-browser")
    assert code == 2 and errors.count("\n") == 1 and "bad.toml" in errors
    code, errors = run("no-such-thing")
    assert code == 2 and "no such file" in errors


@pytest.mark.parametrize("host", ["203.0.113.7", "no such host"])
def test_an_address_of_another_machine_is_refused(host: str) -> None:
    pytest.importorskip("viser", reason="viser is not installed")
    code, errors = run("--no-browser", "--port", "0", "--host", host)
    assert code == 2 and errors.startswith(f'host "{host}" cannot be listened on') and errors.count("\n") == 1


def test_without_viser_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *rest: Any, **named: Any) -> Any:
        if name == "viser":
            raise ImportError(name)
        return real(name, *rest, **named)

    monkeypatch.setattr(builtins, "__import__", without)
    code, errors = run("--no-browser")
    assert code == 2 and "pip install" in errors and "nospill[view]" in errors
