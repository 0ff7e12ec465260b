"""Interpreted functions that the tests keep between runs: built once, the same numbers, and not where one compiles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import pytest

from nospill.compiled import codegen
from tests import hasty


@pytest.fixture
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(hasty, "COMPILED", tmp_path)
    for name, of_the_package in zip(("functions", "read_tape"), hasty.OF_THE_PACKAGE, strict=True):
        monkeypatch.setattr(codegen, name, of_the_package)  # and not what the session keeps
    hasty.keep_interpreted_functions(monkeypatch)
    return tmp_path / "interpreted"


def made(built: list[str], kind: str = "object") -> tuple[float, Any]:
    """A function of a kind at (2, 3) and its data; a build adds to the list."""

    def build() -> tuple[dict[str, Any], Any]:
        built.append(kind)
        x, y = ca.SX.sym("x", 1), ca.SX.sym("y", 1)
        return {"own": ca.Function("own", [x, y], [ca.sin(x) * y + 0.1])}, {"rows": (1, 2)}

    functions, data, compiled = codegen.functions(kind, "kept by tests", build, of_columns={"own": (1,)})
    assert not compiled
    return float(ca.DM(functions["own"](ca.DM.ones(1, 16) * 2.0, 3.0))[0]), data


def test_a_function_is_built_once_and_is_the_same_when_read(own_folder: Path) -> None:
    built: list[str] = []
    first, second = made(built), made(built)
    assert first == second == (pytest.approx(ca.sin(2.0) * 3.0 + 0.1, abs=1e-15), {"rows": (1, 2)})
    assert built == ["object"]


def test_a_damaged_file_is_as_good_as_none(own_folder: Path) -> None:
    built: list[str] = []
    made(built)
    (file,) = own_folder.rglob("object-*")
    file.write_bytes(file.read_bytes()[:40])
    assert made(built) == made(built)
    assert built == ["object", "object"]


def test_what_another_state_of_the_source_left_is_removed(own_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    built: list[str] = []
    made(built)
    monkeypatch.setattr(hasty, "source_digest", lambda: "another" * 8)
    monkeypatch.setattr(codegen, "functions", hasty.OF_THE_PACKAGE[0])
    hasty.keep_interpreted_functions(monkeypatch)
    assert not list(own_folder.rglob("object-*"))
    made(built)
    assert built == ["object", "object"]


def test_without_compilation_every_function_is_built(own_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NOSPILL_COMPILE", "off")
    built: list[str] = []
    codegen.functions("object", "kept by tests", lambda: (built.append("built") or {}, None))
    assert built == ["built"] and not list(own_folder.rglob("object-*"))
