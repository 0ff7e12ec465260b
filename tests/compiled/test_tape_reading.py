"""Tapes against the instructions one by one, as CasADi's interface gives them."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from nospill.compiled.tape_reading import read_tape
from nospill.native.operations import CONSTANT, FIRST, INPUT, NAMES, OUTPUT
from tests.compiled.programs import OPERATIONS, of_two, random_program, swing

SX = ca.SX
CODES = {ca.OP_INPUT: INPUT, ca.OP_OUTPUT: OUTPUT, ca.OP_CONST: CONSTANT}
CODES |= {getattr(ca, f"OP_{name}"): code for code, name in enumerate(NAMES, FIRST)}
CODES[ca.OP_CONSTPOW] = CODES[ca.OP_POW]


def one_by_one(function: ca.Function) -> tuple[list[list[int]], list[float]]:
    """Code and constants of a tape."""
    rows, constants = [], []
    for index in range(function.n_instructions()):
        code = CODES[function.instruction_id(index)]
        to, operands = function.instruction_output(index), function.instruction_input(index)
        if code == CONSTANT:
            operands = [len(constants)]
            constants.append(function.instruction_constant(index))
        elif code == OUTPUT:
            operands = [operands[0], to[1]]
        rows.append([code, to[0], operands[0], operands[-1]])
    return rows, constants


def of_constants() -> ca.Function:
    """Constants of all kinds among operations that are printed with digits."""
    x, numbers = SX.sym("x", 12), (0.1, -1 / 3, 1e-300, -2.5e17, 7.0, -3.0, np.inf, -np.inf, np.pi, 1e-9, 2.0, 1.0)
    every = [number * x[row] for row, number in enumerate(numbers)]
    return ca.Function("constants", [x], [ca.vertcat(*every, 2 * x[0], 1 / x[1], ca.if_else(x[2], x[3], 0), 5, -0.5)])


@pytest.mark.parametrize(
    "function",
    [
        *(of_two(name.replace(" ", "_"), operation) for name, operation in OPERATIONS.items()),
        random_program(3000),
        swing(),
        of_constants(),
    ],
    ids=lambda function: function.name(),
)
def test_a_tape_is_what_the_instructions_are_one_by_one(function: ca.Function) -> None:
    tape = read_tape(function, ())
    assert tape is not None
    rows, constants = one_by_one(function)
    np.testing.assert_array_equal(np.array(tape.code).reshape(-1, 4), rows)
    np.testing.assert_array_equal(tape.constants, constants)
    assert {len(rows), tape.count} == {function.n_instructions()}


@pytest.mark.parametrize("name", ["erf", "floor", "fmod", "copysign", "expm1", "asinh"])
def test_a_function_with_another_operation_has_no_tape(name: str) -> None:
    x = SX.sym("x", 2)
    operation = getattr(ca, name)
    result = operation(x[0], x[1]) if name in {"fmod", "copysign"} else operation(x[0])
    assert read_tape(ca.Function("other", [x], [result]), ()) is None
