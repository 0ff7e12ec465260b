"""Derived columns of a sweep: arithmetic on what is known of a point, in a language of its own.

Expressions are read by Python's parser and evaluated here, node by node; nothing else of Python can be said in them.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from nospill.core.suggestions import nearest
from nospill.core.units import as_written
from nospill.errors import ScenarioError

_BINARY: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_UNARY: dict[type[ast.unaryop], Callable[[float], float]] = {ast.UAdd: operator.pos, ast.USub: operator.neg}
_FUNCTIONS: dict[str, Callable[..., Any]] = {"min": min, "max": max, "abs": abs, "sqrt": math.sqrt}
_LONGEST = 500
_ADVICE = "+ - * / **, brackets, numbers, names of columns, min, max, abs and sqrt are allowed"


@dataclass(frozen=True, slots=True)
class Column:
    """A derived column.

    Attributes:
        name: of the column.
        text: its expression, as "3600 / duration_s".
        tree: parsed.
    """

    name: str
    text: str
    tree: ast.expr

    @property
    def reads(self) -> frozenset[str]:
        """Names of the columns it is computed from."""
        names = {node.id for node in ast.walk(self.tree) if isinstance(node, ast.Name)}
        return frozenset(names - set(_FUNCTIONS))

    def value(self, known: Mapping[str, float]) -> float | None:
        """Its value where the others are known; None where one is missing or there is no such number."""
        try:
            found = _value(self.tree, known)
        except (KeyError, ArithmeticError, ValueError, TypeError):
            return None
        return float(found) if isinstance(found, int | float) and math.isfinite(found) else None


def column_of(name: str, text: object) -> Column:
    """A column from its name and expression.

    Raises:
        ScenarioError: it is no arithmetic; one line that names the column.
    """
    if not isinstance(text, str) or not text.strip() or len(text) > _LONGEST:
        raise ScenarioError(f'column {name}: {as_written(text)} is no expression; write "3600 / duration_s"')
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ScenarioError(f"column {name}: {as_written(text)} cannot be read; {_ADVICE}") from None
    _require_arithmetic(tree, name, text)
    return Column(name, text.strip(), tree)


def columns_of(given: Mapping[str, object], known: set[str]) -> tuple[Column, ...]:
    """Columns in their order, each from those that are known and those before it.

    Raises:
        ScenarioError: as `column_of`, or an expression reads what no column is called.
    """
    found: list[Column] = []
    names = set(known)
    for name, text in given.items():
        column = column_of(name, text)
        unknown = sorted(column.reads - names)
        if unknown:
            near = nearest(unknown[0], names)
            hint = f'did you mean "{near}"?' if near else f"there are {', '.join(sorted(names))}"
            raise ScenarioError(f"column {name}: there is no column {unknown[0]}; {hint}")
        if name in known:
            raise ScenarioError(f"column {name}: is the name of a column that is there already; choose another")
        found.append(column)
        names.add(name)
    return tuple(found)


def _require_arithmetic(node: ast.AST, name: str, text: str) -> None:
    match node:
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
            inner: list[ast.AST] = [left, right]
        case ast.UnaryOp(op=op, operand=operand) if type(op) in _UNARY:
            inner = [operand]
        case ast.Call(func=ast.Name(id=called), args=arguments, keywords=[]) if called in _FUNCTIONS and arguments:
            inner = list(arguments)
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            inner = []
        case ast.Name():
            inner = []
        case _:
            raise ScenarioError(f"column {name}: {as_written(text)} is no arithmetic; {_ADVICE}")
    for entry in inner:
        _require_arithmetic(entry, name, text)


def _value(node: ast.AST, known: Mapping[str, float]) -> float:
    match node:
        case ast.BinOp(left=left, op=op, right=right):
            return _BINARY[type(op)](_value(left, known), _value(right, known))
        case ast.UnaryOp(op=op, operand=operand):
            return _UNARY[type(op)](_value(operand, known))
        case ast.Call(func=ast.Name(id=called), args=arguments):
            return _FUNCTIONS[called](*(_value(entry, known) for entry in arguments))
        case ast.Constant(value=int() | float() as number):
            return float(number)
        case ast.Name(id=name):
            return float(known[name])
    raise TypeError(type(node).__name__)
