"""How the files hang together: no circles, nothing private across packages, few layers, and a page that says so."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.repository.modules import ROOT, circles, import_graph, imports, label, module_name, python_files

PACKAGE = ROOT / "src" / "nospill"


@pytest.mark.parametrize("folder", ["src", "tests", "benchmarks", "docs"])
def test_no_circle_between_files(folder: str) -> None:
    assert circles(import_graph(folder)) == []


def test_a_circle_is_found() -> None:
    graph = {"a": frozenset("b"), "b": frozenset("c"), "c": frozenset("bd"), "d": frozenset[str]()}
    assert circles(graph) == [["b", "c"]]


# --- private names --------------------------------------------------------------------------------------------------


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def foreign_private_names(path: Path) -> Iterator[str]:
    """Private names of another package that a file imports, or takes from a module it imports."""
    own = module_name(path) if path.stem == "__init__" else module_name(path).rpartition(".")[0]
    aliases = {}
    for item in imports(path):
        if not item.module.startswith("nospill"):
            continue
        whole = f"{item.module}.{item.name}"
        if item.module != own and any(is_private(part) for part in (*item.module.split("."), item.name)):
            yield f"line {item.line}: {whole}"
        if item.name and whole != own and not whole.startswith(f"{own}."):
            aliases[item.name] = whole
    modules = import_graph("src").keys()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and is_private(node.attr):
            whole = aliases.get(node.value.id, "")
            if whole in modules and whole.rpartition(".")[0] != own:
                yield f"line {node.lineno}: {whole}.{node.attr}"


def test_nothing_private_of_another_package_is_used() -> None:
    found = {
        label(path): list(foreign_private_names(path)) for path in (*python_files("src"), *python_files("benchmarks"))
    }
    assert not any(found.values()), found


# --- packages and layers --------------------------------------------------------------------------------------------


def test_at_most_four_modules_are_loose() -> None:
    assert len(list(PACKAGE.glob("*.py"))) <= 4


def test_every_package_has_its_layer(project: dict) -> None:
    [contract] = [one for one in project["tool"]["importlinter"]["contracts"] if one["type"] == "layers"]
    assert contract["exhaustive"] is True


def test_the_judge_and_the_optimiser_do_not_know_each_other(project: dict) -> None:
    [contract] = [one for one in project["tool"]["importlinter"]["contracts"] if one["type"] == "layers"]
    [layer] = [layer for layer in contract["layers"] if "(certification)" in layer]
    assert "(transcription)" in layer.split(" | ")


def test_the_page_on_the_design_has_the_layers_and_every_package(project: dict) -> None:
    page = (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
    [contract] = [one for one in project["tool"]["importlinter"]["contracts"] if one["type"] == "layers"]
    assert "".join(f"    {re.sub('[()]', '', layer)}\n" for layer in contract["layers"]) in page
    tree = page[page.index("    src/nospill/\n") : page.index("The layers, highest first")]
    listed = re.findall(r"^    [├└]── (\w+)/ ", tree, re.MULTILINE)
    assert sorted(listed) == sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))


def test_the_page_on_the_design_names_the_packages_that_import_judge_and_optimiser() -> None:
    page = (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
    [sentence] = re.findall(r"^\w+ packages import both: (.+)$", page, re.MULTILINE)
    importers = {room: {path.relative_to(PACKAGE).parts[0] for path in importing(room)} for room in BOTH}
    found = set.intersection(*importers.values()) - BOTH
    assert found == set(re.findall(r"`(\w+)`", sentence))


BOTH = {"certification", "transcription"}


def importing(room: str) -> Iterator[Path]:
    """Files of the package that import a room of it."""
    for path in python_files("src"):
        if path.parent != PACKAGE and any(item.module.startswith(f"nospill.{room}") for item in imports(path)):
            yield path


def overridden(folder: Path) -> Iterator[str]:
    """Methods of classes in a folder that replace a method with a body of a class they inherit from in it."""
    classes = {
        node.name: node
        for path in sorted(folder.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
    }
    methods = {
        name: {item.name: item for item in node.body if isinstance(item, ast.FunctionDef)}
        for name, node in classes.items()
    }

    def above(name: str) -> Iterator[str]:
        for base in classes[name].bases:
            parent = ast.unparse(base).rpartition(".")[2]
            if parent in classes:
                yield parent
                yield from above(parent)

    for name in classes:
        for parent in above(name):
            for method in methods[name].keys() & methods[parent].keys():
                abstract = any("abstractmethod" in ast.unparse(one) for one in methods[parent][method].decorator_list)
                if not abstract:
                    yield f"{name}.{method} overrides {parent}.{method}"


def test_no_method_of_the_planner_is_overridden() -> None:
    assert sorted(overridden(PACKAGE / "planning")) == []


def test_no_class_of_the_planner_has_more_than_eight_mutable_fields() -> None:
    assert dict(mutable_fields(PACKAGE / "planning")) == {}


def mutable_fields(folder: Path) -> Iterator[tuple[str, int]]:
    """Classes with more than eight fields that may change, and how many."""
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.ClassDef) or any("frozen=True" in ast.unparse(d) for d in node.decorator_list):
                continue
            if any("NamedTuple" in ast.unparse(base) or "Protocol" in ast.unparse(base) for base in node.bases):
                continue
            fields = {ast.unparse(item.target) for item in node.body if isinstance(item, ast.AnnAssign)}
            for inner in ast.walk(node):
                if (
                    isinstance(inner, ast.Attribute)
                    and isinstance(inner.ctx, ast.Store)
                    and ast.unparse(inner.value) == "self"
                ):
                    fields.add(inner.attr)
            if len(fields) > 8:
                yield f"{path.name}: {node.name}", len(fields)
