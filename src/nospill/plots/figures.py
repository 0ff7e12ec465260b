"""The table of figures, and writing them."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from nospill.core.suggestions import nearest
from nospill.errors import PlanFolderError, ScenarioError
from nospill.plans.approach import judged_motion
from nospill.plans.plan import Plan
from nospill.plots.contact_use import contact_use_figure
from nospill.plots.distances import distances_figure
from nospill.plots.evidence import Evidence, evidence_of
from nospill.plots.joints import joints_figure
from nospill.plots.limiting import limiting_figure
from nospill.plots.other_speeds import other_speeds_figure
from nospill.plots.path_view import path_figure
from nospill.plots.slosh_heights import slosh_heights_figure
from nospill.plots.style import LOOK, WIDTH
from nospill.plots.summary import summary_figure
from nospill.plots.swept_volume import swept_volume_figure
from nospill.plots.tilt import tilt_figure
from nospill.plots.tray_plan import tray_plan_figure

FIGURES: dict[str, Callable[[Evidence], Figure | None]] = {
    "limits": limiting_figure,
    "slosh-heights": slosh_heights_figure,
    "margins": contact_use_figure,
    "joints": joints_figure,
    "tilt": tilt_figure,
    "other-speeds": other_speeds_figure,
    "distances": distances_figure,
    "swept-volume": swept_volume_figure,
    "summary": summary_figure,
}
"""File name -> what draws it, None where it does not apply. A new figure is a file here and a line above."""

REPORT_FIGURES: dict[str, Callable[[Evidence], Figure | None]] = {
    "limits": limiting_figure,
    "tray": tray_plan_figure,
    "path": path_figure,
    **{name: draw for name, draw in FIGURES.items() if name not in ("limits", "summary")},
}
"""The figures of a report: what the summary sheet shows in small, and the others."""

NAMES = tuple(FIGURES | REPORT_FIGURES)
"""Of all figures."""

RESOLUTION, SHEET_RESOLUTION = 220, 150
"""Dots per inch of the PNG files; a sheet as wide as a page is sharp with fewer."""
_PNG: dict[str, Any] = {"compress_level": 1}
"""Twice as fast to write as the usual level, for files a quarter larger."""


def figure_of(plan: Plan, name: str) -> Figure:
    """One figure of a plan, on no canvas but its own.

    Raises:
        ScenarioError: there is no such figure, or it does not apply to this plan.
        ModelError: the liquids cannot be integrated along the trajectory.
    """
    draw = (FIGURES | REPORT_FIGURES).get(name)
    if draw is None:
        near = nearest(name, NAMES)
        hint = f"did you mean {near!r}?" if near else "this name is not known;"
        raise ScenarioError(f"no figure {name!r}: {hint} there are {', '.join(NAMES)}")
    with matplotlib.rc_context(LOOK):
        figure = draw(evidence_of(plan, judged_motion(plan)))
    if figure is None:
        raise ScenarioError(f"the figure {name!r} does not apply to {plan.scene.name}: it has nothing to show")
    return figure


def write_figures(
    plan: Plan,
    folder: Path,
    *,
    names: Collection[str] = (),
    pdf: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> list[Path]:
    """See `nospill.plots.save_figures`."""
    wanted = {name: draw for name, draw in FIGURES.items() if not names or name in names}
    evidence = evidence_of(plan, judged_motion(plan))
    written = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with matplotlib.rc_context(LOOK):
            for done, (name, draw) in enumerate(wanted.items()):
                if progress is not None:
                    progress(done, len(wanted))
                figure = draw(evidence)
                if figure is None:
                    continue
                written.append(folder / f"{name}.png")
                wide = figure.get_size_inches()[0] > 2 * WIDTH
                figure.savefig(written[-1], dpi=SHEET_RESOLUTION if wide else RESOLUTION, pil_kwargs=_PNG)
                if pdf:
                    written.append(folder / f"{name}.pdf")
                    # No date: the same plan gives the same bytes.
                    figure.savefig(written[-1], metadata={"CreationDate": None})
    except OSError as error:
        raise PlanFolderError(f"{folder}: the figures cannot be written ({error.strerror or error})") from error
    return written
