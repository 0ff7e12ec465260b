"""The plan of the tray seen from above: a picture whose objects are dragged, and what the dragging reports.

Drawn in mm, x to the right, y up. The picture is SVG in an HTML element, whose handlers follow the pointer in the
browser, move and snap the object at once, and write every move into a text field beside it, which the studio reads. The
next picture, with what overlaps in colour, comes back while the drag goes on, so nothing is kept in the picture itself.
Objects take the focus in their order on the tray and are moved by the arrow keys (`page_script`).
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from nospill.drawing.colours import BLUE, RED
from nospill.studio.placing import GRID, Placed

WIDTH = 400
"""px; of the picture on the screen at most."""

_MARGIN = 24.0
"""mm round the tray, for objects over its edge and for the scale."""
_SOLID, _EMPTY = "#8F80A0", "#777777"
_MOVES_EVERY = 60
"""ms between two reports of a drag."""
_SLACK = 3
"""px a press may move and still be a click."""


@dataclass(frozen=True, slots=True)
class DragReport:
    """What the picture says of a drag.

    Attributes:
        index: of the object.
        at: x, y on the tray, m, not snapped; None for a mere click.
        ended: whether the object was let go.
        count: of the reports so far, which the next picture repeats.
    """

    index: int
    at: tuple[float, float] | None
    ended: bool
    count: int


def read_drag(text: str, *, objects: int) -> DragReport | None:
    """The report in the text field; None where it is none of ours or of an object there is not."""
    try:
        report = json.loads(text)
        index, ended, count = report["object"], report["end"], report["count"]
        at = None if report["x"] is None else (float(report["x"]) / 1e3, float(report["y"]) / 1e3)
    except (ValueError, TypeError, KeyError):
        return None
    if type(index) is not int or type(ended) is not bool or type(count) is not int or not 0 <= index < objects:
        return None
    if at is not None and not all(math.isfinite(x) and abs(x) < 100.0 for x in at):
        return None
    return DragReport(index, at, ended, count)


def draw_plan(
    placed: Sequence[Placed],
    size: tuple[float, float] | None,
    *,
    selected: int,
    snapping: bool,
    count: int = 0,
    missing: Sequence[str] = (),
) -> str:
    """The picture as HTML, followed by the words for what is wrong.

    Args:
        placed: the objects.
        size: of the tray, m; None while it cannot be read.
        selected: number of the object that is marked.
        snapping: whether drags keep to the grid.
        count: of the last report that is in the picture.
        missing: labels of objects whose place or sides cannot be read.
    """
    x, y = (1e3 * side for side in size or (0.3, 0.3))
    wide, high = x + 2 * _MARGIN, y + 2 * _MARGIN
    pieces = [_board(x, y)] if size else []
    pieces += [_object(item, marked=item.index == selected) for item in placed]
    grid = 1e3 * GRID if snapping else 0.0
    height = min(WIDTH * high / wide, 460.0)
    picture = (
        f"<svg id='nospill-tray' role='group' aria-label='plan of the tray' data-count='{count}' "
        f"data-grid='{grid:g}' onpointerdown='{_HANDLER}' xmlns='http://www.w3.org/2000/svg' "
        f"viewBox='{-wide / 2:g} {-high / 2:g} {wide:g} {high:g}' "
        f"style='display:block;width:100%;height:{height:.0f}px;touch-action:none;user-select:none;"
        "-webkit-user-select:none;font-family:system-ui,sans-serif'>"
        f"<defs><pattern id='nospill-wrong' width='6' height='6' patternUnits='userSpaceOnUse' "
        f"patternTransform='rotate(45)'><rect width='6' height='6' fill='#fff'/><rect width='3' height='6' "
        f"fill='{RED}' fill-opacity='0.45'/></pattern></defs>{''.join(pieces)}</svg>"
    )
    words = _words(placed, missing)
    return f"<div id='nospill-plan' style='padding:4px 10px'><style>{_HIDE}</style>{picture}{words}</div>"


_HIDE = "div:has(>#nospill-plan)+div{display:none}"
"""The text field that the drags are written into follows the picture; nobody needs to see it."""


def _board(x: float, y: float) -> str:
    lines = []
    for position in _marks(x):
        lines.append(f"<line x1='{position:g}' x2='{position:g}' y1='{-y / 2:g}' y2='{y / 2:g}'/>")
    for position in _marks(y):
        lines.append(f"<line y1='{position:g}' y2='{position:g}' x1='{-x / 2:g}' x2='{x / 2:g}'/>")
    numbers = [
        f"<text x='{position:g}' y='{y / 2 + 11:g}' text-anchor='middle'>{position:g}</text>" for position in _marks(x)
    ] + [
        f"<text x='{-x / 2 - 3:g}' y='{-position + 3:g}' text-anchor='end'>{position:g}</text>"
        for position in _marks(y)
    ]
    return (
        f"<rect x='{-x / 2:g}' y='{-y / 2:g}' width='{x:g}' height='{y:g}' rx='4' fill='#f3e9d8' stroke='#a08a63'/>"
        f"<g stroke='#ddcdb0' stroke-width='0.6'>{''.join(lines)}</g>"
        f"<g font-size='9' fill='#555'>{''.join(numbers)}"
        f"<text x='{x / 2 + 2:g}' y='{y / 2 + 20:g}' text-anchor='end'>x [mm]</text>"
        f"<text x='{-x / 2 - 3:g}' y='{-y / 2 - 6:g}' text-anchor='middle'>y [mm]</text></g>"
    )


def _marks(side: float) -> list[float]:
    """Round values along a side, mm, at most nine of them."""
    step = next(step for step in (50.0, 100.0, 200.0, 500.0, 1e3, 2e3, 5e3, 1e4, 1e5) if side / step <= 8.5)
    most = int(side / 2 // step)
    return [step * number for number in range(-most, most + 1)]


def _object(item: Placed, *, marked: bool) -> str:
    x, y = 1e3 * item.position
    colour = BLUE if item.filled else _SOLID
    look = (
        f"fill='{colour}' fill-opacity='{0.45 if marked else 0.28}' stroke='{colour}'"
        if item.fits
        else f"fill='url(#nospill-wrong)' stroke='{RED}'"
    )
    look += f" stroke-width='{2.4 if marked else 1.2}'"
    if item.radius is not None:
        body = f"<circle r='{1e3 * item.radius:g}' {look}/>"
        if item.reach > 1.0:
            body += f"<circle r='{1e3 * item.reach * item.radius:g}' fill='none' stroke='{colour}' stroke-width='0.6'/>"
    else:
        assert item.corners is not None
        points = " ".join(f"{1e3 * px:g},{-1e3 * py:g}" for px, py in item.corners - item.position)
        body = f"<polygon points='{points}' {look}/>"
    name = escape(item.label if len(item.label) <= 14 else f"{item.label[:13]}…", quote=True)
    halo = "paint-order='stroke' stroke='#fff' stroke-width='2.5' stroke-linejoin='round'"
    return (
        f"<g id='nospill-object-{item.index}' tabindex='0' role='button' aria-pressed='{str(marked).lower()}' "
        f"aria-label='{escape(item.label, quote=True)}, x {x:.4g}, y {y:.4g} mm' "
        f"data-object='{item.index}' data-x='{x:.4f}' data-y='{y:.4f}' "
        f"data-fits='{str(item.fits).lower()}' transform='translate({x:.4f} {-y:.4f})' style='cursor:grab'>{body}"
        f"<circle r='1' fill='#222'/><text y='-5' font-size='11' font-weight='{600 if marked else 400}' "
        f"text-anchor='middle' fill='#222' {halo}>{name}</text>"
        f"<text class='nospill-at' y='12' font-size='9' text-anchor='middle' fill='#222' {halo}>"
        f"{x:.4g}, {y:.4g}</text></g>"
    )


def _words(placed: Sequence[Placed], missing: Sequence[str]) -> str:
    lines = [
        f"{item.label} stands {1e3 * item.off_tray:.3g} mm over the edge" for item in placed if item.off_tray > 0.0
    ]
    pairs = {tuple(sorted((item.label, other))) for item in placed for other in item.overlaps}
    lines += [f"{first} and {second} overlap" for first, second in sorted(pairs)]
    lines += [f"{label} cannot be drawn: its place or its sides are wrong" for label in missing]
    text = (
        "; ".join(lines) if lines else "Drag an object or press its arrow keys to move it; click it to edit it below."
    )
    look = "color:#9A4300;font-weight:600" if lines else "color:#555"
    return (
        f"<div id='nospill-plan-words' style='font-size:12px;line-height:1.35;min-height:17px;{look}'>"
        f"{escape(text)}</div>"
    )


_HANDLER = escape(
    " ".join(
        """
(function (event, svg) {
  var node = event.target.closest('[data-object]');
  if (!node || event.button) return;
  event.preventDefault();
  var number = +node.dataset.object, id = node.id, from = [+node.dataset.x, +node.dataset.y];
  var down = [event.clientX, event.clientY], at = from, moving = false, last = 0;
  function current() { return document.getElementById('nospill-tray'); }
  function point(x, y) {
    var m = current().getScreenCTM().inverse();
    return [m.a * x + m.c * y + m.e, -(m.b * x + m.d * y + m.f)];
  }
  var held = point(down[0], down[1]);
  function say(x, y, end) { window.nospillSay(number, x, y, end); }
  node.focus({preventScroll: true});
  function show() {
    var group = document.getElementById(id);
    if (!group) return;
    group.setAttribute('transform', 'translate(' + at[0] + ' ' + -at[1] + ')');
    group.querySelector('.nospill-at').textContent = +at[0].toFixed(2) + ', ' + +at[1].toFixed(2);
  }
  function move(e) {
    if (!moving && Math.hypot(e.clientX - down[0], e.clientY - down[1]) < SLACK) return;
    moving = true;
    var p = point(e.clientX, e.clientY), grid = +current().dataset.grid;
    at = [from[0] + p[0] - held[0], from[1] + p[1] - held[1]];
    if (grid) at = [Math.round(at[0] / grid) * grid, Math.round(at[1] / grid) * grid];
    show();
    var now = performance.now();
    if (now - last >= EVERY) { last = now; say(at[0], at[1], false); }
  }
  function stop(e) {
    window.removeEventListener('pointermove', move);
    window.removeEventListener('pointerup', stop);
    window.removeEventListener('pointercancel', stop);
    if (moving) { say(at[0], at[1], true); show(); } else say(null, null, true);
  }
  window.addEventListener('pointermove', move);
  window.addEventListener('pointerup', stop);
  window.addEventListener('pointercancel', stop);
})(event, this)
""".replace("SLACK", str(_SLACK))
        .replace("EVERY", str(_MOVES_EVERY))
        .split()
    ),
    quote=True,
)
"""What a press on the picture starts; `nospillSay` of the page's script hands its reports over."""
