"""The pages of a report: figures as SVG text, and everything as one PDF."""

from __future__ import annotations

import io
import textwrap
from typing import Any

import matplotlib
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from nospill.certification.height_order import flow_note, height_note
from nospill.certification.wording import full_model_note, verdict_line
from nospill.plots.evidence import Evidence
from nospill.plots.figures import REPORT_FIGURES
from nospill.plots.sheets import pdf_of
from nospill.plots.style import BLUE, DARK_RED, INK, LOOK, plain
from nospill.plots.text_pages import TEXT_WIDTH, FigureRow, TextTable, printable, text_pages
from nospill.plots.tiles import MOST_IN_A_ROW, task_text, tiles
from nospill.plots.use_table import certificate_figure

_FIRST, _LAST = ("limits", "path"), "tray"
"""Figures on the first sheet, and the last one; they stand side by side, two and two."""
_HEADING = 1.72
"""in; height of name, verdict and headline figures, where the verdict takes two lines."""
_LINE = 0.115
"""in; height of a line in the box of the verdict."""
_GOOD = "#00704F"


def report_svgs(evidence: Evidence) -> dict[str, str]:
    """The figures that apply, by name, as SVG text with letters as outlines; the same plan gives the same text."""
    svgs = {}
    look: dict[Any, Any] = {**LOOK, "svg.hashsalt": "nospill"}
    with matplotlib.rc_context(look):
        for name, draw in REPORT_FIGURES.items():
            figure = draw(evidence)
            if figure is not None:
                text = io.StringIO()
                empty = dict.fromkeys(("Creator", "Date", "Format", "Type"))
                figure.savefig(text, format="svg", metadata=empty)
                svgs[name] = text.getvalue()
    return svgs


def report_pdf(evidence: Evidence, first: tuple[TextTable, ...], last: tuple[TextTable, ...], footer: str) -> bytes:
    """Verdict, tables, certificate and figures on upright sheets of A4 with page numbers, as the bytes of a PDF.

    Args:
        evidence: the plan and its judgement.
        first: tables between the verdict with the first figures and the certificate.
        last: tables after the other figures.
        footer: at the foot of every sheet, beside its number.
    """
    certificate = evidence.judgement.certificate
    about: dict[str, Any] = {
        "CreationDate": None,
        "Title": evidence.plan.scene.name,
        "Subject": f"{evidence.end_time:.3f} s, {verdict_line(certificate)}",
        "Creator": "nospill",
    }
    with matplotlib.rc_context(LOOK):
        order = [*_FIRST, *(name for name in REPORT_FIGURES if name not in (*_FIRST, _LAST)), _LAST]
        drawn = (REPORT_FIGURES[name](evidence) for name in order)
        pictures = tuple(figure for figure in drawn if figure is not None)
        rows = [FigureRow(pictures[index : index + 2]) for index in range(0, len(pictures), 2)]
        heading = FigureRow((_heading(evidence),))
        table = FigureRow((certificate_figure(evidence, TEXT_WIDTH),), "Certificate")
        return pdf_of(text_pages((heading, *rows[:1], *first, table, *rows[1:], *last), footer), about)


def _heading(evidence: Evidence) -> Figure:
    """Name, verdict in a box, headline figures."""
    scene, certificate = evidence.plan.scene, evidence.judgement.certificate
    said = textwrap.wrap("; ".join(filter(None, (evidence.limiting_text, evidence.plan.savings_text))), 95)
    notes = full_model_note(certificate), height_note(scene), flow_note(scene)
    beyond = [line for note in notes for line in textwrap.wrap(note[:1].upper() + note[1:], 144)]
    below = 0.9 + _LINE * max(len(said) - 2, 0)
    foot = max(0.98, below + _LINE * len(beyond) + 0.02)
    height = _HEADING + foot - 0.98
    figure = Figure(figsize=(TEXT_WIDTH, height))
    color = _GOOD if certificate.ok else DARK_RED

    def write(x: float, y: float, text: str, **look: Any) -> None:
        figure.text(x / TEXT_WIDTH, 1 - y / height, plain(printable(text), 150), va="top", **look)

    write(0.0, 0.0, scene.name, size=15, weight="bold")
    names = ", ".join(item.name for item in scene.cargo)
    write(0.0, 0.28, task_text(scene, names), size=7.5, color=INK)
    size = (1.0, (foot - 0.48) / height)
    box = Rectangle((0.0, 1 - foot / height), *size, facecolor="none", edgecolor=color, linewidth=1.5)
    figure.add_artist(box)
    write(0.12, 0.52, certificate.word.upper(), size=11, weight="bold", color=color)
    write(0.12, 0.75, verdict_line(certificate).partition(": ")[2], size=7.5)
    if said:
        write(2.5, 0.51, "What holds it back", size=7, color=INK)
    for line, words in enumerate(said):
        write(2.5, 0.625 + _LINE * line, words, size=6.8)
    for line, words in enumerate(beyond):
        write(0.12, below + _LINE * line, words, size=6.8)
    shown = tiles(evidence)[:MOST_IN_A_ROW]
    for index, tile in enumerate(shown):
        x = TEXT_WIDTH * index / len(shown)
        write(x, foot + 0.14, tile.value, size=9, weight="bold", color=BLUE if tile.ok else DARK_RED)
        for line, words in enumerate(textwrap.wrap(tile.label, int(120 / len(shown)))[:3]):
            write(x, foot + 0.33 + 0.11 * line, words, size=6.5, color=INK)
    return figure
