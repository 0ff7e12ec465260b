"""Linear solvers of IPOPT's steps: LDL^T with pivots fixed beforehand, and MUMPS.

`ldl` is a library in C (`nospill.native`), carried by the wheel or compiled in the background at its first use; IPOPT
loads it as MA27. `auto` is `ldl` where that is there, and `mumps` until it is and where it cannot be had (not carried,
and no compiler or NOSPILL_COMPILE=off); a solve that ends with linear systems which `ldl` could not solve is made again
with `mumps`.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from nospill.compiled.small_libraries import small_library
from nospill.errors import ScenarioError

Settings = dict[str, Any]
"""Of IPOPT, as `casadi.nlpsol` takes them."""

UNSOLVED = (
    "Error_In_Step_Computation",
    "Restoration_Failed",
    "Internal_Error",
    "Invalid_Number_Detected",
    "Insufficient_Memory",
)
"""IPOPT's words for an end to which linear systems that were not solved, or not well enough, may have led."""


def _ldl(wait: bool) -> Settings | None:
    library = ldl_library(wait=wait)
    if library is None:
        return None
    return {
        "ipopt.linear_solver": "ma27",
        "ipopt.hsllib": str(library),
        # There is no tolerance of pivots to raise; MA27's would be raised in five vain factorisations.
        "ipopt.ma27_pivtolmax": 1e-8,
        # At rest some constraints depend on each other. MUMPS then estimates first multipliers that are too large, and
        # IPOPT takes zero; the smaller ones of ldl would be taken, and led to a worse local optimum.
        "ipopt.constr_mult_init_max": 0.0,
    }


def _mumps(_: bool) -> Settings:
    return {
        "ipopt.linear_solver": "mumps",
        # Quasi-dense minimum degree: of the orderings in MUMPS the quickest on these chains, most so with many cups.
        "ipopt.mumps_pivot_order": 6,
        # The problem is scaled; doing it again takes a tenth of each factorisation and changes no iteration.
        "ipopt.mumps_permuting_scaling": 0,
        "ipopt.mumps_scaling": 0,
    }


LINEAR_SOLVERS: dict[str, Callable[[bool], Settings | None]] = {"ldl": _ldl, "mumps": _mumps}
"""Settings by name, None where a solver cannot be had; `auto` takes them in this order, and waits for none."""


def candidates(name: str) -> list[tuple[str, Settings]]:
    """The linear solvers for a solve, name and settings: each that follows is for when the one before fails.

    Args:
        name: key of `LINEAR_SOLVERS`, or "auto".

    Raises:
        ScenarioError: it is not known, or cannot be had here.
    """
    if name != "auto" and name not in LINEAR_SOLVERS:
        known = ", ".join(["auto", *LINEAR_SOLVERS])
        raise ScenarioError(f'planning.linear_solver "{name}" is not known; allowed: {known}')
    wanted = list(LINEAR_SOLVERS) if name == "auto" else [name]
    settings = ((item, LINEAR_SOLVERS[item](name == item)) for item in wanted)
    usable = [(item, options) for item, options in settings if options is not None]
    if not usable:
        raise ScenarioError(
            f'planning.linear_solver "{name}" cannot be had here: it takes a C compiler, a private cache folder and '
            'NOSPILL_COMPILE other than off; use "auto" or "mumps"'
        )
    return usable


def ldl_library(*, wait: bool = True) -> Path | None:
    """The compiled `ldl`, checked to load; None where it cannot be had, or not yet and is not waited for."""
    library = small_library("ldl", wait=wait)
    if library is not None:
        with suppress(OSError):  # a symbol is missing; found by IPOPT it would end the process
            ctypes.CDLL(str(library))
            return library
    return None
