"""How the tests compile: a hasty compiler, and what is compiled before the first of them."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

AT_FIRST = ("linear solver", "ur10e")
"""Beginnings of the labels of usual parts: what most plans of the tests need, and takes longest to compile."""

COMPILER = os.environ.get("CC", "cc")
"""As the user has it."""


def hasty_compiler(folder: Path) -> Path | None:
    """A compiler that does not optimise what is compiled for plans, None where there is no compiler.

    That takes a fifth of the time; the functions take half as long again, and a third of what the virtual machine
    takes, with the same results. The linear solver (-O3) is optimised.

    Args:
        folder: where it is put.
    """
    found, place = shutil.which(COMPILER), folder / "cc"
    if found is None:
        return None
    place.write_text(f'#!/bin/sh\ncase "$*" in *-O1*) set -- "$@" -O0 ;; esac\nexec "{found}" "$@"\n')
    place.chmod(0o755)
    return place
