"""One HTML page of a sweep: figures, a plot whose points can be picked, the table; no network."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Sequence
from html import escape
from pathlib import Path

import tomli_w

from nospill.sweeps.page_parts import SCRIPT, STYLE
from nospill.sweeps.points import Line
from nospill.sweeps.record import Sweep
from nospill.sweeps.run import PLANS_FOLDER

_HIDDEN = ("key",)
_LOOK_AT_MOTION, _LOOK_AT_CYCLE = "view", "check"
"""Commands for the folder of a plan."""


def sweep_page(sweep: Sweep, folder: Path, *, scenario: str, figures: Sequence[str]) -> str:
    """The page.

    Args:
        sweep: what was planned.
        folder: where the page and the plans are.
        scenario: as the user names the base scenario.
        figures: SVG texts.
    """
    rows = sweep.rows
    columns = [name for name in rows[0] if name not in _HIDDEN] if rows else []
    look = _LOOK_AT_CYCLE if sweep.definition.base.is_cycle else _LOOK_AT_MOTION
    data = {
        "columns": columns,
        "rows": [[row[name] for name in columns] for row in rows],
        "axes": [axis.keys[0] for axis in sweep.definition.axes],
        "goal": sweep.definition.goals[0][0],
        "open": [_opening(line, folder, scenario, look) for line in sweep.lines],
        "best": None if sweep.best is None else sweep.lines.index(sweep.best),
    }
    title = f"{sweep.definition.base.name}: {sweep.headline}"
    endings = ", ".join(f"{count} {ending}" for ending, count in sweep.endings.items())
    said = "".join(f"<p>{escape(text)}</p>" for text in (endings, sweep.cold_text) if text)
    # "</" ends a script wherever it stands
    text = json.dumps(data, allow_nan=False).replace("</", "<\\/")
    drawn = "".join(f"<figure>{_inner(svg)}</figure>" for svg in figures)
    return (
        "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>\n"
        # The page forbids the browser to fetch anything.
        "<meta http-equiv='Content-Security-Policy' "
        "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n"
        f"<h1>{escape(title)}</h1>{said}\n<div class='figures'>{drawn}</div>\n"
        "<section><h2>Points</h2><p>A click on a point or a row opens it.</p><div class='pick'>"
        "<label>across <select id='across'></select></label> <label>up <select id='up'></select></label></div>"
        "<div class='both'><svg id='plot' viewBox='0 0 640 400' role='img'></svg><div id='one'></div></div></section>\n"
        "<section><h2>Table</h2><div class='wide'><table id='table'></table></div></section>\n"
        f"</main>\n<script id='data' type='application/json'>{text}</script>\n<script>{SCRIPT}</script>\n"
        "</body>\n</html>\n"
    )


def _opening(line: Line, folder: Path, scenario: str, look: str) -> dict[str, str | None]:
    """Where the plan of a point is, and the command that shows or makes it."""
    kept = folder / PLANS_FOLDER / line.key
    if kept.is_dir():
        return {"link": f"{PLANS_FOLDER}/{line.key}/", "command": f"nospill {look} {shlex.quote(str(kept))}"}
    settings = " ".join(f"--set {shlex.quote(f'{key}={_toml(value)}')}" for key, value in line.values.items())
    return {"link": None, "command": f"nospill plan {shlex.quote(scenario)} {settings} -o {line.key}"}


def _toml(value: object) -> str:
    return tomli_w.dumps({"v": value}, multiline_strings=False).removeprefix("v = ").strip().replace("\n", " ")


def _inner(svg: str) -> str:
    """The drawing without the declaration of a document, its names kept apart from those of other drawings."""
    start = svg.index("<svg")
    mark = re.sub(r"\W", "", str(abs(hash(svg)) % 10**8))
    drawing = re.sub(r"<metadata>.*?</metadata>", "", svg[start:], flags=re.DOTALL)
    text = re.sub(r'id="([^"]+)"', rf'id="{mark}\1"', drawing)
    return re.sub(r"(url\(#|href=\"#)", rf"\g<1>{mark}", text)
