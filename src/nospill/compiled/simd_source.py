"""C source of functions that are evaluated on four columns at once, by SIMD instructions.

A stage function has up to some ten thousand operations without a branch, and is evaluated at every node. Here each
operation is one on four doubles (the vector types of GCC and clang), which come from four columns. So four columns take
hardly longer than one, and every one of them gets the same operations in the same order: the results are those of the
function itself, to the last bit.

The operations are cut into parts of 500, each a C function; what one part has from another is kept in memory. A
compiler takes more than linear time for the registers of one long function.

A function of a state may run many times, one after the other (`Tape.steps`), on what is shared each time anew.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import accumulate
from pathlib import Path

from nospill.compiled.tape import Tape
from nospill.native import operations
from nospill.native.operations import FIRST, INPUT, OUTPUT

COLUMNS = 4
"""Columns that are evaluated at once."""
_PART = 500
"""Operations of a part."""

HEADER = (
    operations.HEADER
    + """
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
)
"""What every file of such functions begins with."""


_TEXT = (
    *operations.ON_VECTORS.values(),
    *(
        f"(four){{{{{', '.join(each.format(f'{{0}}[{i}]', f'{{1}}[{i}]') for i in range(COLUMNS))}}}}}"
        for each in operations.ON_NUMBERS.values()
    ),
)
"""On vectors, with places for the operands; in the order of their codes."""
_OPERANDS = tuple(2 if "{1}" in text else 1 for text in _TEXT)

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
    def of(tape: Tape) -> _Memory:
        *starts, size = accumulate([*tape.rows_in, *tape.rows_out], initial=0)
        return _Memory(starts[: len(tape.rows_in)], starts[len(tape.rows_in) :], size)

    def add(self, value: int) -> None:
        if value not in self.between:
            self.between[value] = self.size
            self.size += 1


def source(tape: Tape) -> str:
    """An external function of four columns in C, to stand behind `HEADER`; one column a step of what is shared."""
    name, memory = tape.name, _Memory.of(tape)
    statements = _statements(tape, memory)
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
    inputs = list(enumerate(zip(memory.inputs, tape.rows_in, strict=True)))
    per_column, shared = ([item for item in inputs if (item[0] in tape.shared) == wanted] for wanted in (False, True))
    lines += [f"  load(arg[{index}], {rows}, m + {place});" for index, (place, rows) in per_column]
    lines.append(f"  for (long long k = 0; k < {tape.steps}; ++k) {{")
    lines += [f"    load_shared({_at(f'arg[{index}]', rows)}, {rows}, m + {place});" for index, (place, rows) in shared]
    lines += [f"    {part}(m);" for part in parts]
    for index, (place, rows) in enumerate(zip(memory.outputs, tape.rows_out, strict=True)):
        lines.append(f"    store(m + {place}, {rows}, {_at(f'res[{index}]', COLUMNS * rows)});")
    if tape.steps > 1:
        state = f"m[{memory.inputs[0]} + i] = m[{memory.outputs[0]} + i]"
        lines.append(f"    for (long long i = 0; i < {tape.rows_in[0]}; ++i) {state};")
    lines += ["  }", "  return 0;", "}"]
    return "\n".join([*lines, *_interface(tape, memory.size), ""])


def _at(array: str, numbers: int) -> str:
    """What an array has for step k, in C; a null pointer stays one."""
    return f"{array} ? {array} + {numbers} * k : 0"


def _statements(tape: Tape, memory: _Memory) -> list[_Statement]:
    """The instructions, equal ones once; operands are numbers of statements, since a tape uses its registers again."""
    statements: list[_Statement] = []
    numbers: dict[_Statement, int] = {}
    value = [0] * tape.registers
    for operation, to, one, other in zip(*(tape.code[place::4] for place in range(4)), strict=True):
        if operation >= FIRST:
            operands = (value[one], value[other])[: _OPERANDS[operation - FIRST]]
            statement: _Statement = (_TEXT[operation - FIRST], operands, None)
        elif operation == OUTPUT:
            statements.append(("{0}", (value[one],), memory.outputs[to] + other))
            continue
        elif operation == INPUT:
            statement = (f"m[{memory.inputs[one] + other}]", (), None)
        else:
            statement = (f"ALL({_number(tape.constants[one])})", (), None)
        value[to] = numbers.setdefault(statement, len(statements))
        if value[to] == len(statements):
            statements.append(statement)
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


def _interface(tape: Tape, memory: int) -> Iterator[str]:
    """What CasADi asks an external function: numbers and shapes of inputs and outputs, and its work space."""
    name = tape.name
    shapes_in = [(rows, tape.steps if index in tape.shared else COLUMNS) for index, rows in enumerate(tape.rows_in)]
    shapes_out = [(rows, COLUMNS * tape.steps) for rows in tape.rows_out]
    for kind, shapes in (("in", shapes_in), ("out", shapes_out)):
        table = ", ".join(f"{{{rows}, {columns}, 1}}" for rows, columns in shapes)
        yield f"long long {name}_n_{kind}(void) {{ return {len(shapes)}; }}"
        yield f"const long long* {name}_sparsity_{kind}(long long i) {{"
        yield f"  static const long long shapes[][3] = {{{table}}};"
        yield f"  return 0 <= i && i < {len(shapes)} ? shapes[i] : 0;"
        yield "}"
    yield f"int {name}_work(long long* sz_arg, long long* sz_res, long long* sz_iw, long long* sz_w) {{"
    yield f"  if (sz_arg) *sz_arg = {len(shapes_in)};"
    yield f"  if (sz_res) *sz_res = {len(shapes_out)};"
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
