"""Charts beside the scene, an SVG picture each, the same in the live viewer and in the file.

Four a plan over the same time: which limits hold the motion back and when, heights of the liquids, use of the contact
limits, joint speeds; limits are drawn and named. They stand in as many columns as fit, so that their text
keeps its size. The cursor over them is placed by three properties of a style sheet, so that nothing else is sent while
time goes on.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from nospill.core.short_names import cut, cut_apart
from nospill.drawing.colours import GREY, RED, SERIES, SVG_DASHES, USE_STOPS, use_colours
from nospill.drawing.timeline import Film
from nospill.viewer.panels import Lanes, Panel, contents

WIDTH = 320
"""Of a chart, px; on the screen it is at most `_WIDEST`."""
_NARROWEST, _WIDEST = 290, 420
_LEFT, _RIGHT, _PANEL, _TITLE, _KEY, _AXIS = 34, 8, 84, 15, 12, 15
_LANE, _SHADES = 19, 16
"""Height of a lane, px; steps of its colour."""
_APART = 11.0
"""px; names of limits that are nearer than this stand at opposite ends."""
_LONGEST_NAME, _NOTE = 22, 52
"""Letters of a name in the key, and of a line below it."""
_HATCH = (
    "<defs><pattern id='nospill-hatch' width='4' height='4' patternUnits='userSpaceOnUse' "
    "patternTransform='rotate(45)'><path d='M0 0v4' stroke='#000' stroke-width='1.6'/></pattern></defs>"
)
_HALO = "paint-order='stroke' stroke='#fff' stroke-width='2'"
_FONT = "font-family='system-ui,-apple-system,Segoe UI,DejaVu Sans,sans-serif'"
_RATE, _MOST_POINTS = 200.0, 420
_STYLE = (
    f".nospill-charts{{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,{_NARROWEST}px),1fr));"
    f"gap:2px 12px}}.nospill-chart{{position:relative;line-height:0;max-width:{_WIDEST}px}}"
    ".nospill-chart svg{width:100%;height:auto}"
    f".nospill-cursor{{position:absolute;top:{_TITLE}px;bottom:{_AXIS + 6}px;left:var(--nospill-x,-9999px);"
    "border-left:1px solid #222;pointer-events:none}"
    ".nospill-charts{padding-top:12px}.nospill-chart:first-child .nospill-cursor{top:0}"
    ".nospill-chart:first-child .nospill-cursor::after{content:var(--nospill-t);position:absolute;top:-11px;left:0;"
    "white-space:nowrap;font:10px/10px system-ui,sans-serif;color:#222;transform:translateX(var(--nospill-shift))}"
)


@dataclass(frozen=True, slots=True)
class Charts:
    """The pictures and what the cursor needs.

    Attributes:
        pictures: one SVG document a chart, `WIDTH` px wide, over the same time.
        left, right: where time 0 and `length` (s) lie, px.
    """

    pictures: tuple[str, ...]
    left: float
    right: float
    length: float

    def cursor_at(self, t: float) -> float:
        """Where time t lies, in hundredths of a picture's width."""
        part = float(np.clip(t / self.length, 0.0, 1.0))
        return 100.0 * (self.left + (self.right - self.left) * part) / WIDTH

    def cursor_style(self, t: float) -> str:
        """Style sheet that puts the cursor of `page` to time t."""
        x = self.cursor_at(t)
        shift = "4px" if x < 75.0 else "calc(-100% - 4px)"
        return f":root{{--nospill-x:{x:.2f}%;--nospill-t:'{t:.2f} s';--nospill-shift:{shift}}}"

    @property
    def page(self) -> str:
        """The pictures with a cursor over each, as HTML; `cursor_style` says where the cursor is."""
        boxes = "".join(
            f"<div class='nospill-chart'>{svg}<div class='nospill-cursor'></div></div>" for svg in self.pictures
        )
        return f"<style>{_STYLE}</style><div class='nospill-charts'>{boxes}</div>"


def draw_charts(films: Sequence[Film], titles: Sequence[str]) -> Charts:
    """Charts of one or several plans over the same time; where there are several, titled, and like beside like."""
    length = max(film.length for film in films)
    found: list[tuple[int, Panel | Lanes]] = []
    for film, title in zip([film.at_rate(_RATE) for film in films], titles, strict=True):
        found += contents(film, f"{title}: " if len(films) > 1 else "")
    pictures = tuple(_picture(panel, length) for _, panel in sorted(found, key=lambda item: item[0]))
    return Charts(pictures, _LEFT, WIDTH - _RIGHT, length)


def _picture(panel: Panel | Lanes, length: float) -> str:
    """One chart with the time axis below what it shows, and the key below that."""
    if isinstance(panel, Lanes):
        body, below = _HATCH + _draw_lanes(panel, 0.0, length), float(_TITLE + _LANE * len(panel.lanes))
        key, rows = "", 0
    else:
        body, below = _draw(panel, 0.0, length), float(_TITLE + _PANEL)
        key, rows = _key(panel, below + _AXIS + 4), len(_key_rows(panel))
        notes = textwrap.wrap(panel.note, _NOTE)
        key += "".join(
            f"<text x='{_LEFT}' y='{below + _AXIS + 3 + _KEY * (rows + number)}' font-size='9' fill='#9A4300'>"
            f"{escape(line)}</text>"
            for number, line in enumerate(notes, 1)
        )
        rows += len(notes)
    height = round(below + _AXIS + 8 + _KEY * rows)
    return (
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {WIDTH} {height}' {_FONT}>{body}"
        f"{_time_axis(below, length)}{key}</svg>"
    )


def colour_key() -> str:
    """The scale of colours as a picture, with what carries it in words."""
    stops = "".join(f"<stop offset='{stop}' stop-color='{colour}'/>" for stop, colour in USE_STOPS)
    right = WIDTH - _RIGHT - 76
    ticks = "".join(
        f"<text x='{_LEFT + (right - _LEFT) * value}' y='21' font-size='9' text-anchor='middle'>{label}</text>"
        for value, label in ((0.0, "0"), (0.5, "half"), (1.0, "at the limit"))
    )
    words = (
        "Colour of a liquid: its height over its limit, the red ring. Colour at the foot: slip, tip, lift and twist "
        "over their limits. Hatched: at the limit. Arrow: apparent gravity; square to the tray, nothing pulls sideways."
    )
    return (
        f"<div class='nospill-key' style='max-width:{_WIDEST}px'>"
        f"<svg style='width:100%;height:auto' viewBox='0 0 {WIDTH} 25' {_FONT} fill='#222'>"
        f"<defs><linearGradient id='nospill-use'>{stops}</linearGradient></defs>"
        f"<rect x='{_LEFT}' y='2' width='{right - _LEFT}' height='9' fill='url(#nospill-use)'/>"
        f"<rect x='{right + 44}' y='2' width='12' height='9' fill='#000'/>"
        f"<text x='{right + 50}' y='21' font-size='9' text-anchor='middle'>broken</text>{ticks}</svg>"
        f"<div style='font:11px/1.35 system-ui,sans-serif;color:#444;margin:2px 0 8px 0'>{words}</div></div>"
    )


def _draw_lanes(panel: Lanes, top: float, length: float) -> str:
    """The lanes with their upper edge at `top` px: name and share of the time above each."""
    right = WIDTH - _RIGHT
    scale = (right - _LEFT) / length
    pieces = [
        f"<text x='{_LEFT}' y='{top + _TITLE - 4:.0f}' font-size='11' font-weight='600' fill='#222'>"
        f"{escape(panel.title)}</text>"
    ]
    for line, lane in enumerate(panel.lanes):
        y = top + _TITLE + _LANE * line
        pieces.append(
            f"<text x='{_LEFT}' y='{y + 8:.0f}' font-size='9' fill='#222'>{escape(cut(lane.name, 36))}</text>"
            f"<text x='{right}' y='{y + 8:.0f}' font-size='9' fill='#222' text-anchor='end'>"
            f"{100 * lane.share:.0f} % of the time</text>"
        )
        colours = use_colours(np.round(lane.use * _SHADES) / _SHADES)
        keys = np.column_stack([colours, lane.at_limit])
        starts = np.concatenate([[0], np.flatnonzero(np.any(keys[1:] != keys[:-1], axis=1)) + 1])
        edges = np.append(lane.t[starts], lane.t[-1])
        for start, begin, end in zip(starts, edges[:-1], edges[1:], strict=True):
            wide = scale * (end - begin) + 0.15
            place = f"x='{_LEFT + scale * begin:.1f}' y='{y + 10:.0f}' width='{wide:.1f}' height='7'"
            red, green, blue = colours[start]
            pieces.append(f"<rect {place} fill='rgb({red},{green},{blue})'/>")
            if lane.at_limit[start]:
                pieces.append(f"<rect {place} fill='url(#nospill-hatch)'/>")
    return "".join(pieces)


def _draw(panel: Panel, top: float, length: float) -> str:
    """One panel with its upper edge at `top` px."""
    upper, lower = top + _TITLE, top + _TITLE + _PANEL

    def at(t: np.ndarray) -> np.ndarray:
        return _LEFT + (WIDTH - _LEFT - _RIGHT) * t / length

    def height(values: np.ndarray | float) -> np.ndarray:
        inside = np.clip(values, panel.low, panel.high)
        return lower - _PANEL * (inside - panel.low) / (panel.high - panel.low)

    right = WIDTH - _RIGHT
    pieces = [
        f"<text x='{_LEFT}' y='{upper - 4:.0f}' font-size='11' font-weight='600' fill='#222'>"
        f"{escape(panel.title)}</text>",
        f"<rect x='{_LEFT}' y='{upper:.0f}' width='{right - _LEFT}' height='{_PANEL}' fill='#fafafa'/>",
    ]
    for tick in _ticks(panel.low, panel.high):
        y = float(height(tick))
        pieces.append(
            f"<line x1='{_LEFT}' x2='{right}' y1='{y:.1f}' y2='{y:.1f}' stroke='#e3e3e3'/>"
            f"<text x='{_LEFT - 4}' y='{y + 3:.1f}' font-size='9' text-anchor='end' fill='#444'>{tick:g}</text>"
        )
    for index, line in enumerate(panel.lines):
        every = max(1, -(-len(line.t) // _MOST_POINTS))
        inside = line.t <= length
        points = zip(at(line.t[inside][::every]), height(line.values[inside][::every]), strict=True)
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        pieces.append(
            f"<polyline points='{path}' fill='none' stroke='{SERIES[index % len(SERIES)]}' stroke-width='1.4' "
            f"stroke-dasharray='{SVG_DASHES[index % len(SVG_DASHES)]}'/>"
        )
    pieces += _limits(panel, height, lambda time: float(at(np.asarray(time))))
    return "".join(pieces)


def _limits(panel: Panel, height: Callable[[float], np.ndarray], at: Callable[[float], float]) -> list[str]:
    """Lines of the limits, each with its name at the right end, or at the left where another name is there."""
    right = WIDTH - _RIGHT
    pieces, taken = [], []
    for limit in panel.limits:
        y, start = float(height(limit.value)), at(limit.start)
        crowded = any(abs(y - other) < _APART for other in taken)
        x, anchor = (_LEFT + 2, "start") if crowded else ((start if limit.start else right) - 2, "end")
        if not crowded:
            taken.append(y)
        pieces.append(
            f"<line x1='{start:.1f}' x2='{right}' y1='{y:.1f}' y2='{y:.1f}' stroke='{RED}' stroke-width='1.2'/>"
            f"<text x='{x:.1f}' y='{y - 2:.1f}' font-size='9' text-anchor='{anchor}' fill='#9A4300' {_HALO}>"
            f"{escape(cut(limit.name, 40))}</text>"
        )
    return pieces


def _key_rows(panel: Panel) -> list[list[int]]:
    """Which lines are named in which row of the key: as many as fit."""
    rows: list[list[int]] = [[]]
    used = 0.0
    for index, line in enumerate(panel.lines):
        wide = _key_width(line.name)
        if rows[-1] and used + wide > WIDTH - _LEFT:
            rows.append([])
            used = 0.0
        rows[-1].append(index)
        used += wide
    return rows


def _key_width(name: str) -> float:
    return 30 + 5.4 * min(len(name), _LONGEST_NAME)


def _key(panel: Panel, lower: float) -> str:
    pieces = []
    names = cut_apart([line.name for line in panel.lines], _LONGEST_NAME)
    for number, row in enumerate(_key_rows(panel)):
        x, y = float(_LEFT), lower + _KEY * (number + 1) - 1
        for index in row:
            name, short = panel.lines[index].name, names[index]
            pieces.append(
                f"<line x1='{x:.0f}' x2='{x + 16:.0f}' y1='{y - 3:.0f}' y2='{y - 3:.0f}' stroke-width='1.6' "
                f"stroke='{SERIES[index % len(SERIES)]}' stroke-dasharray='{SVG_DASHES[index % len(SVG_DASHES)]}'/>"
                f"<text x='{x + 19:.0f}' y='{y:.0f}' font-size='9' fill='#222'>{escape(short)}</text>"
            )
            x += _key_width(name)
    return "".join(pieces)


def _time_axis(y: float, length: float) -> str:
    right = WIDTH - _RIGHT
    pieces = [f"<line x1='{_LEFT}' x2='{right}' y1='{y}' y2='{y}' stroke='{GREY}'/>"]
    for tick in _ticks(0.0, length):
        x = _LEFT + (right - _LEFT) * tick / length
        last = tick > 0.9 * length
        label = f"{tick:g} s"
        pieces.append(
            f"<line x1='{x:.1f}' x2='{x:.1f}' y1='{y}' y2='{y + 3}' stroke='{GREY}'/>"
            f"<text x='{right if last else round(x, 1)}' y='{y + 13}' font-size='9' "
            f"text-anchor='{'end' if last else 'middle'}' fill='#444'>{label}</text>"
        )
    return "".join(pieces)


def _ticks(low: float, high: float) -> list[float]:
    """Two to five round values inside an axis."""
    span = high - low
    power = 10.0 ** np.floor(np.log10(span / 3))
    step = next(step for step in (power, 2 * power, 5 * power, 10 * power) if span / step <= 5)
    first, last = int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9))
    return [round(number * step, 10) for number in range(first, last + 1)]
