"""C source of functions that are evaluated on four columns at once, by SIMD instructions.

A stage function has up to some ten thousand operations without a branch, and is evaluated at every node. Here each
operation is one on four doubles (the vector types of GCC and clang), which come from four columns. So four columns take
hardly longer than one, and every one of them gets the same operations in the same order: the results are those of the
function itself, to the last bit.

The operations are cut into parts of 500, each a C function; what one part has from another is kept in memory. A
compiler takes more than linear time for the registers of one long function.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import accumulate
from pathlib import Path
from typing import Any

import casadi as ca

COLUMNS = 4
"""Columns that are evaluated at once."""
_PART = 500
"""Operations of a part."""

_ON_VECTORS = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "{0} + {0}",
    ca.OP_INV: "ALL(1.0) / {0}",
}
_ON_NUMBERS = {
    ca.OP_SQRT: "sqrt({0})",
    ca.OP_SIN: "sin({0})",
    ca.OP_COS: "cos({0})",
    ca.OP_TAN: "tan({0})",
    ca.OP_ASIN: "asin({0})",
    ca.OP_ACOS: "acos({0})",
    ca.OP_ATAN: "atan({0})",
    ca.OP_ATAN2: "atan2({0}, {1})",
    ca.OP_EXP: "exp({0})",
    ca.OP_LOG: "log({0})",
    ca.OP_POW: "pow({0}, {1})",
    ca.OP_CONSTPOW: "pow({0}, {1})",
    ca.OP_SINH: "sinh({0})",
    ca.OP_COSH: "cosh({0})",
    ca.OP_TANH: "tanh({0})",
    ca.OP_FABS: "fabs({0})",
    ca.OP_FMIN: "fmin({0}, {1})",
    ca.OP_FMAX: "fmax({0}, {1})",
    ca.OP_SIGN: "({0} < 0.0 ? -1.0 : {0} > 0.0 ? 1.0 : {0})",
    ca.OP_LT: "({0} < {1})",
    ca.OP_LE: "({0} <= {1})",
    ca.OP_EQ: "({0} == {1})",
    ca.OP_NE: "({0} != {1})",
    ca.OP_NOT: "(!{0})",
    ca.OP_AND: "({0} && {1})",
    ca.OP_OR: "({0} || {1})",
    ca.OP_IF_ELSE_ZERO: "({0} ? {1} : 0.0)",
}
"""CasADi's operations of symbols in C, column by column."""

HEADER = """
#include <math.h>
#include <stdint.h>
typedef double four __attribute__((vector_size(32)));
#define ALL(x) ((four){x, x, x, x})

static void load(const double* columns, long long rows, four* to) {
  for (long long i = 0; i < rows; ++i)
    to[i] = columns ? (four){columns[i], columns[rows + i], columns[2 * rows + i], columns[3 * rows + i]} : ALL(0.0);
}

static void load_shared(const double* column, long long rows, four* to) {
  for (long long i = 0; i < rows; ++i) to[i] = ALL(column ? column[i] : 0.0);
}

static void store(const four* from, long long rows, double* columns) {
  if (!columns) return;
  for (long long i = 0; i < rows; ++i) {
    columns[i] = from[i][0];
    columns[rows + i] = from[i][1];
    columns[2 * rows + i] = from[i][2];
    columns[3 * rows + i] = from[i][3];
  }
}
"""
"""What every file of such functions begins with."""


_TEXT = _ON_VECTORS | {
    operation: f"(four){{{{{', '.join(each.format(f'{{0}}[{i}]', f'{{1}}[{i}]') for i in range(COLUMNS))}}}}}"
    for operation, each in _ON_NUMBERS.items()
}
"""On vectors, with places for the operands."""

_Statement = tuple[str, tuple[int, ...], int | None]
"""Expression with a place for each operand; the numbers of the statements whose values they are; and where it is an
output of the function, its place in memory.
"""


@dataclass(slots=True)
class _Memory:
    """Places of inputs, then of outputs, then of what one part has from another."""

    inputs: list[int]
    outputs: list[int]
    size: int
    between: dict[int, int] = field(default_factory=dict)

    @staticmethod
    def of(function: Any) -> _Memory:
        inputs = [function.nnz_in(index) for index in range(function.n_in())]
        outputs = [function.nnz_out(index) for index in range(function.n_out())]
        *starts, size = accumulate([*inputs, *outputs], initial=0)
        return _Memory(starts[: len(inputs)], starts[len(inputs) :], size)

    def add(self, value: int) -> None:
        if value not in self.between:
            self.between[value] = self.size
            self.size += 1


def is_possible(function: Any) -> bool:
    """Whether a function can be evaluated on four columns: of symbols, dense columns, with operations known here."""
    if not function.is_a("SXFunction"):
        return False
    sizes = [(function.nnz_in(index), function.size1_in(index)) for index in range(function.n_in())]
    sizes += [(function.nnz_out(index), function.size1_out(index)) for index in range(function.n_out())]
    known = {*_ON_VECTORS, *_ON_NUMBERS, ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT}
    operations = {function.instruction_id(index) for index in range(function.n_instructions())}
    return all(count == rows for count, rows in sizes) and operations <= known


def source(function: Any, shared: Collection[int]) -> str:
    """An external function of four columns in C, to stand behind `HEADER`.

    Args:
        function: `is_possible`.
        shared: places of the inputs that are the same for all columns, one column of the external function's too.
    """
    name, memory = function.name(), _Memory.of(function)
    statements = _statements(function, memory)
    for number, (_, operands, _) in enumerate(statements):
        for value in operands:
            if value // _PART != number // _PART:
                memory.add(value)
    parts = [f"{name}_part_{first // _PART}" for first in range(0, len(statements), _PART)]
    lines = [line for index, part in enumerate(parts) for line in _part(part, statements, index * _PART, memory)]
    lines += [
        f"int {name}(const double** arg, double** res, long long* iw, double* w, int mem) {{",
        "  four* m = (four*)(((uintptr_t)w + 31) / 32 * 32);",
    ]
    for index, place in enumerate(memory.inputs):
        load = "load_shared" if index in shared else "load"
        lines.append(f"  {load}(arg[{index}], {function.nnz_in(index)}, m + {place});")
    lines += [f"  {part}(m);" for part in parts]
    for index, place in enumerate(memory.outputs):
        lines.append(f"  store(m + {place}, {function.nnz_out(index)}, res[{index}]);")
    lines += ["  return 0;", "}"]
    return "\n".join([*lines, *_interface(function, shared, memory.size), ""])


def _statements(function: Any, memory: _Memory) -> list[_Statement]:
    """One for each instruction; operands are numbers of instructions, since CasADi uses the places of values again."""
    statements: list[_Statement] = []
    value: dict[int, int] = {}
    for number in range(function.n_instructions()):
        operation = function.instruction_id(number)
        read, written = function.instruction_input(number), function.instruction_output(number)
        if operation == ca.OP_OUTPUT:
            statements.append(("{0}", (value[read[0]],), memory.outputs[written[0]] + written[1]))
            continue
        if operation == ca.OP_INPUT:
            text, operands = f"m[{memory.inputs[read[0]] + read[1]}]", ()
        elif operation == ca.OP_CONST:
            text, operands = f"ALL({_number(function.instruction_constant(number))})", ()
        else:
            text, operands = _TEXT[operation], tuple([value[place] for place in read])
        statements.append((text, operands, None))
        value[written[0]] = number
    return statements


def _number(constant: float) -> str:
    """A constant in C, exact; infinite ones have names."""
    return {"inf": "INFINITY", "-inf": "-INFINITY", "nan": "NAN"}.get(repr(constant), float(constant).hex())


def _part(name: str, statements: Sequence[_Statement], first: int, memory: _Memory) -> Iterator[str]:
    """The C function of the statements from the first on."""
    yield f"static __attribute__((noinline)) void {name}(four* m) {{"
    loaded: set[int] = set()
    for number, (text, operands, output) in enumerate(statements[first : first + _PART], first):
        for value in operands:
            if value < first and value not in loaded:
                loaded.add(value)
                yield f"  four a{value} = m[{memory.between[value]}];"
        expression = text.format(*[f"a{value}" for value in operands])
        if output is not None:
            yield f"  m[{output}] = {expression};"
            continue
        yield f"  four a{number} = {expression};"
        if number in memory.between:
            yield f"  m[{memory.between[number]}] = a{number};"
    yield "}"


def _interface(function: Any, shared: Collection[int], memory: int) -> Iterator[str]:
    """What CasADi asks an external function: numbers and shapes of inputs and outputs, and its work space."""
    name, inputs, outputs = function.name(), function.n_in(), function.n_out()
    shapes_in = [(function.size1_in(index), 1 if index in shared else COLUMNS) for index in range(inputs)]
    shapes_out = [(function.size1_out(index), COLUMNS) for index in range(outputs)]
    for kind, shapes in (("in", shapes_in), ("out", shapes_out)):
        table = ", ".join(f"{{{rows}, {columns}, 1}}" for rows, columns in shapes)
        yield f"long long {name}_n_{kind}(void) {{ return {len(shapes)}; }}"
        yield f"const long long* {name}_sparsity_{kind}(long long i) {{"
        yield f"  static const long long shapes[][3] = {{{table}}};"
        yield f"  return 0 <= i && i < {len(shapes)} ? shapes[i] : 0;"
        yield "}"
    yield f"int {name}_work(long long* sz_arg, long long* sz_res, long long* sz_iw, long long* sz_w) {{"
    yield f"  if (sz_arg) *sz_arg = {inputs};"
    yield f"  if (sz_res) *sz_res = {outputs};"
    yield "  if (sz_iw) *sz_iw = 0;"
    yield f"  if (sz_w) *sz_w = {COLUMNS * memory + COLUMNS};"
    yield "  return 0;"
    yield "}"


@lru_cache(maxsize=1)
def flags() -> tuple[str, ...]:
    """Compiler flags for the vector instructions of this processor, as far as they are known."""
    try:
        words = Path("/proc/cpuinfo").read_text(encoding="utf-8").split()
    except OSError:
        return ()
    return ("-mavx2",) if "avx2" in words else ()
