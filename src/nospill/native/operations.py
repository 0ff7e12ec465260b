"""What the operations of CasADi's symbolic functions are in C, by their names there (OP_ADD is ADD)."""

from __future__ import annotations

ON_VECTORS = {
    "ASSIGN": "{0}",
    "ADD": "{0} + {1}",
    "SUB": "{0} - {1}",
    "MUL": "{0} * {1}",
    "DIV": "{0} / {1}",
    "NEG": "-{0}",
    "SQ": "{0} * {0}",
    "TWICE": "{0} + {0}",
    "INV": "ALL(1.0) / {0}",
    "FABS": "(four)((mask){0} & ~(mask)ALL(-0.0))",
    "FMIN": "CHOICE(({0} < {1}) | ({1} != {1}), {0}, {1})",
    "FMAX": "CHOICE(({0} > {1}) | ({1} != {1}), {0}, {1})",
    "SIGN": "CHOICE({0} < ALL(0.0), ALL(-1.0), CHOICE({0} > ALL(0.0), ALL(1.0), {0}))",
    "LT": "ONE({0} < {1})",
    "LE": "ONE({0} <= {1})",
    "EQ": "ONE({0} == {1})",
    "NE": "ONE({0} != {1})",
    "NOT": "ONE({0} == ALL(0.0))",
    "AND": "ONE(({0} != ALL(0.0)) & ({1} != ALL(0.0)))",
    "OR": "ONE(({0} != ALL(0.0)) | ({1} != ALL(0.0)))",
    "IF_ELSE_ZERO": "(four)(({0} != ALL(0.0)) & (mask){1})",
}
"""On vectors of `HEADER`, with places for the operands.

A comparison of two vectors is a mask, all bits of a number where it holds and none elsewhere.
"""

ON_NUMBERS = {
    "SQRT": "sqrt({0})",
    "SIN": "sin({0})",
    "COS": "cos({0})",
    "TAN": "tan({0})",
    "ASIN": "asin({0})",
    "ACOS": "acos({0})",
    "ATAN": "atan({0})",
    "ATAN2": "atan2({0}, {1})",
    "EXP": "exp({0})",
    "LOG": "log({0})",
    "POW": "pow({0}, {1})",
    "CONSTPOW": "pow({0}, {1})",
    "SINH": "sinh({0})",
    "COSH": "cosh({0})",
    "TANH": "tanh({0})",
}
"""On single numbers, column by column."""

INPUT, OUTPUT, CONSTANT, FIRST = 0, 1, 2, 3
"""Codes of a tape; from `FIRST` on the operations above, in their order."""
NAMES = (*ON_VECTORS, *ON_NUMBERS)

HEADER = """
#include <math.h>
#include <stdint.h>
typedef double four __attribute__((vector_size(32)));
typedef long long mask __attribute__((vector_size(32)));
#define ALL(x) ((four){x, x, x, x})
#define ONE(where) ((four)((where) & (mask)ALL(1.0)))
#define CHOICE(where, one, other) ((four)(((where) & (mask)(one)) | (~(where) & (mask)(other))))
"""
"""What every C file with such operations begins with."""


def interpreted() -> str:
    """What the interpreter (interpreter.c) has of the operations: their codes, and a case of its switch for each."""
    cases = []
    for code, name in enumerate(NAMES, FIRST):
        on_vectors = ON_VECTORS.get(name)
        text, part, end = (on_vectors, "part", "FOURS") if on_vectors else (ON_NUMBERS[name], "of", "COLUMNS")
        expression = text.format(f"one->{part}[j]", f"other->{part}[j]")
        cases.append(f"case {code}: for (int j = 0; j < {end}; ++j) to->{part}[j] = {expression}; break;")
    codes = {"INPUT": INPUT, "OUTPUT": OUTPUT, "CONSTANT": CONSTANT}
    lines = [*(f"#define {name} {code}" for name, code in codes.items()), "#define OPERATIONS \\", " \\\n".join(cases)]
    return HEADER + "\n".join(lines) + "\n"
