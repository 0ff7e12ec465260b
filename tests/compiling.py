"""How the tests compile: a hasty compiler, and what is compiled before the first of them."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from nospill.judge import replay, traces
from nospill.transcription import clearance_block, export_samples, object_block, stage_functions, tray_block

AT_FIRST = ("linear solver", "ur10e")
"""Beginnings of the labels of usual parts: what most plans of the tests need, and takes longest to compile."""

COMPILER = os.environ.get("CC", "cc")
"""As the user has it."""

_KEPT = (
    stage_functions.stage_functions,
    tray_block._block,
    object_block._object_block,
    object_block._end_block,
    clearance_block.clearance_block,
    traces.object_figures_function,
    traces.tray_figures_function,
    replay.arm_motion,
    replay.liquid_steps,
    export_samples.tray_function,
    export_samples.crest_function,
)
"""What a process keeps of functions once made."""


def forget() -> None:
    """Let the process make its functions anew, as the settings then say."""
    for kept in _KEPT:
        kept.cache_clear()


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
