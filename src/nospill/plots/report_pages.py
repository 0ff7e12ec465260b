"""The pages of a report: figures as SVG text, and everything as one PDF."""

from __future__ import annotations

import io
from typing import Any

import matplotlib
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from nospill.plots.evidence import Evidence
from nospill.plots.figures import REPORT_FIGURES
from nospill.plots.style import LOOK
from nospill.plots.summary import summary_figure
from nospill.plots.text_pages import PAPER, TextTable, text_pages

_ROOM = 0.4
"""in; left free at least round a figure on its sheet."""


def report_svgs(evidence: Evidence) -> dict[str, str]:
    """The figures that apply, by name, as SVG text with letters as outlines; the same plan gives the same text."""
    found = {}
    look: dict[Any, Any] = {**LOOK, "svg.hashsalt": "nospill"}
    with matplotlib.rc_context(look):
        for name, draw in REPORT_FIGURES.items():
            figure = draw(evidence)
            if figure is not None:
                text = io.StringIO()
                empty = dict.fromkeys(("Creator", "Date", "Format", "Type"))
                figure.savefig(text, format="svg", metadata=empty)
                found[name] = text.getvalue()
    return found


def report_pdf(evidence: Evidence, tables: tuple[TextTable, ...]) -> bytes:
    """The summary sheet, the tables and every figure on sheets of A4, as the bytes of a PDF.

    Args:
        evidence: the plan and its judgement.
        tables: printed between the summary sheet and the figures.
    """
    buffer = io.BytesIO()
    about: dict[str, Any] = {"CreationDate": None, "Title": evidence.plan.scene.name}
    with matplotlib.rc_context(LOOK), PdfPages(buffer, metadata=about) as pages:
        pages.savefig(summary_figure(evidence))
        for sheet in text_pages(tables, evidence.plan.scene.name):
            pages.savefig(sheet)
        for draw in REPORT_FIGURES.values():
            figure = draw(evidence)
            if figure is not None:
                pages.savefig(figure, bbox_inches=_sheet(figure))
    return buffer.getvalue()


def _sheet(figure: Figure) -> Bbox:
    """A sheet of A4 with the figure in its middle, in in of the figure; a larger one where the figure is larger."""
    width, height = figure.get_size_inches()
    sheet_width, sheet_height = max(PAPER[0], width + 2 * _ROOM), max(PAPER[1], height + 2 * _ROOM)
    left, bottom = (width - sheet_width) / 2, (height - sheet_height) / 2
    return Bbox.from_bounds(left, bottom, sheet_width, sheet_height)
