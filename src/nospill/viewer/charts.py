"""Charts beside the scene as one SVG picture, the same in the live viewer and in the file.

Four panels a plan over one time axis: which limits hold the motion back and when, heights of the liquids, use of the
contact limits, joint speeds; limits are drawn and named. The cursor over them is placed by three properties of a style
sheet, so that nothing else is sent while time goes on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from nospill.core.short_names import cut, cut_apart, short_names
from nospill.film.colours import GREY, RED, SERIES, SVG_DASHES, USE_STOPS, use_colours
from nospill.film.timeline import Film
from nospill.judge.limiting import limiting_names, limiting_rows

WIDTH = 320
"""Of the picture, px."""
_LEFT, _RIGHT, _PANEL, _TITLE, _KEY, _AXIS = 34, 8, 84, 15, 12, 15
_LANE, _MOST_LANES, _SHADES, _EVERY = 19, 6, 16, 4
"""Height of a lane, px; lanes; steps of their colour; of so many instants of the judge one is drawn."""
_LONGEST_NAME = 22
_HATCH = (
    "<defs><pattern id='nospill-hatch' width='4' height='4' patternUnits='userSpaceOnUse' "
    "patternTransform='rotate(45)'><path d='M0 0v4' stroke='#000' stroke-width='1.6'/></pattern></defs>"
)
_FONT = "font-family='system-ui,-apple-system,Segoe UI,DejaVu Sans,sans-serif'"
_RATE, _MOST_POINTS = 200.0, 420
_CURSOR_STYLE = (
    f".nospill-cursor{{position:absolute;top:2px;bottom:{_AXIS + 12}px;left:var(--nospill-x,-9999px);"
    "border-left:1px solid #222;pointer-events:none}"
    ".nospill-cursor::after{content:var(--nospill-t);position:absolute;top:0;left:0;white-space:nowrap;"
    "font:10px/10px system-ui,sans-serif;color:#222;transform:translateX(var(--nospill-shift))}"
)


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a panel: its name, times (m,) s and values (m,) in the panel's unit."""

    name: str
    t: np.ndarray
    values: np.ndarray


@dataclass(frozen=True, slots=True)
class Panel:
    """Lines over time with limits (value, name), all in the unit of the title; from `low` to `high`."""

    title: str
    lines: tuple[Line, ...]
    limits: tuple[tuple[float, str], ...]
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Lane:
    """A limit over time: its name, share of the time at it, times (m,) s, use (m,), and whether it is at it (m,)."""

    name: str
    share: float
    t: np.ndarray
    use: np.ndarray
    at_limit: np.ndarray


@dataclass(frozen=True, slots=True)
class Lanes:
    """Limits over time, one below the other: colour is the use, hatched where the motion is at the limit."""

    title: str
    lanes: tuple[Lane, ...]


@dataclass(frozen=True, slots=True)
class Charts:
    """The picture and what the cursor needs.

    Attributes:
        svg: the picture, as wide as its place.
        height: of it where it is `WIDTH` px wide, px.
        left, right: where time 0 and `length` (s) lie, px.
    """

    svg: str
    height: int
    left: float
    right: float
    length: float

    def cursor_at(self, t: float) -> float:
        """Where time t lies, in hundredths of the picture's width."""
        part = float(np.clip(t / self.length, 0.0, 1.0))
        return 100.0 * (self.left + (self.right - self.left) * part) / WIDTH

    def cursor_style(self, t: float) -> str:
        """Style sheet that puts the cursor of `page` to time t."""
        x = self.cursor_at(t)
        shift = "4px" if x < 75.0 else "calc(-100% - 4px)"
        return f":root{{--nospill-x:{x:.2f}%;--nospill-t:'{t:.2f} s';--nospill-shift:{shift}}}"

    @property
    def page(self) -> str:
        """The picture with a cursor over it, as HTML; `cursor_style` says where the cursor is."""
        return (
            f"<style>{_CURSOR_STYLE}</style><div style='position:relative;line-height:0'>{self.svg}"
            "<div class='nospill-cursor'></div></div>"
        )


def draw_charts(films: Sequence[Film], titles: Sequence[str]) -> Charts:
    """Panels of one or several plans on one time axis; where there are several, titled, and like below like."""
    length = max(film.length for film in films)
    found: list[tuple[int, Panel | Lanes]] = []
    for film, title in zip([film.at_rate(_RATE) for film in films], titles, strict=True):
        before = f"{title}: " if len(films) > 1 else ""
        found += [*_limits(film, before), *_panels(film, before)]
    pieces, y = [_HATCH], 14.0
    for _, panel in sorted(found, key=lambda item: item[0]):
        if isinstance(panel, Lanes):
            pieces.append(_draw_lanes(panel, y, length))
            y += _TITLE + _LANE * len(panel.lanes) + 10
        else:
            pieces.append(_draw(panel, y, length))
            y += _panel_height(panel)
    pieces.append(_time_axis(y - 6, length))
    height = round(y + _AXIS + 4)
    svg = f"<svg style='width:100%;height:auto' viewBox='0 0 {WIDTH} {height}' {_FONT}>{''.join(pieces)}</svg>"
    return Charts(svg, height, _LEFT, WIDTH - _RIGHT, length)


def colour_key() -> str:
    """The scale of colours as a picture, with what carries it."""
    stops = "".join(f"<stop offset='{stop}' stop-color='{colour}'/>" for stop, colour in USE_STOPS)
    right = WIDTH - _RIGHT - 76
    ticks = "".join(
        f"<text x='{_LEFT + (right - _LEFT) * value}' y='31' font-size='9' text-anchor='middle'>{label}</text>"
        for value, label in ((0.0, "0"), (0.5, "half"), (1.0, "limit"))
    )
    return (
        f"<svg style='width:100%;height:auto' viewBox='0 0 {WIDTH} 36' {_FONT} fill='#222'>"
        f"<defs><linearGradient id='nospill-use'>{stops}</linearGradient></defs>"
        "<text x='0' y='9' font-size='10'>Colour: use of a limit. Liquid: height; band at the foot: contact.</text>"
        f"<rect x='{_LEFT}' y='13' width='{right - _LEFT}' height='9' fill='url(#nospill-use)'/>"
        f"<rect x='{right + 36}' y='13' width='12' height='9' fill='#000'/>"
        f"<text x='{right + 42}' y='31' font-size='9' text-anchor='middle'>broken</text>{ticks}</svg>"
    )


def _limits(film: Film, before: str) -> list[tuple[int, Lanes]]:
    """What holds a plan back, with its rank; nothing where the motion comes near no limit."""
    rows = limiting_rows(film.judgement)[:_MOST_LANES]
    names = limiting_names([item.row for item in rows], film.plan.scene.robot.joints)
    lanes = [
        Lane(name, item.share, item.t[::_EVERY], item.use[::_EVERY], item.at_limit[::_EVERY])
        for name, item in zip(names, rows, strict=True)
    ]
    return [(0, Lanes(f"{before}what holds it back (/// at limit)", tuple(lanes)))] if lanes else []


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


def _panels(film: Film, before: str) -> list[tuple[int, Panel]]:
    """A plan's panels with their rank from top to bottom."""
    panels: list[tuple[int, Panel]] = []
    if film.liquids:
        limits = sorted({track.limit for track in film.liquids.values()})
        lines = [Line(name, film.t, 1e3 * track.height) for name, track in film.liquids.items()]
        # A liquid that leaves its cup must not squeeze the others; 1.6 limits show that it did.
        reached = min(max(float(np.max(line.values)) for line in lines), 1.6e3 * limits[-1])
        highest = max(1e3 * limits[-1], reached)
        named = tuple((1e3 * limit, f"{1e3 * limit:.3g} mm") for limit in limits)
        panels.append((1, Panel(f"{before}liquid height [mm]", tuple(lines), named, 0.0, 1.15 * highest)))
    uses = [Line(name, film.t, use) for name, use in film.contact_use.items()]
    if uses:
        top = float(np.clip(1.1 * max(np.max(line.values) for line in uses), 1.15, 2.0))
        panels.append((2, Panel(f"{before}contact, use of limit [1]", tuple(uses), ((1.0, "limit 1"),), 0.0, top)))
    speeds = [
        Line(name, film.t, film.joint_speed_use[:, index])
        for index, name in enumerate(short_names(film.plan.scene.robot.joints))
    ]
    reach = max(1.15, 1.05 * max(float(np.max(np.abs(line.values))) for line in speeds))
    both = ((1.0, "limit 1"), (-1.0, "limit -1"))
    panels.append((3, Panel(f"{before}joint speed over limit [1]", tuple(speeds), both, -reach, reach)))
    return panels


def _panel_height(panel: Panel) -> float:
    return _TITLE + _PANEL + _KEY * len(_key_rows(panel)) + 10


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
    for value, label in panel.limits:
        y = float(height(value))
        beside = y - 2
        pieces.append(
            f"<line x1='{_LEFT}' x2='{right}' y1='{y:.1f}' y2='{y:.1f}' stroke='{RED}' stroke-width='1.2'/>"
            f"<text x='{right - 2}' y='{beside:.1f}' font-size='9' text-anchor='end' fill='#9A4300'>{label}</text>"
        )
    pieces.append(_key(panel, lower))
    return "".join(pieces)


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
    pieces = []
    for tick in _ticks(0.0, length):
        x = _LEFT + (WIDTH - _LEFT - _RIGHT) * tick / length
        pieces.append(
            f"<line x1='{x:.1f}' x2='{x:.1f}' y1='{y}' y2='{y + 3}' stroke='{GREY}'/>"
            f"<text x='{x:.1f}' y='{y + 13}' font-size='9' text-anchor='middle' fill='#444'>{tick:g}</text>"
        )
    right = WIDTH - _RIGHT
    pieces.append(f"<line x1='{_LEFT}' x2='{right}' y1='{y}' y2='{y}' stroke='{GREY}'/>")
    pieces.append(f"<text x='{right}' y='{y + 23}' font-size='9' text-anchor='end' fill='#444'>time [s]</text>")
    return "".join(pieces)


def _ticks(low: float, high: float) -> list[float]:
    """Two to five round values inside an axis."""
    span = high - low
    power = 10.0 ** np.floor(np.log10(span / 3))
    step = next(step for step in (power, 2 * power, 5 * power, 10 * power) if span / step <= 5)
    first, last = int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9))
    return [round(number * step, 10) for number in range(first, last + 1)]
