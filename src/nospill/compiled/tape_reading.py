"""Tapes of CasADi's functions, read from what CasADi prints of them.

Asking for the instructions one by one, three calls each, takes more than twice as long; those of a scene are up to
200,000.
"""

from __future__ import annotations

import string
from array import array
from collections.abc import Collection
from typing import Any

import casadi as ca
import numpy as np

from nospill.compiled.tape import Tape
from nospill.native.operations import CONSTANT, FIRST, INPUT, NAMES, OUTPUT

_PRINTED = {
    "ASSIGN": "@",
    "ADD": "(@+@)",
    "SUB": "(@-@)",
    "MUL": "(@*@)",
    "DIV": "(@/@)",
    "NEG": "(-@)",
    "TWICE": "(2.*@)",
    "INV": "(1./@)",
    "FMIN": "fmin(@,@)",
    "FMAX": "fmax(@,@)",
    "LT": "(@<@)",
    "LE": "(@<=@)",
    "EQ": "(@==@)",
    "NE": "(@!=@)",
    "NOT": "(!@)",
    "AND": "(@&&@)",
    "OR": "(@||@)",
    "IF_ELSE_ZERO": "(@?@:0)",
    "ATAN2": "atan2(@,@)",
    "POW": "pow(@,@)",
}
"""How CasADi prints an operation, @ for an operand; one that is not here as "sin(@)". CONSTPOW is printed as POW is."""
_WITH_DIGITS = ("(2.*", "(1./", ":0)", "atan2(")
"""Digits of a form that are no numbers of an instruction."""

_NO_DIGITS = str.maketrans("", "", string.digits)
_ONLY_DIGITS = str.maketrans({character: " " for character in map(chr, range(128)) if not character.isdigit()})

_FORMS = {
    code: _PRINTED.get(name, f"{name.lower()}(@)") for code, name in enumerate(NAMES, FIRST) if name != "CONSTPOW"
}
_CODES = {
    "@ = input[][];": INPUT,
    "output[][] = @;": OUTPUT,
    **{f"@ = {form};".translate(_NO_DIGITS): code for code, form in _FORMS.items()},
}
"""Line of an instruction without its digits -> code."""
_NUMBERS = np.full(FIRST + len(NAMES), 3)
"""How many numbers a line has, by its code: registers, places and rows."""
_NUMBERS[[CONSTANT, *(code for code, form in _FORMS.items() if form.count("@") == 1)]] = 2


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
    instructions = _read_instructions(function)
    if instructions is None:
        return None
    return Tape(
        function.name(),
        tuple(function.nnz_in(index) for index in inputs),
        tuple(function.nnz_out(index) for index in outputs),
        frozenset(place % len(inputs) for place in shared),
        function.sz_w(),
        *instructions,
        steps,
    )


def _read_instructions(function: Any) -> tuple[array[int], array[float]] | None:
    """Code and constants of a `Tape`; None where a line is not understood."""
    text = function.str(True).partition("Algorithm:\n")[2].rstrip("\n")
    for form in _WITH_DIGITS:
        text = text.replace(form, form.translate(_NO_DIGITS))
    lines, codes = text.split("\n"), [_CODES.get(form) for form in text.translate(_NO_DIGITS).split("\n")]
    if len(codes) != function.n_instructions():
        return None
    constants = array("d")
    for index, code in enumerate(codes):
        if code is None:
            if function.instruction_id(index) != ca.OP_CONST:
                return None
            codes[index] = CONSTANT
            lines[index] = f"{lines[index].partition(' ')[0]} {len(constants)}"  # to the last digit, below
            constants.append(function.instruction_constant(index))
    operations = np.array(codes, dtype=np.intc)
    numbers = np.fromstring("\n".join(lines).translate(_ONLY_DIGITS), dtype=np.intc, sep=" ")
    ends = np.cumsum(_NUMBERS[operations])
    if ends[-1] != len(numbers):
        return None
    code = np.stack([operations, *numbers[[ends - _NUMBERS[operations], ends - _NUMBERS[operations] + 1, ends - 1]]], 1)
    written = operations == OUTPUT
    code[written, 2:] = code[written, :1:-1]  # the register stands behind place and row
    return array("i", code.tobytes()), constants
