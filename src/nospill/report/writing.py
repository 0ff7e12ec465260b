"""Writing a report: HTML, and PDF on request, each whole or not at all."""

from __future__ import annotations

from pathlib import Path

from nospill.core.files import atomic_bytes, atomic_text
from nospill.plots.report_pages import report_pdf, report_svgs
from nospill.plots.text_pages import TextTable
from nospill.report.contents import NOT_PROVEN, Report, certificate_table
from nospill.report.page import html_page
from nospill.report.scene_picture import scene_picture


def save_report(report: Report, path: str | Path, *, pdf: str | Path | None = None) -> int:
    """Write a report.

    Args:
        report: what it says.
        path: of the HTML file; an earlier one is replaced.
        pdf: of the PDF, if there is to be one.

    Returns:
        Size of the HTML file, bytes.

    Raises:
        PlanFolderError: a file cannot be written.
    """
    text = html_page(report, report_svgs(report.evidence), scene_picture(report.evidence))
    atomic_text(path, text)
    if pdf is not None:
        first, last = pdf_tables(report)
        atomic_bytes(Path(pdf), report_pdf(report.evidence, first, last, pdf_footer(report)))
    return len(text.encode())


def pdf_tables(report: Report) -> tuple[tuple[TextTable, ...], tuple[TextTable, ...]]:
    """The tables of a report before and after its certificate and figures, in the order of its pages."""
    opinion = report.opinion
    second = TextTable("A second opinion", (), ((opinion.message,),)) if opinion.table is None else opinion.table
    run = report.executed
    last = (
        *(() if run is None else (run.rows, run.heights) if run.figure else (run.rows,)),
        *(() if report.stops is None else (report.stops,)),
        report.warnings,
        second,
        report.joints,
        report.planning,
        TextTable("What the certificate does not prove", (), NOT_PROVEN),
        report.versions,
        certificate_table(report.certificate, everything=True),
    )
    return (report.task, report.cargo), last


def pdf_footer(report: Report) -> str:
    """What stands at the foot of every sheet: the name, the verdict, the checksum of the trajectory."""
    return f"{report.evidence.plan.scene.name} · {report.verdict} · SHA-256 of trajectory.csv {report.checksum[:16]}"
