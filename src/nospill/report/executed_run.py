"""The section of a report on what was executed: verdict, planned and executed uses, heights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.certification.happening import happening_line, tray_first
from nospill.certification.wording import describe, percent, row_text
from nospill.execution.bands import NOT_CERTIFIED
from nospill.execution.executed import Executed
from nospill.execution.record import band_text, height_text, log_lines, mark, open_line, tracking_lines, verdict
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plots.executed import executed_svg
from nospill.plots.text_pages import TextTable

_COLUMNS = ("constraint", "of", "planned", "executed", "noise", "value", "limit", "at [s]", "")


@dataclass(frozen=True, slots=True)
class ExecutedRun:
    """What a log says, as it is shown.

    Attributes:
        ok: whether no row of what was executed fails.
        verdict: in two or three words.
        detail: in one sentence.
        rows: of every constraint the fullest row, planned and executed.
        heights: peaks of the liquids.
        figure: SVG text, empty without liquids.
    """

    ok: bool
    verdict: str
    detail: str
    rows: TextTable
    heights: TextTable
    figure: str


def executed_run(run: Executed) -> ExecutedRun:
    """The section of a log that was judged and compared with its plan."""
    certificate = run.judgement.certificate
    line = verdict(run)
    happens = happening_line(run.without_reserve)
    detail = f"{line[:1].upper()}{line[1:]}. {happens[:1].upper()}{happens[1:]}. "
    detail += f"Nearest to its limit: {describe(certificate.worst)}."
    return ExecutedRun(
        ok=run.outcome != NOT_CERTIFIED,
        verdict=f"executed: {run.word}",
        detail=detail,
        rows=_rows(run),
        heights=_heights(run),
        figure=executed_svg(run) if run.heights else "",
    )


def _rows(run: Executed) -> TextTable:
    planned = {} if run.planned is None else {row.id: row for row in run.planned.certificate.rows}
    rows = tray_first(run.judgement.certificate.listed_rows())
    cells = []
    for row in rows:
        text, before = row_text(row), planned.get(row.id)
        cells.append(
            (
                row.constraint,
                row.subject,
                "-" if before is None else percent(before.use, before.ok),
                text.use,
                band_text(run, row),
                text.value,
                text.limit_and_unit,
                text.at,
                mark(run, row) or "holds",
            )
        )
    left_open = open_line(run)
    sentences = [*log_lines(run), *tracking_lines(run), *([left_open] if left_open else [])]
    note = " ".join(f"{sentence[:1].upper()}{sentence[1:]}." for sentence in sentences)
    failing = tuple(index for index, row in enumerate(rows) if run.outcomes[row.id] == NOT_CERTIFIED)
    return TextTable("Executed", _COLUMNS, tuple(cells), note=note, failing=failing)


def _heights(run: Executed) -> TextTable:
    peaks = {peak.subject: peak for peak in run.peaks if peak.constraint == SloshHeight.name}
    cells = []
    for name, values in run.heights.items():
        at, peak, measured = int(np.argmax(values)), peaks.get(name), run.measured.get(name)
        most = [] if peak is None else sorted(peak.by_joint.items(), key=lambda item: -abs(item[1]))[:2]
        cells.append(
            (
                name,
                "-" if peak is None else f"{1e3 * peak.planned:.2f}",
                height_text(float(values[at]), float(run.height_bands[name][at])),
                ", ".join(f"{joint} {1e3 * value:+.2g} mm" for joint, value in most) or "-",
                "-" if measured is None else f"{1e3 * measured.measured_peak:.2f}",
            )
        )
    columns = ("peak of", "planned [mm]", "executed [mm]", "added by", "measured [mm]")
    return TextTable("Executed: peaks of the liquids", columns, tuple(cells))
