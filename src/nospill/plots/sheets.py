"""Sheets of A4 with several figures on each, as one PDF."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

if TYPE_CHECKING:  # loaded where a PDF is written: a page does without
    from matplotlib.backends.backend_pdf import PdfFile

PAPER = (8.27, 11.69)
"""in; A4 upright."""

_POINTS = 72.0
"""Per in."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A figure on a sheet: how far its upper left corner is from that of the sheet, in, and how much it is reduced."""

    figure: Figure
    left: float
    top: float
    scale: float


@dataclass(frozen=True, slots=True)
class Sheet:
    """A sheet: a figure of the paper's size with everything that is text, and the figures placed on it."""

    page: Figure
    placed: list[Placed] = field(default_factory=list)


def pdf_of(sheets: Sequence[Sheet], about: dict[str, Any]) -> bytes:
    """The sheets as a PDF; to be called inside `matplotlib.rc_context(LOOK)`.

    Args:
        sheets: of A4.
        about: metadata, as matplotlib takes it.
    """
    from matplotlib.backends.backend_pdf import PdfFile

    buffer = io.BytesIO()
    file = PdfFile(buffer, metadata=about)
    for sheet in sheets:
        file.newPage(*PAPER)
        for item in (Placed(sheet.page, 0.0, 0.0, 1.0), *sheet.placed):
            _draw(file, item)
    file.finalize()
    file.close()
    return buffer.getvalue()


def _draw(file: PdfFile, item: Placed) -> None:
    from matplotlib.backends.backend_pdf import Op, RendererPdf

    figure = item.figure
    figure.dpi = _POINTS
    width, height = figure.get_size_inches()
    left, bottom = _POINTS * item.left, _POINTS * (PAPER[1] - item.top - item.scale * height)
    file.output(Op.gsave)
    file.output(item.scale, 0, 0, item.scale, left, bottom, Op.concat_matrix)
    renderer = RendererPdf(file, _POINTS, height, width)
    figure.draw(renderer)
    renderer.finalize()
    file.output(Op.grestore)
