"""Names of the Python interface: a table for the page, and the directives that the site puts in its place."""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path
from typing import Any

import nospill

_PACKAGE = Path(str(nospill.__file__)).parent
_PUBLIC = {getattr(nospill, name): f"nospill.{name}" for name in nospill.__all__}
"""What `import nospill` gives -> its name there."""


def thing(name: str) -> Any:
    """What a dotted name stands for.

    Raises:
        AttributeError: there is none of that name.
    """
    module, _, last = name.rpartition(".")
    return getattr(importlib.import_module(module), last)


def names_table(*names: str) -> str:
    """Name, file and first sentence of each, fields and methods of a class below each other."""
    return "\n".join(_entry(name) for name in names)


def directives(*names: str) -> str:
    """The same as what Sphinx reads."""
    return "".join(_directive(name, thing(name)) for name in names)


def _entry(name: str) -> str:
    item = thing(name)
    file = Path(inspect.getfile(item)).relative_to(_PACKAGE.parents[1]).as_posix()
    signature = "" if inspect.isclass(item) else _signature(item)
    first = " ".join((inspect.getdoc(item) or "").split("\n\n")[0].split())
    return f"- [`{_PUBLIC.get(item, name)}`](../../{file}){signature and f' `{signature}`'}: {first}"


def _signature(function: Any) -> str:
    """Names of the arguments and their defaults; types stand in the file."""
    found = inspect.signature(function)
    plain = [one.replace(annotation=inspect.Parameter.empty) for one in found.parameters.values()]
    return str(found.replace(parameters=plain, return_annotation=inspect.Signature.empty))


def _directive(name: str, item: Any) -> str:
    kind = "function"
    if inspect.isclass(item):
        kind = "exception" if issubclass(item, Exception) else "class"
    members = "   :members:\n" if kind == "class" else ""
    members += "   :special-members: __call__\n" if kind == "class" and "__call__" in vars(item) else ""
    return f".. auto{kind}:: {_PUBLIC.get(item, name)}\n{members}\n"
