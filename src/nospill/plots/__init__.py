"""Figures of a plan. Importing this package does not import matplotlib; drawing does."""

from __future__ import annotations

import gc
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nospill.plans.plan import Plan


FIRST_FIGURES = ("summary",)
"""Figures that the command `plan` draws: the summary sheet, which shows the others in small.

Drawing them all takes longer than planning; a second one alone, a twentieth of the command's time.
"""


def save_figures(
    plan: Plan,
    folder: Path,
    *,
    names: Collection[str] = (),
    pdf: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> list[Path]:
    """Draw the figures that apply to a plan and write them as PNG and, on request, as PDF (vector).

    They show what the joints in the file do, not what the optimiser meant: `Plan.judgement` or, for a plan from a
    folder, a new judgement of its trajectory.

    Args:
        plan: the plan, certified or not.
        folder: where the files go; made if missing. Nothing else in it is touched.
        names: of the figures; all when left out.
        pdf: write both.
        progress: called with how many figures are drawn, of how many that may apply.

    Returns:
        The paths of the files, in the order written.

    Raises:
        ModelError: the liquids cannot be integrated along the trajectory.
        PlanFolderError: the trajectory does not fit the scene, or the folder cannot be written.
    """
    with _no_collection():
        # matplotlib takes a third of a second to import, which nobody else should pay.
        from nospill.plots.figures import write_figures

        return write_figures(plan, Path(folder), names=names, pdf=pdf, progress=progress)


@contextmanager
def _no_collection() -> Iterator[None]:
    """No search for cycles while figures are drawn: they are made of many small objects, all of them still in use.

    It would go through everything the planner holds, a tenth of the time of the import and the drawing.
    """
    running = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if running:
            gc.enable()
