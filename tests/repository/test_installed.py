"""What the program and its tests import is brought by the extra `test`: `make test` installs no more."""

from __future__ import annotations

import csv
import importlib.util
import os
import re
import sys
from collections.abc import Iterator
from functools import cache
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement

from tests.repository.modules import ROOT, imports, label, python_files

OWN = {"nospill", "tests", "benchmarks", "nospill_docs"}
"""Of this repository."""
DOCS = ROOT / "tests" / "repository" / "docs"
"""Tests of the pages, which `make docs` runs in an environment with the extra `docs`."""
ALONE = {
    "toppra": "compared with where it is installed; has no wheels",
    "ompl": "draws paths, which are kept",
    "rclpy": "make robots installs it for the players",
    "builtin_interfaces": "likewise",
    "sensor_msgs": "likewise",
    "trajectory_msgs": "likewise",
    "franka_sim": "make robots installs it",
}
"""What a benchmark or a test imports only where somebody has installed it, and why."""


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def own_requirements(project: dict[str, Any], extras: tuple[str, ...]) -> list[str]:
    """Requirements of the project as written, with those of its extras, and of the extras that these name."""
    table = project["project"]
    found = list(table["dependencies"])
    for extra in extras:
        for line in table["optional-dependencies"][extra]:
            wanted = Requirement(line)
            found += own_requirements(project, tuple(wanted.extras)) if wanted.name == "nospill" else [line]
    return found


def brought(lines: list[str]) -> dict[str, Distribution]:
    """Distributions that pip installs for some requirements, theirs included."""
    found: dict[str, Distribution] = {}
    seen: set[tuple[str, str]] = set()

    def add(wanted: Requirement, for_extra: str = "") -> None:
        if wanted.marker is not None and not wanted.marker.evaluate({"extra": for_extra}):
            return
        name = canonical(wanted.name)
        try:
            found.setdefault(name, distribution(wanted.name))
        except PackageNotFoundError:
            return
        for extra in ("", *sorted(wanted.extras)):
            if (name, extra) not in seen:
                seen.add((name, extra))
                for line in found[name].requires or ():
                    add(Requirement(line), extra)

    for line in lines:
        add(Requirement(line))
    return found


@pytest.fixture(scope="module")
def files_brought(project: dict[str, Any]) -> frozenset[str]:
    """Every file of the distributions that `make test` installs."""
    distributions = brought(own_requirements(project, ("test",))).values()
    return frozenset(place for one in distributions for place in places_of(one))


def places_of(one: Distribution) -> Iterator[str]:
    """Its files, by what pip has recorded: twenty thousand of them, so as texts."""
    folder = str(one.locate_file(""))
    for row in csv.reader((one.read_text("RECORD") or "").splitlines()):
        yield os.path.normpath(os.path.join(folder, row[0]))


@cache
def outside(path: Path) -> frozenset[str]:
    """Modules a file imports that are neither Python's own nor of this repository nor beside it."""
    found = {item.module for item in imports(path)}
    beside = {other.stem for other in path.parent.glob("*.py")}
    return frozenset(
        name for name in found if name.partition(".")[0] not in sys.stdlib_module_names | OWN | beside | ALONE.keys()
    )


FILES = [*python_files("src"), *python_files("benchmarks"), *python_files("tests")]


@pytest.mark.slow
def test_what_is_imported_is_brought_by_the_tests_requirements(files_brought: frozenset[str]) -> None:
    importers = {name: path for path in FILES if DOCS not in path.parents for name in outside(path)}
    assert len(importers) > 10
    for name, path in sorted(importers.items()):
        found = importlib.util.find_spec(name)
        assert found is not None, f"{name}, imported by {label(path)}, is not installed"
        places = [found.origin] if found.origin else []
        places += [f"{folder}/" for folder in found.submodule_search_locations or () if not found.origin]
        # A namespace has no file of its own: one of the distributions has to bring something in it.
        own = any(
            os.path.normpath(place) in files_brought
            if not place.endswith("/")
            else any(file.startswith(os.path.normpath(place) + "/") for file in files_brought)
            for place in places
        )
        assert own, f"{name} comes with another extra, or by chance: name it in the extra `test`"


def test_a_module_of_the_linter_alone_is_found_out(files_brought: frozenset[str]) -> None:
    found = importlib.util.find_spec("importlinter")
    if found is None or found.origin is None:
        pytest.skip("only where the linter is installed, too")
    assert os.path.normpath(found.origin) not in files_brought
