"""No test is about seconds: clocks are read, and time-outs named, in tests/waiting.py alone."""

from __future__ import annotations

import ast
import re
from itertools import pairwise

import pytest

from tests.repository.modules import ROOT, label, python_files

CLOCKS = {"perf_counter", "perf_counter_ns", "monotonic", "monotonic_ns", "process_time", "thread_time", "timeit"}
PAGES_CLOCK = "performance." + "now"
MEASURED = re.compile(r"seconds|elapsed|wall_time|plan_time|solve_time")
"""Figures of a clock that somebody else has read: no test bounds them from above."""
EXEMPT = ROOT / "tests" / "waiting.py"
FILES = [path for path in python_files("tests") if path != EXEMPT]


def clocks_read(tree: ast.Module) -> list[str]:
    """Where a clock of the time module is read, a wait has a time-out of its own, or a page's clock is read."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = ast.unparse(node.func)
            if name.rpartition(".")[2] in CLOCKS or name in ("time.time", "datetime.now", "datetime.datetime.now"):
                found.append(f"line {node.lineno}: {name}")
            found += [f"line {node.lineno}: time-out of {name}" for word in node.keywords if word.arg == "timeout"]
        elif isinstance(node, ast.ImportFrom) and node.module == "time":
            found.append(f"line {node.lineno}: import from time")
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and PAGES_CLOCK in node.value:
            found.append(f"line {node.lineno}: clock of a page")
        elif isinstance(node, ast.Compare) and any(map(bounded_from_above, pairwise(sides(node)), node.ops)):
            found.append(f"line {node.lineno}: bound on {ast.unparse(node)}")
    return found


def sides(node: ast.Compare) -> list[ast.expr]:
    """What a chain of comparisons compares, from left to right."""
    return [node.left, *node.comparators]


def bounded_from_above(pair: tuple[ast.expr, ast.expr], by: ast.cmpop) -> bool:
    """Whether a measured time has to be less than a number."""
    small, large = pair if isinstance(by, ast.Lt | ast.LtE) else pair[::-1]
    ordered = isinstance(by, ast.Lt | ast.LtE | ast.Gt | ast.GtE)
    return ordered and isinstance(large, ast.Constant) and bool(MEASURED.search(ast.unparse(small)))


@pytest.mark.slow
def test_no_test_reads_a_clock() -> None:
    found = {label(path): clocks_read(ast.parse(path.read_text())) for path in FILES}
    assert not any(found.values()), f"wait by tests/waiting.py, or count what is to be fast: {found}"


@pytest.mark.parametrize(
    "code",
    [
        "assert time.monotonic() - began < 2.0",
        "from time import perf_counter",
        "took = time.perf_counter() - began",
        "began = time.time()",
        "process.communicate(timeout=20)",
        "assert line['said'] and line['seconds'] < 60.0",
        "assert 5 >= report.plan_time",
        f"page.evaluate('{PAGES_CLOCK}() / 1e3')",
    ],
)
def test_a_clock_is_found(code: str) -> None:
    assert clocks_read(ast.parse(code))


@pytest.mark.parametrize("code", ["assert 0 < report.solve_time < report.plan_time", "assert line['seconds'] > 0.0"])
def test_times_may_be_compared_with_each_other(code: str) -> None:
    assert clocks_read(ast.parse(code)) == []
