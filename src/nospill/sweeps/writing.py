"""A sweep as files: table, figures, page."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nospill.core.files import atomic_text
from nospill.core.units import as_written, split_unit
from nospill.errors import PlanFolderError
from nospill.plots.sweeps import Scale, SweepPicture, save_sweep_figures
from nospill.sweeps.axes import Axis
from nospill.sweeps.definition import GREATEST
from nospill.sweeps.page import sweep_page
from nospill.sweeps.record import Sweep

TABLE_FILE, PAGE_FILE, FIGURES_FOLDER = "table.csv", "index.html", "figures"


def write_sweep(sweep: Sweep, folder: Path, *, scenario: str, figures: bool = True) -> None:
    """Write table.csv, figures/ and index.html into the folder of a sweep; older ones are replaced.

    Args:
        sweep: what was planned.
        folder: where its lines are.
        scenario: as the user names the base scenario, for the commands on the page.
        figures: whether they are drawn.

    Raises:
        PlanFolderError: the disk refuses.
    """
    atomic_text(folder / TABLE_FILE, sweep.csv())
    drawn: list[Path] = []
    if figures and sweep.lines:
        place = folder / FIGURES_FOLDER
        try:
            place.mkdir(exist_ok=True)
        except OSError as error:
            raise PlanFolderError(f"{place}: cannot be written ({error.strerror or error})") from error
        drawn = save_sweep_figures(picture_of(sweep), place)
    svgs = [path.read_text(encoding="utf-8") for path in drawn if path.suffix == ".svg"]
    atomic_text(folder / PAGE_FILE, sweep_page(sweep, folder, scenario=scenario, figures=svgs))


def picture_of(sweep: Sweep) -> SweepPicture:
    """What the figures of a sweep show."""
    best = sweep.best
    goals = tuple(
        (Scale(name, _numbers(sweep.column(name))), direction == GREATEST) for name, direction in sweep.definition.goals
    )
    return SweepPicture(
        title=f"{sweep.definition.base.name}: {sweep.headline}",
        axes=tuple(_scale(sweep, axis) for axis in sweep.definition.axes),
        goals=goals,
        certified=np.array([line.certified for line in sweep.lines], dtype=bool),
        best=None if best is None else sweep.lines.index(best),
    )


def _scale(sweep: Sweep, axis: Axis) -> Scale:
    """An axis in the unit in which its values are written; words where they are no numbers of one unit."""
    values = [line.values[axis.keys[0]] for line in sweep.lines]
    parts = [split_unit(value) for value in values]
    units = {part[1] for part in parts if part is not None}
    if None not in parts and len(units) == 1:
        [unit] = units
        numbers = np.array([part[0] for part in parts if part is not None])
        return Scale(f"{axis.label} [{unit}]" if unit else axis.label, numbers)
    words = tuple(dict.fromkeys(str(value) if isinstance(value, str) else as_written(value) for value in values))
    places = [words.index(str(value) if isinstance(value, str) else as_written(value)) for value in values]
    return Scale(axis.label, np.array(places, dtype=float), words)


def _numbers(values: list[float | None]) -> np.ndarray:
    return np.array([np.nan if value is None else value for value in values], dtype=float)
