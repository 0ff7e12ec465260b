"""Tapes of CasADi's functions."""

from __future__ import annotations

from array import array
from collections.abc import Collection
from typing import Any

import casadi as ca

from nospill.compiled.tape import Tape
from nospill.native.operations import CONSTANT, FIRST, INPUT, NAMES, OUTPUT

_CODES = {
    ca.OP_INPUT: INPUT,
    ca.OP_OUTPUT: OUTPUT,
    ca.OP_CONST: CONSTANT,
    **{getattr(ca, f"OP_{name}"): code for code, name in enumerate(NAMES, FIRST)},
}


def read_tape(function: Any, shared: Collection[int], steps: int = 1) -> Tape | None:
    """The instructions of a function, None where it is not of symbols and dense columns, with operations known here.

    Args:
        function: any CasADi function.
        shared: places of the inputs that are the same for all columns; -1 is the last.
        steps: how often it runs (`Tape`).
    """
    if not function.is_a("SXFunction"):
        return None
    inputs, outputs = range(function.n_in()), range(function.n_out())
    if any(function.nnz_in(index) != function.size1_in(index) for index in inputs):
        return None
    if any(function.nnz_out(index) != function.size1_out(index) for index in outputs):
        return None
    code, constants = array("i"), array("d")
    for number in range(function.n_instructions()):
        operation = _CODES.get(function.instruction_id(number))
        if operation is None:
            return None
        to, operands = function.instruction_output(number), function.instruction_input(number)
        if operation == CONSTANT:
            operands = (len(constants),)
            constants.append(function.instruction_constant(number))
        elif operation == OUTPUT:
            operands = (operands[0], to[1])
        code.extend((operation, to[0], operands[0], operands[1] if len(operands) > 1 else operands[0]))
    return Tape(
        function.name(),
        tuple(function.nnz_in(index) for index in inputs),
        tuple(function.nnz_out(index) for index in outputs),
        frozenset(place % len(inputs) for place in shared),
        function.sz_w(),
        code,
        constants,
        steps,
    )
