"""nospill: the fastest motion of a robot arm that carries open cups and loose objects on a tray, with a certificate.

import nospill as ns
scene = ns.load("matrix-liquid")
plan = ns.plan(scene)
plan.duration, plan.certificate.ok, plan.trajectory(1.2)
plan.save("out")

Public names stand in `__init__.pyi`, for type checkers and for this file alike.
"""

import ast as _ast
import importlib as _importlib
from pathlib import Path as _Path

__version__ = "0.5.0"


def _places(stub: _Path) -> dict[str, tuple[str, str]]:
    """Name -> module and name there, from `from module import name as name` and `Name = _module.NameTable`."""
    places: dict[str, tuple[str, str]] = {}
    for entry in _ast.parse(stub.read_text(encoding="utf-8")).body:
        match entry:
            case _ast.ImportFrom(module=str(module), names=names):
                places |= {str(item.asname): (module, item.name) for item in names}
            case _ast.Assign(targets=[_ast.Name(id=name)], value=_ast.Attribute(value=_ast.Name(id=alias), attr=attr)):
                places[name] = (".".join(places[alias]), attr)
    return {name: place for name, place in places.items() if not name.startswith("_")}


_PLACES = _places(_Path(__file__).with_suffix(".pyi"))
__all__ = list(_PLACES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> object:
    if name not in _PLACES:
        raise AttributeError(f"module 'nospill' has no attribute {name!r}")
    module, attribute = _PLACES[name]
    value = getattr(_importlib.import_module(module), attribute)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
