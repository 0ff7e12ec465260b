"""Functions of four columns at once: what the function itself gives for each column, to the last bit."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from nospill.compiled import codegen, simd_source, tape_reading
from nospill.compiled.tape_reading import read_tape
from nospill.core.batches import columns_at_once, evaluate, over_columns
from nospill.native.operations import NAMES
from tests.compiled.programs import OPERATIONS, of_two, random_program, same_as_step_after_step, swing, tape_of
from tests.hasty import COMPILER

SX = ca.SX
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler"),
]


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., ca.Function]:
    """Machine code of a function, as the cache has it."""
    monkeypatch.setenv("CC", COMPILER)
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path))
    monkeypatch.setenv("NOSPILL_COMPILE", "wait")

    def made(function: ca.Function, *shared: int) -> ca.Function:
        name = function.name()
        found, _, is_compiled = codegen.functions(
            "test", str(function), lambda: ({name: function}, None), of_columns={name: shared}
        )
        assert is_compiled
        return found[name]

    return made


def test_every_known_operation_is_tried() -> None:
    used: set[int] = set()
    for name, expression in OPERATIONS.items():
        function = of_two(name.replace(" ", "_"), expression)
        assert read_tape(function, ()) is not None
        used |= {function.instruction_id(index) for index in range(function.n_instructions())}
    assert used >= {getattr(ca, f"OP_{name}") for name in NAMES} - {ca.OP_ASSIGN}


@pytest.mark.parametrize("name", OPERATIONS)
def test_an_operation_gives_what_the_virtual_machine_gives(name: str, compiled: Callable[..., ca.Function]) -> None:
    function = of_two(name.replace(" ", "_"), OPERATIONS[name])
    four = compiled(function, 2)
    assert (four.size_in(0), four.size_in(2), four.size_out(0)) == ((2, 4), (1, 1), (2, 4))
    x = np.array([[-1.5, 0.0, 2.5, 1.0], [3.25, -0.0, 1.0, np.nan]])
    y = np.array([[1.0, 0.0, -2.0, 1.0]])
    found = [part.full() for part in four(x, y, 2.25)]
    for column in range(4):
        wanted = [part.full().ravel() for part in function(x[:, column], y[:, column], 2.25)]
        for one, other in zip(found, wanted, strict=True):
            np.testing.assert_array_equal(one[:, column], other)


@pytest.mark.parametrize("operations", [1, 498, 499, 500, 501, 3000])
def test_parts_hand_on_what_later_ones_read(operations: int, compiled: Callable[..., ca.Function]) -> None:
    function, random = random_program(operations), np.random.default_rng(operations)
    columns = random.normal(size=(3, 4))
    found = [part.full() for part in compiled(function)(columns)]
    wanted = [function(columns[:, column]) for column in range(4)]
    for place, one in enumerate(found):
        np.testing.assert_array_equal(one, np.hstack([part[place].full() for part in wanted]))


@pytest.mark.parametrize("count", [1, 3, 4, 5, 8, 499, 501, 1002])
def test_any_number_of_columns(count: int, compiled: Callable[..., ca.Function]) -> None:
    function = of_two("any", lambda x, y: x * ca.sin(y))
    four = compiled(function, 2)
    assert (columns_at_once(four, [2]), columns_at_once(function, [2])) == (4, 1)
    random = np.random.default_rng(count)
    x, y, p = random.normal(size=(2, count)), random.normal(size=(1, count)), random.normal(size=1)
    wanted = function.map(count, [False, False, True], [False, False])(x, y, p) if count > 1 else function(x, y, p)
    for one, other in zip(over_columns(four, count, [2])(x, y, p), wanted, strict=True):
        np.testing.assert_array_equal(np.asarray(one), np.asarray(other))
    first = ca.Function("first", [a := SX.sym("a", 2), b := SX.sym("b"), c := SX.sym("c")], [function(a, b, c)[0]])
    np.testing.assert_array_equal(evaluate(compiled(first, -1), [x, y], p), np.asarray(wanted[0]))


def test_what_is_not_of_columns_or_not_known_is_compiled_as_it_is(
    compiled: Callable[..., ca.Function], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tape_reading, "_warned", ["another function"])
    x, m, w = SX.sym("x", 2), SX.sym("m", 2, 2), ca.MX.sym("w", 2)
    others = [
        ca.Function("matrix", [m], [m @ m]),
        ca.Function("sparse", [x], [ca.vertcat(x[0], SX(1, 1))]),
        ca.Function("unknown", [x], [ca.erf(x)]),
        ca.Function("graph", [w], [2 * w]),
    ]
    for function in others:
        assert read_tape(function, ()) is None
        found = compiled(function)
        assert found.size_in(0) == function.size_in(0)
        value = np.full(function.size_in(0), 0.3)
        np.testing.assert_allclose(np.asarray(found(value)), np.asarray(function(value)), rtol=1e-15)


def test_no_values_of_a_column_are_compiled_too(compiled: Callable[..., ca.Function]) -> None:
    nothing = compiled(ca.Function("nothing", [SX.sym("x", 2)], [SX.zeros(0, 1)]))
    assert nothing(np.ones((2, 4))).shape == (0, 4)


@pytest.mark.parametrize("steps", [2, 7])
def test_a_function_of_a_state_runs_step_after_step(
    steps: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("CC", COMPILER)
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path))
    monkeypatch.setenv("NOSPILL_COMPILE", "wait")
    found, _, is_compiled = codegen.functions(
        "test", "swing", lambda: ({"step": swing()}, None), of_columns={"step": (1,)}, steps=steps
    )
    assert is_compiled
    same_as_step_after_step(found["step"], steps)


def test_outputs_that_nobody_asks_for_and_inputs_that_are_not_given(tmp_path: Path) -> None:
    """As CasADi calls external functions: a missing input is zero, a missing output is not written; any alignment."""
    function = of_two("bare", lambda x, y: x + y)
    (tmp_path / "bare.c").write_text(simd_source.HEADER + simd_source.source(tape_of(function, {2})))
    library = tmp_path / "bare.so"
    subprocess.run(
        [COMPILER, "-O1", "-shared", "-fPIC", *simd_source.flags(), "-o", library, tmp_path / "bare.c", "-lm"],
        check=True,
        capture_output=True,
    )
    loaded = ctypes.CDLL(str(library))
    sizes = [ctypes.c_longlong() for _ in range(4)]
    assert loaded.bare_work(*map(ctypes.byref, sizes)) == 0
    assert [sizes[0].value, sizes[1].value] == [3, 2]
    x, found = np.arange(8.0), np.full(4, np.nan)
    for shift in range(4):
        work = np.full(sizes[3].value + shift, 7.0)
        place = work[shift:].ctypes.data
        pointer = ctypes.c_void_p
        arguments = (pointer * 3)(x.ctypes.data, None, None)
        for results, wanted in (((None, found.ctypes.data), np.zeros(4)), ((None, None), None)):
            assert loaded.bare(arguments, (pointer * 2)(*results), None, pointer(place), 0) == 0
            if wanted is not None:
                np.testing.assert_array_equal(found, wanted)
