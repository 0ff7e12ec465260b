"""What is known of one constraint stands in its class: no other file of the package has its name as a string."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import nospill
from nospill.certification.verdict import APPROACH
from nospill.laws.constraints import BY_NAME

PACKAGE = Path(nospill.__file__).parent
HOME = PACKAGE / "laws" / "constraints"

BELOW_THE_LAWS = ("core", "robots", "scene", "scenario", "motion")
"""Rooms that may not import the laws; what they say of a limit stands in words."""

OTHER_MEANINGS = {
    "tip": {
        "cli/verifying.py": "key of margins.json",
        "margins/report.py": "key of margins.json",
        "studio/changes.py": "link of a robot",
    },
    "tilt": {
        "comparison/compared.py": "key of a scenario",
        "identification/design.py": "key of a scenario",
        "certification/record_checks.py": "column of a trajectory",
        "certification/traces.py": "name of a symbol",
        "plans/summary.py": "attribute of the largest figures",
        "plots/figures.py": "name of a figure",
        "report/page.py": "name of a figure",
        "studio/fields.py": "key of a scenario",
        "verify/report.py": "part of a file name",
        "warmup/usual.py": "key of a scenario",
    },
    "corridor": {
        "planning/freed_paths.py": "key of a scenario",
        "studio/fields.py": "key of a scenario",
    },
    "clearance": {"studio/obstacles.py": "key of a scenario"},
}
"""Names that are words of their own elsewhere: name -> file -> what it means there."""


def literals(source: str) -> Iterator[tuple[int, str]]:
    """Line and text of every string in a source that is no docstring; of an f-string its constant parts."""
    tree = ast.parse(source)
    alone = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in alone:
            yield node.lineno, node.value


def names_in(text: str) -> set[str]:
    """Constraints that a string names, by itself, as a row of an approach or as in "joint speed of ..."."""
    whole = text.removeprefix(APPROACH)
    return {name for name in BY_NAME if whole == name or (" " in name and f"{name} of " in text)}


def test_the_search_finds_what_it_should() -> None:
    source = '''"""slip"""\nx = {"slip": 1, "no": f"joint position of {x}"}\ny = "approach slosh height"\n'''
    found = [(line, name) for line, text in literals(source) for name in names_in(text)]
    assert sorted(found) == [(2, "joint position"), (2, "slip"), (3, "slosh height")]


def test_no_name_of_a_constraint_stands_outside_the_constraints() -> None:
    files = {path.relative_to(PACKAGE).as_posix(): path for path in PACKAGE.rglob("*.py") if HOME not in path.parents}
    found = {
        f"{place}:{line}: {name!r}; use the constraint's class, role or a figure of it"
        for place, path in files.items()
        if place.partition("/")[0] not in BELOW_THE_LAWS
        for line, text in literals(path.read_text(encoding="utf-8"))
        for name in names_in(text)
        if place not in OTHER_MEANINGS.get(name, {})
    }
    assert not found, "\n".join(sorted(found))
