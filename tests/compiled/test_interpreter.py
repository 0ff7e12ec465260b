"""Interpreted functions: what CasADi's virtual machine gives for each of sixteen columns, to the last bit."""

from __future__ import annotations

import shutil
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from nospill.compiled import codegen, small_libraries
from nospill.compiled.interpreter import COLUMNS, interpreted
from nospill.compiled.small_libraries import small_library
from nospill.core.batches import columns_at_once, evaluate, over_columns
from nospill.native import libraries
from tests.compiled.programs import OPERATIONS, of_two, random_program, same_as_step_after_step, swing, tape_of
from tests.compiling import own_library
from tests.hasty import COMPILER

SX = ca.SX
pytestmark = pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The compiled interpreter."""
    with own_library("interpreter", tmp_path_factory.mktemp("interpreter")) as found:
        return found


def same_for_each_column(function: ca.Function, found: list[np.ndarray], *columns: np.ndarray) -> None:
    """Outputs of many columns against the virtual machine's; an input of one column is the same for all."""
    for column in range(found[0].shape[1]):
        wanted = function.call([each[:, min(column, each.shape[1] - 1)] for each in columns])
        for one, other in zip(found, wanted, strict=True):
            np.testing.assert_array_equal(one[:, column], np.asarray(other).ravel())


@pytest.mark.parametrize("name", OPERATIONS)
def test_an_operation_gives_what_the_virtual_machine_gives(name: str, library: Path) -> None:
    function = of_two(name.replace(" ", "_"), OPERATIONS[name])
    ours = interpreted(tape_of(function, {2}), library)
    assert (ours.size_in(0), ours.size_in(2), ours.size_out(0)) == ((2, COLUMNS), (1, 1), (2, COLUMNS))
    random = np.random.default_rng(1)
    x, y, p = random.normal(scale=2.0, size=(2, COLUMNS)), random.normal(size=(1, COLUMNS)), np.array([[2.25]])
    x[:, :4], y[:, :4] = [[-1.5, 0.0, 2.5, 1.0], [3.25, -0.0, 1.0, np.nan]], [[1.0, 0.0, -2.0, 1.0]]
    same_for_each_column(function, [part.full() for part in ours(x, y, p)], x, y, p)


def test_no_values_of_a_column_are_interpreted_too(library: Path) -> None:
    nothing = interpreted(tape_of(ca.Function("nothing", [SX.sym("x", 2)], [SX.zeros(0, 1)])), library)
    assert nothing(np.ones((2, COLUMNS))).shape == (0, COLUMNS)


@pytest.mark.parametrize("operations", [1, 500, 3000])
def test_registers_are_used_again(operations: int, library: Path) -> None:
    function = random_program(operations)
    columns = np.random.default_rng(2).normal(size=(3, COLUMNS))
    ours = interpreted(tape_of(function), library)
    same_for_each_column(function, [part.full() for part in ours(columns)], columns)


@pytest.mark.parametrize("steps", [2, 7, COLUMNS])
def test_a_function_of_a_state_runs_step_after_step(steps: int, library: Path) -> None:
    same_as_step_after_step(interpreted(tape_of(swing(), {1}, steps), library), steps)


@pytest.mark.parametrize("count", [1, 15, 16, 17, 511, 512, 513, 1100])
def test_any_number_of_columns(count: int, library: Path) -> None:
    function = of_two("any", lambda x, y: x * ca.sin(y))
    ours = interpreted(tape_of(function, {2}), library)
    assert (columns_at_once(ours, [2]), columns_at_once(function, [2])) == (COLUMNS, 1)
    random = np.random.default_rng(count)
    x, y, p = random.normal(size=(2, count)), random.normal(size=(1, count)), random.normal(size=(1, 1))
    found = [np.asarray(part) for part in over_columns(ours, count, [2])(x, y, p)]
    same_for_each_column(function, found, x, y, p)
    first = ca.Function("first", [a := SX.sym("a", 2), b := SX.sym("b"), c := SX.sym("c")], [function(a, b, c)[0]])
    at_once = evaluate(interpreted(tape_of(first, (-1,)), library), [x, y], p.ravel())
    np.testing.assert_array_equal(at_once, found[0])


def test_every_copy_keeps_its_own_tape(library: Path) -> None:
    functions = [of_two(f"times_{factor}", lambda x, y, factor=factor: factor * x) for factor in range(20)]
    ours = [interpreted(tape_of(function), library) for function in functions]
    x, one = np.ones((2, COLUMNS)), np.ones((1, COLUMNS))
    for factor, function in enumerate(ours):
        assert np.all(function(x, one, one)[0].full() == factor)


def test_outputs_that_nobody_asks_for_and_inputs_that_are_not_given(library: Path) -> None:
    """As CasADi calls external functions: a missing input is zero, a missing output is not written."""
    ours = interpreted(tape_of(of_two("bare", lambda x, y: x + y), {2}), library)
    buffer, evaluate_now = ours.buffer()
    x, found = np.arange(2.0 * COLUMNS), np.full(COLUMNS, np.nan)
    buffer.set_arg(0, x.data)
    buffer.set_res(1, found.data)
    evaluate_now()
    np.testing.assert_array_equal(found, np.zeros(COLUMNS))


@pytest.fixture
def nothing_compiled(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A machine without a compiler and with an empty cache; where a wheel has its libraries."""
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("NOSPILL_COMPILE", "background")
    monkeypatch.setenv("CC", "no-such-compiler")
    monkeypatch.setattr(libraries, "PREBUILT", tmp_path / "prebuilt")
    return tmp_path / "prebuilt"


def served() -> ca.Function:
    function = of_two("served", lambda x, y: x * y)
    return codegen.functions("test", "served", lambda: ({"served": function}, None), of_columns={"served": (2,)})[0][
        "served"
    ]


def test_what_the_wheel_carries_serves_without_a_compiler(nothing_compiled: Path, library: Path) -> None:
    assert columns_at_once(served(), [2]) == 1
    nothing_compiled.mkdir()
    shutil.copy(library, nothing_compiled / libraries.file_name("interpreter"))
    assert small_library("interpreter", wait=False) == nothing_compiled / libraries.file_name("interpreter")
    assert columns_at_once(served(), [2]) == COLUMNS


def test_a_library_of_another_source_is_not_taken(
    nothing_compiled: Path, library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    nothing_compiled.mkdir()
    shutil.copy(library, nothing_compiled / libraries.file_name("interpreter"))
    source = libraries.source("interpreter")
    monkeypatch.setattr(libraries, "source", lambda _: source + "/* changed */\n")
    assert small_library("interpreter", wait=False) is None


def test_where_nothing_can_be_loaded_the_virtual_machine_serves(
    nothing_compiled: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    nothing_compiled.mkdir()
    (nothing_compiled / libraries.file_name("interpreter")).write_bytes(b"not a library")
    assert columns_at_once(served(), [2]) == 1
    monkeypatch.setattr(small_libraries, "mode", lambda: "off")
    assert columns_at_once(served(), [2]) == 1


def test_long_functions_wait_for_the_interpreter(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The first time on a machine: what is short does not, and runs in the virtual machine meanwhile."""
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path))
    monkeypatch.setenv("NOSPILL_COMPILE", "background")
    monkeypatch.setenv("CC", COMPILER)
    monkeypatch.setattr(codegen, "_waiting", [])
    x = value = SX.sym("x")
    for _ in range(codegen._LONG):
        value = ca.sin(value)
    program = ca.Function("program", [x], [value])
    made, _, compiled = codegen.functions(
        "test", "long", lambda: ({"program": program}, None), of_columns={"program": []}
    )
    assert columns_at_once(made["program"], []) == COLUMNS and not compiled
    columns = np.random.default_rng(3).normal(size=(1, COLUMNS))
    same_for_each_column(program, [made["program"](columns).full()], columns)
