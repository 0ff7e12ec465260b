"""A report as one HTML page: no script, no network, figures inside."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape

from nospill.certification.verdict import Certificate, Row
from nospill.certification.wording import integrity_line, row_text
from nospill.core.short_names import short_names
from nospill.plots.text_pages import TextTable
from nospill.plots.tiles import task_text
from nospill.report.contents import NOT_PROVEN, Report, certificate_table
from nospill.report.page_style import STYLE
from nospill.report.scene_picture import MOMENT

_CAPTIONS = {
    "limits": "Every limit above 90 % of use, and at the right the part of the time for which the motion is at it.",
    "path": "With the tray at a few instants.",
    "slosh-heights": "In the joints' motion as judged; after its end the liquids swing freely.",
    "tilt": "Below: what the objects feel sideways, and what they would feel on a level tray.",
    "other-speeds": "Of the same motion, played at a part of its speed; above 100 % a limit breaks.",
    "executed": "Executed: from the log of the joints, with the band that its noise leaves.",
}
"""What a figure does not say itself."""
_RINGS = "rings at the cups: limits of their liquids, "
_FIRST, _PAIR = "limits", ("tray", "path")
_BAR_LENGTH, _LONGEST_USE = 120, 1.2
_NAMED = 8
"""Objects that the heading names."""
_LONG = 48
"""Letters of a cell that may be broken into lines."""

# Letters and strokes, so that it prints without its colour.
_SIGNS = {
    True: '<path d="M5 13l5 5L20 6" fill="none" stroke="currentColor" stroke-width="3.4"/>',
    False: '<path d="M5 5l14 14M19 5L5 19" fill="none" stroke="currentColor" stroke-width="3.4"/>',
    None: '<path d="M5 12h14" fill="none" stroke="currentColor" stroke-width="3.4"/>',
}


def html_page(report: Report, figures: Mapping[str, str], picture: bytes = b"") -> str:
    """The page.

    Args:
        report: what it says.
        figures: SVG text by name, as `plots.report_pages.report_svgs` draws them.
        picture: of the arm and its tray, JPEG.
    """
    scene = report.evidence.plan.scene
    others = [name for name in figures if name != _FIRST and name not in _PAIR]
    title = f"{scene.name}: {report.evidence.end_time:.3f} s, {report.verdict}"
    body = (
        _heading(report),
        _tiles(report),
        f"<div class='first'>{_figure(_FIRST, figures[_FIRST])}</div>" if _FIRST in figures else "",
        _photograph(report, picture),
        f"<div class='pair'>{''.join(_figure(name, figures[name]) for name in _PAIR if name in figures)}</div>",
        _section(report.task),
        _section(report.cargo),
        _certificate(report),
        _executed_section(report),
        _section(report.stops) if report.stops is not None else "",
        _section(report.warnings),
        _opinion(report),
        f"<section><h2>Figures</h2><div class='flow'>{''.join(_figure(name, figures[name]) for name in others)}</div>"
        "</section>",
        _section(report.joints),
        _section(report.planning),
        _not_proven(),
        _section(report.versions),
        _section(certificate_table(report.certificate, everything=True), small=True),
    )
    return (
        "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>\n"
        # The page forbids the browser to fetch anything.
        "<meta http-equiv='Content-Security-Policy' "
        "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n"
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(body)
        + "\n</main>\n</body>\n</html>\n"
    )


def _heading(report: Report) -> str:
    scene = report.evidence.plan.scene
    standing = [
        item.name if item.contents is None else f"{item.name} with {len(item.contents.content)} in it"
        for item in scene.standing
    ]
    more = f" and {len(standing) - _NAMED} more" if len(standing) > _NAMED else ""
    names = ", ".join(standing[:_NAMED]) + more
    return (
        f"<header><h1>{escape(scene.name)}</h1>"
        f"<p class='about'>{escape(task_text(scene, names))}.</p>"
        f"{_banner(report.ok, report.verdict.upper(), report.detail)}"
        f"{_limiting_section(report)}</header>"
    )


def _limiting_section(report: Report) -> str:
    sentence, saved = report.evidence.limiting_text, report.evidence.plan.savings_text
    more = f" {escape(saved[:1].upper() + saved[1:])}." if saved else ""
    return f"<p>What holds it back: {escape(sentence)}.{more}</p>" if sentence else ""


def _banner(ok: bool | None, verdict: str, detail: str) -> str:
    kind = {True: "yes", False: "no", None: "unknown"}[ok]
    sign = f"<svg class='sign' viewBox='0 0 24 24' aria-hidden='true'>{_SIGNS[ok]}</svg>"
    return (
        f"<div class='verdict {kind}'>{sign}<div><strong>{escape(verdict)}</strong><p>{escape(detail)}</p></div></div>"
    )


def _tiles(report: Report) -> str:
    tiles = "".join(
        f"<li{_failing(not tile.ok)}><b>{escape(tile.value)}</b> {escape(tile.label)}</li>" for tile in report.tiles
    )
    return f"<ul class='tiles'>{tiles}</ul>"


def _figure(name: str, svg: str) -> str:
    # As a picture and not as part of the page: matplotlib's style sheet and ids would reach beyond their figure.
    data = base64.b64encode(svg.encode()).decode()
    caption = escape(_CAPTIONS.get(name, ""))
    picture = f"<img alt='{escape(name)}' src='data:image/svg+xml;base64,{data}'>"
    return f"<figure>{picture}{f'<figcaption>{caption}</figcaption>' if caption else ''}</figure>"


def _photograph(report: Report, picture: bytes) -> str:
    if not picture:
        return ""
    at = f"{MOMENT * report.evidence.end_time:.2f} s"
    rings = "" if all(item.filling is None for item in report.evidence.plan.scene.cargo) else _RINGS
    caption = f"The arm and its tray after {at}; {rings}colours: use of the limits."
    data = base64.b64encode(picture).decode()
    return (
        f"<figure class='scene'><img alt='the arm, and its tray from near' src='data:image/jpeg;base64,{data}'>"
        f"<figcaption>{caption}</figcaption></figure>"
    )


def _section(table: TextTable, *, small: bool = False) -> str:
    note = f"<p class='note'>{escape(table.note)}</p>" if table.note else ""
    return f"<section><h2>{escape(table.title)}</h2>{_table(table, small=small)}{note}</section>"


def _table(table: TextTable, *, small: bool = False) -> str:
    head = "".join(f"<th scope='col'>{escape(column)}</th>" for column in table.columns)
    rows = []
    for index, row in enumerate(table.rows):
        first = f"<th scope='row'>{escape(row[0])}</th>"
        rest = "".join(
            f"<td{_column_attribute(table.columns[place : place + 1])}{_long(cell)}>{escape(cell)}</td>"
            for place, cell in enumerate(row[1:], 1)
        )
        rows.append(f"<tr{_failing(index in table.failing)}>{first}{rest}</tr>")
    head = f"<thead><tr>{head}</tr></thead>" if head else ""
    kind = ("wide" if table.columns else "facts") + (" small" if small else "")
    return f"<div class='scroll'><table class='{kind}'>{head}<tbody>{''.join(rows)}</tbody></table></div>"


def _column_attribute(columns: Sequence[str]) -> str:
    """The column's name at a cell, which a narrow screen prints in front of it."""
    return f" data-column='{escape(columns[0])}'" if columns and columns[0] else ""


def _long(cell: str) -> str:
    return " class='long'" if len(cell) > _LONG else ""


def _failing(fails: bool) -> str:
    return " class='fails'" if fails else ""


def _certificate(report: Report) -> str:
    columns = (("constraint", ""), ("of", ""), ("use of limit", ""), ("", "number"), ("value", "number"))
    columns += (("limit", "number"), ("unit", ""), ("at [s]", "number"))
    head = "".join(f"<th scope='col' class='{kind}'>{column}</th>" for column, kind in columns)
    joints = report.evidence.plan.scene.robot.joints
    short = dict(zip(joints, short_names(joints), strict=True))
    rows = "".join(_certificate_row(row, short.get(row.label, row.label)) for row in report.certificate.listed_rows())
    return (
        "<section><h2>Certificate</h2><div class='scroll'><table class='wide certificate'>"
        f"<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"
        f"{_integrity(report.certificate)}"
        "<p class='note'>Of every constraint the row that came nearest to its limit; the upright line of a bar is the "
        "limit. A fastest motion rests on some of its limits. The judge reads the exported samples and the "
        "scenario alone.</p>"
        "</section>"
    )


def _integrity(certificate: Certificate) -> str:
    """The checks of the record in one line, which opens on demand and where one of them fails."""
    checks = certificate.record_rows()
    rows = "".join(_certificate_row(row, row.label) for row in checks)
    opened = "" if all(row.ok for row in checks) else " open"
    return (
        f"<details{opened}><summary>{escape(integrity_line(certificate))}</summary><div class='scroll'>"
        f"<table class='wide certificate small'><tbody>{rows}</tbody></table></div></details>"
    )


def _certificate_row(row: Row, subject: str) -> str:
    text = row_text(row)
    cells = (
        f"<th scope='row'>{escape(row.constraint)}</th><td>{escape(subject)}</td><td>{_bar(row)}</td>"
        f"<td class='number'>{text.use}</td><td class='number'>{escape(text.value)}</td>"
        f"<td class='number'>{text.limit}</td>"
        f"<td>{escape(text.unit)}</td><td class='number'>{text.at}</td>"
    )
    return f"<tr{_failing(not row.ok)}>{cells}</tr>"


def _bar(row: Row) -> str:
    """A drawing, not a background: backgrounds are left out in print."""
    scale = _BAR_LENGTH / _LONGEST_USE
    length = scale * min(max(row.use, 0.0), _LONGEST_USE)
    look = "fill='#0072B2'" if row.ok else "fill='none' stroke='#9A4300' stroke-width='1.6'"
    word = "" if row.ok else "<text x='4' y='10' fill='#9A4300' font-size='10' font-weight='bold'>FAILS</text>"
    share = f"{row_text(row).use} of the limit"
    return (
        f"<svg class='bar' viewBox='0 0 {_BAR_LENGTH} 13' role='img' aria-label='{escape(share)}'>"
        f"<title>{escape(share)}</title><rect x='0.8' y='2' width='{max(length - 0.8, 0.4):.2f}' height='9' {look}/>"
        f"<path d='M{scale:g} 0v13' stroke='#D55E00' stroke-width='1.8'/>{word}</svg>"
    )


def _executed_section(report: Report) -> str:
    own = report.executed
    if own is None:
        return ""
    parts = [_banner(own.ok, own.verdict.upper(), own.detail), _table(own.rows)]
    parts += [f"<p class='note'>{escape(own.rows.note)}</p>"]
    if own.figure:
        parts += [_table(own.heights), f"<div class='flow'>{_figure('executed', own.figure)}</div>"]
    return f"<section><h2>{escape(own.rows.title)}</h2>{''.join(parts)}</section>"


def _opinion(report: Report) -> str:
    opinion = report.opinion
    verdict = {True: "EVERY OBJECT STAYS", False: "AN OBJECT MOVES", None: "NOT SIMULATED"}[opinion.ok]
    table = ""
    if opinion.table is not None:
        table = f"{_table(opinion.table)}<p class='note'>{escape(opinion.table.note)}</p>"
    head, _, rest = opinion.message.partition(": ")
    said_once = rest[:1].upper() + rest[1:] if rest and head.upper() == verdict else opinion.message
    return f"<section><h2>A second opinion</h2>{_banner(opinion.ok, verdict, said_once)}{table}</section>"


def _not_proven() -> str:
    entries = "".join(f"<li><b>{escape(short)}.</b> {escape(long)}</li>" for short, long in NOT_PROVEN)
    return f"<section><h2>What the certificate does not prove</h2><ul>{entries}</ul></section>"
