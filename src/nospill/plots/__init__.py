"""Figures of a plan. Importing this package does not import matplotlib; drawing does."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nospill.plans.plan import Plan


FIRST_FIGURES = ("limits", "summary")
"""Figures that the command `plan` draws: the summary sheet and what holds the motion back.

The sheet shows the others in small; drawing them all takes longer than planning.
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
    # matplotlib takes a third of a second to import, which nobody else should pay.
    from nospill.plots.figures import write_figures

    return write_figures(plan, Path(folder), names=names, pdf=pdf, progress=progress)
