"""A hasty compiler for the tests, and what is compiled before the first of them.

Imports little: a file of tests that plans nothing is run in a second or two.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from nospill.compiled import codegen
from nospill.compiled.codegen import source_digest
from nospill.native.libraries import LIBRARIES, file_name

AT_FIRST = re.compile(
    r"linear solver"
    r"|(ur10e|comau-smart-six), \w+ tray: problem"
    r"|(solid cylinder|cylinder, [13] modes), \w+, \w+ tray: problem"
)
"""Beginnings of the labels of the parts that are compiled before the first test: what most of its plans read.

Problems of the objects, which know no arm, take 9 s together; with them a plan takes a fifth less.
"""

OFTEN = ("steps", "newton", "figures-object", "crest")
"""Kinds of functions that are evaluated so often that to compile them, a tenth of a second each, pays in one run.

Those of problems hold second derivatives and take up to 3 s; the others are as short as these and evaluated less.
"""

NO_COMPILER = "no-compiler-for-what-is-planned-once"
"""What CC names while tests run."""

COMPILED = Path(__file__).parents[1] / ".pytest_cache" / "compiled"
"""Compiled functions are kept between runs: their key is the source they are made of. `make clean` removes them."""

COMPILER = os.environ.get("CC", "cc")
"""As the user has it."""


def compile_at_first(folder: Path) -> None:
    """Compile what every worker needs, unless that has been done of this source: one that comes meanwhile goes on."""
    names = hashlib.sha256("\0".join([AT_FIRST.pattern, *map(file_name, LIBRARIES)]).encode()).hexdigest()[:8]
    done = folder / f"at-first-{source_digest()[:32]}-{names}"
    if done.exists():
        return
    from nospill.compiled.small_libraries import small_library
    from nospill.warmup.usual import usual_parts
    from nospill.warmup.warming import warm_cache

    small_library("interpreter", wait=True)
    warm_cache(tuple(part for part in usual_parts() if AT_FIRST.match(part.label)), progress=print)
    for earlier in folder.glob("at-first-*"):
        earlier.unlink()
    done.touch()


def hasty_compiler(folder: Path, *, functions: str = "-Og", solver: str = "-O3") -> Path | None:
    """A compiler that optimises less, None where there is no compiler.

    -Og takes three quarters of the time of -O1, and its functions take as long; with -O0, which compiles in half of the
    time, they take ten times as long, since every operation on four columns goes through memory. The linear solver
    (-O3) is optimised.

    Args:
        folder: where it is put.
        functions: how far they are optimised; -O0 where they are compared and little else.
        solver: how far the linear solver is; -O0 where it solves one problem.
    """
    found, place = shutil.which(COMPILER), folder / "cc"
    if found is None:
        return None
    less = f'case "$*" in *-O1*) set -- "$@" {functions} ;; *-O3*) set -- "$@" {solver} ;; esac'
    place.write_text(f'#!/bin/sh\n{less}\nexec "{found}" "$@"\n')
    place.chmod(0o755)
    return place


def compile_frequent_functions(compiler: Path, patch: pytest.MonkeyPatch) -> None:
    """Have functions of some kinds compiled when they are first asked for.

    A replay is thousands of steps, also of an object that is seen once. A test that names a compiler itself, or none,
    has what it names.
    """
    made = codegen.functions

    def functions(kind: str, *arguments: Any, **options: Any) -> Any:
        with pytest.MonkeyPatch.context() as own:
            if kind in OFTEN and os.environ.get("CC") == NO_COMPILER:
                own.setenv("CC", str(compiler))
            return made(kind, *arguments, **options)

    patch.setattr(codegen, "functions", functions)
