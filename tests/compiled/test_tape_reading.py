"""Tapes of functions: taken one instruction after the other, they give what the functions give."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import casadi as ca
import numpy as np
import pytest

from nospill.compiled import tape_reading
from nospill.compiled.tape import Tape
from nospill.compiled.tape_reading import read_tape
from nospill.native.operations import CONSTANT, FIRST, INPUT, NAMES, OUTPUT
from tests.compiled.programs import OPERATIONS, of_two, random_program, swing, tape_of

SX = ca.SX
OF_ONE = {
    name: getattr(np, name.lower()) for name in ("SQRT", "SIN", "COS", "TAN", "EXP", "LOG", "SINH", "COSH", "TANH")
}
OF_ONE |= {"ASIN": np.arcsin, "ACOS": np.arccos, "ATAN": np.arctan}
IN_PYTHON = {
    "ASSIGN": lambda x, _: x,
    "ADD": lambda x, y: x + y,
    "SUB": lambda x, y: x - y,
    "MUL": lambda x, y: x * y,
    "DIV": lambda x, y: x / y,
    "NEG": lambda x, _: -x,
    "SQ": lambda x, _: x * x,
    "TWICE": lambda x, _: 2.0 * x,
    "INV": lambda x, _: 1.0 / x,
    "FABS": lambda x, _: abs(x),
    "SIGN": lambda x, _: np.sign(x),
    "LT": lambda x, y: float(x < y),
    "LE": lambda x, y: float(x <= y),
    "EQ": lambda x, y: float(x == y),
    "NE": lambda x, y: float(x != y),
    "NOT": lambda x, _: float(not x),
    "AND": lambda x, y: float(bool(x and y)),
    "OR": lambda x, y: float(bool(x or y)),
    "IF_ELSE_ZERO": lambda x, y: y if x else 0.0,
    "ATAN2": np.arctan2,
    "POW": np.power,
    "CONSTPOW": np.power,
    "FMIN": np.fmin,
    "FMAX": np.fmax,
    **{name: lambda x, _, own=own: own(x) for name, own in OF_ONE.items()},
}
"""Each operation of a tape on two numbers."""


def played(tape: Tape, inputs: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The outputs of a tape for one column."""
    registers, outputs = np.full(tape.registers, np.nan), [np.full(rows, np.nan) for rows in tape.rows_out]
    for code, to, one, other in np.array(tape.code).reshape(-1, 4):
        if code == INPUT:
            registers[to] = inputs[one][other]
        elif code == CONSTANT:
            registers[to] = tape.constants[one]
        elif code == OUTPUT:
            outputs[to][other] = registers[one]
        else:
            registers[to] = IN_PYTHON[NAMES[code - FIRST]](registers[one], registers[other])
    return outputs


def of_constants() -> ca.Function:
    """Constants of all kinds, some of which are part of an operation."""
    x, numbers = SX.sym("x", 12), (0.1, -1 / 3, 1e-300, -2.5e17, 7.0, -3.0, np.inf, -np.inf, np.pi, 1e-9, 2.0, 1.0)
    every = [number * x[row] for row, number in enumerate(numbers)]
    return ca.Function("constants", [x], [ca.vertcat(*every, 2 * x[0], 1 / x[1], ca.if_else(x[2], x[3], 0), 5, -0.5)])


FUNCTIONS: dict[str, Callable[[], ca.Function]] = {
    **{name: partial(of_two, name.replace(" ", "_"), operation) for name, operation in OPERATIONS.items()},
    "random program": partial(random_program, 3000),
    "swing": swing,
    "constants": of_constants,
}
"""Made by their tests: every worker collects all of them."""


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_tape_gives_what_its_function_gives(name: str) -> None:
    function = FUNCTIONS[name]()
    tape, random = tape_of(function), np.random.default_rng(3)
    assert tape.count == function.n_instructions()
    for _ in range(3):
        inputs = [random.uniform(0.1, 0.9, size=rows) for rows in tape.rows_in]
        wanted = function.call(inputs)
        for one, other in zip(played(tape, inputs), wanted, strict=True):
            np.testing.assert_allclose(one, np.asarray(other).ravel(), rtol=1e-12)


def test_a_function_without_values_has_an_empty_tape() -> None:
    tape = tape_of(ca.Function("nothing", [SX.sym("x", 2)], [SX.zeros(0, 1)]))
    assert (tape.count, tape.rows_out) == (0, (0,))


X = SX.sym("x", 2)
WITHOUT_TAPE = {
    "ERF": ca.Function("other", [X], [ca.erf(X[0])]),
    "FMOD": ca.Function("other", [X], [ca.fmod(X[0], X[1])]),
    "COPYSIGN": ca.Function("other", [X], [ca.copysign(X[0], X[1])]),
    "SX symbols": ca.Function("other", [ca.MX.sym("x", 2)], [ca.MX(1)]),
    "dense columns": ca.Function("other", [X], [X.T]),
}


@pytest.mark.parametrize("why", WITHOUT_TAPE)
def test_what_has_no_tape_is_said_once_with_its_cost(why: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tape_reading, "_warned", [])
    with pytest.warns(RuntimeWarning, match=f"other .*{why}.* up to three times as long"):
        assert read_tape(WITHOUT_TAPE[why], ()) is None
    assert read_tape(WITHOUT_TAPE["ERF"], ()) is None  # a second warning would be an error
