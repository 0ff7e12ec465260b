"""Tapes of CasADi's functions, read instruction by instruction through its interface.

The instructions of a scene are up to 600,000; they are read where functions are not compiled yet. SWIG finds the C++
object behind a function of Python anew in every call, which takes 1 us; it is handed that object itself (`this`).
"""

from __future__ import annotations

import warnings
from array import array
from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import repeat
from typing import Any

import casadi as ca
from casadi import _casadi  # pyright: ignore[reportAttributeAccessIssue]

from nospill.compiled.tape import Tape
from nospill.native.operations import CONSTANT, FIRST, INPUT, NAMES, OUTPUT

_CODES = {ca.OP_INPUT: INPUT, ca.OP_OUTPUT: OUTPUT, ca.OP_CONST: CONSTANT} | {
    getattr(ca, f"OP_{name}"): code for code, name in enumerate(NAMES, FIRST)
}
"""Code of a tape by CasADi's own."""


def read_tape(function: Any, shared: Collection[int], steps: int = 1) -> Tape | None:
    """The instructions of a function of symbols, dense columns and known operations; None for others, with a warning.

    Args:
        function: any CasADi function.
        shared: places of the inputs that are the same for all columns; -1 is the last.
        steps: how often it runs (`Tape`).
    """
    operations = _operations(function)
    obstacle = _obstacle(function, operations)
    if obstacle:
        _warn_once(function.name(), obstacle)
        return None
    inputs, outputs = range(function.n_in()), range(function.n_out())
    return Tape(
        function.name(),
        tuple(function.nnz_in(index) for index in inputs),
        tuple(function.nnz_out(index) for index in outputs),
        frozenset(place % len(inputs) for place in shared),
        function.sz_w(),
        *_read_instructions(function, operations),
        steps,
    )


def _operations(function: Any) -> list[int]:
    """CasADi's code of every instruction; none of a function without instructions of its own."""
    return list(_of_every(_casadi.Function_instruction_id, function)) if function.is_a("SXFunction") else []


def _of_every(figure: Callable[[Any, int], Any], function: Any) -> Iterator[Any]:
    """What the interface says of every instruction."""
    return map(figure, repeat(function.this), range(function.n_instructions()))


def _obstacle(function: Any, operations: Sequence[int]) -> str:
    """What keeps a function from having a tape; empty where nothing does."""
    if not function.is_a("SXFunction"):
        return "is not made of SX symbols"
    sizes = [(function.nnz_in(index), function.size1_in(index)) for index in range(function.n_in())]
    sizes += [(function.nnz_out(index), function.size1_out(index)) for index in range(function.n_out())]
    if any(numbers != rows for numbers, rows in sizes):
        return "has inputs or outputs that are not dense columns"
    others = set(operations) - {*_CODES}
    unknown = sorted(name for name in dir(ca) if name.startswith("OP_") and getattr(ca, name) in others)
    return f"has operations that are not in nospill's table ({', '.join(unknown)})" if unknown else ""


def _read_instructions(function: Any, operations: Sequence[int]) -> tuple[array[int], array[float]]:
    """Code and constants of a `Tape`."""
    code, constants = array("i"), array("d")
    results = _of_every(_casadi.Function_instruction_output, function)
    sources = _of_every(_casadi.Function_instruction_input, function)
    for index, (operation, to, operands) in enumerate(zip(operations, results, sources, strict=True)):
        if operation == ca.OP_CONST:
            operands.append(len(constants))
            constants.append(function.instruction_constant(index))
        elif operation == ca.OP_OUTPUT:
            operands.append(to[1])
        code.extend((_CODES[operation], to[0], operands[0], operands[-1]))
    return code, constants


_warned: list[str] = []
"""Of which function a warning has spoken in this process."""


def _warn_once(name: str, obstacle: str) -> None:
    """What a function without a tape costs; further ones say nothing new."""
    if not _warned:
        _warned.append(name)
        warnings.warn(
            f"function {name} {obstacle}: such functions are evaluated by CasADi's virtual machine, "
            "plans take up to three times as long",
            RuntimeWarning,
            stacklevel=1,
        )
