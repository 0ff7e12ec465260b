"""Files of the repository as modules that import each other, read from their syntax: nothing is executed."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]


def label(path: Path) -> str:
    """A file's place in the repository, as the name of a test case."""
    return str(path.relative_to(ROOT))


@cache
def python_files(folder: str) -> tuple[Path, ...]:
    """All Python files below a folder of the repository, in order."""
    return tuple(sorted((ROOT / folder).rglob("*.py")))


@cache
def module_name(path: Path) -> str:
    """Dotted name under which a file is imported."""
    parts = list(path.relative_to(ROOT).with_suffix("").parts)
    if parts[0] == "src":
        parts = parts[1:]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@dataclass(frozen=True, slots=True)
class Import:
    """One import statement, one name of it: `from module import name`, or `import module` where the name is empty."""

    module: str
    name: str
    line: int


@cache
def imports(path: Path) -> tuple[Import, ...]:
    """Every import of a file, those in functions and for type checkers alone too; relative ones in full."""
    return tuple(_imports(path))


def _imports(path: Path) -> Iterator[Import]:
    package = module_name(path) if path.stem == "__init__" else module_name(path).rpartition(".")[0]
    for node in _statements(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (Import(item.name, "", node.lineno) for item in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            yield from (Import(module, item.name, node.lineno) for item in node.names)


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """Every statement below a node: a twentieth of all nodes, which expressions are."""
    for part in ("body", "orelse", "finalbody", "handlers", "cases"):
        for child in getattr(node, part, ()):
            yield child
            yield from _statements(child)


@cache
def import_graph(folder: str) -> dict[str, frozenset[str]]:
    """Modules below a folder, and which of each other they import.

    `from package import name` is an import of the module `package.name` where there is one, else of the package's own
    `__init__`, which stands for what it gathers.
    """
    names = {module_name(path): path for path in python_files(folder)}

    def target(item: Import) -> str:
        whole = f"{item.module}.{item.name}"
        return whole if item.name and whole in names else item.module

    return {
        name: frozenset(target(item) for item in imports(path)) & (names.keys() - {name})
        for name, path in names.items()
    }


def circles(graph: dict[str, frozenset[str]]) -> list[list[str]]:
    """Groups of modules of which each imports each other one, if by way of others (Tarjan 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(graph[node]):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            place = stack.index(node)
            group = stack[place:]
            del stack[place:]
            if len(group) > 1:
                found.append(sorted(group))

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return found
