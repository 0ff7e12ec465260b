"""What stands over a drawn picture: name, running time, verdict, who is first, and how near the limits are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from nospill.drawing.colours import RED, use_colours
from nospill.drawing.timeline import Film

HEIGHT = 720.0
"""px; of the picture that the sizes below are for."""
_INK, _SOFT, _GREEN, _TRACK = "#1b2530", "#3f4a55", "#00704f", "#d3d8de"
_LARGE, _MEDIUM, _SMALL = 50, 30, 23
_MARGIN, _BAR, _BAR_WIDTH = 24, 14, 190
_NOTHING = 5e-3
"""s; who is first by less is not said to be."""
_BAND = 0.72
"""How white the band at the foot is, over what the picture shows there."""


@dataclass(frozen=True, slots=True)
class Caption:
    """What a panel says at one picture.

    Attributes:
        title: name of the motion.
        clock: running time.
        verdict: how it ended, empty until then.
        good: whether the verdict is one to be glad of.
        bars: name and use of a limit.
    """

    title: str
    clock: str
    verdict: str
    good: bool
    bars: tuple[tuple[str, float], ...]


def titles_of(films: Sequence[Film]) -> list[str]:
    """Names of motions: "level tray" and "tilting tray" where that tells plans apart, else the scenarios' names."""
    kinds = ["level tray" if film.plan.scene.stays_level else "tilting tray" for film in films]
    if len(films) > 1 and len(set(kinds)) == len(kinds):
        return kinds
    names = [film.plan.scene.name for film in films]
    return names if len(set(names)) == len(names) else [f"{name} ({index + 1})" for index, name in enumerate(names)]


def caption(films: Sequence[Film], number: int, t: float) -> Caption:
    """What the panel of one of several films says at time t in s."""
    film = films[number]
    done = t >= film.end_time - 1e-9
    fastest = min(other.end_time for other in films)
    status = film.plan.status
    if not done:
        verdict = ""
    elif len(films) > 1 and film.end_time == fastest:
        ahead = sorted(other.end_time for other in films)[1] - fastest
        verdict = (
            f"{ahead:.2f} s ({100 * ahead / (fastest + ahead):.0f} %) sooner, {status}" if ahead > 5e-3 else status
        )
    else:
        verdict = status
    index = film.index(t)
    bars = []
    if film.liquids:
        bars.append(("liquid", max(float(track.height[index] / track.limit) for track in film.liquids.values())))
    if film.contact_use:
        bars.append(("contact", max(float(use[index]) for use in film.contact_use.values())))
    return Caption(
        title=titles_of(films)[number],
        clock=f"{min(t, film.end_time):.2f} s",
        verdict=verdict,
        good=film.plan.certificate.ok,
        bars=tuple(bars),
    )


def write_over(picture: np.ndarray, captions: Sequence[Caption], *, speed: float) -> np.ndarray:
    """A picture (height, width, 3) with the captions of its panels, which stand side by side."""
    scale = picture.shape[0] / HEIGHT
    band = picture.shape[0] - round((_MARGIN + 32 * max(len(item.bars) for item in captions) + 12) * scale)
    picture = picture.copy()
    picture[band:] = np.rint(_BAND * 255.0 + (1.0 - _BAND) * picture[band:])
    image = Image.fromarray(picture)
    pen = ImageDraw.Draw(image)
    width = image.width / len(captions)
    for number, item in enumerate(captions):
        left = number * width
        if number:
            pen.line([(left, 0), (left, image.height)], fill=_TRACK, width=max(1, round(2 * scale)))
        _panel(pen, item, left, width, image.height, scale)
    note = "real time" if speed == 1.0 else f"{speed:g}x speed"
    pen.text(
        (image.width - _MARGIN * scale, image.height - _MARGIN * scale),
        note,
        font=_font(_SMALL * scale),
        fill=_SOFT,
        anchor="rs",
    )
    return np.asarray(image)


def _panel(pen: ImageDraw.ImageDraw, item: Caption, left: float, width: float, height: int, scale: float) -> None:
    x, right, y = left + _MARGIN * scale, left + width - _MARGIN * scale, _MARGIN * scale
    _bold(pen, (x, y), item.title, _MEDIUM * scale, _INK, "la")
    _bold(pen, (right, y - 6 * scale), item.clock, _LARGE * scale, _GREEN if item.verdict and item.good else _INK, "ra")
    if item.verdict:
        colour = _GREEN if item.good else RED
        _bold(pen, (x, y + 36 * scale), item.verdict, _SMALL * scale, colour, "la")
    line = height - _MARGIN * scale
    for name, use in reversed(item.bars):
        pen.text((x, line), name, font=_font(_SMALL * scale), fill=_INK, anchor="ls")
        start = x + 94 * scale
        box = (start, line - _BAR * scale, start + _BAR_WIDTH * scale, line)
        pen.rectangle(box, fill=_TRACK)
        colour = tuple(int(channel) for channel in use_colours(np.array([use]))[0])
        pen.rectangle((box[0], box[1], start + min(use, 1.0) * _BAR_WIDTH * scale, box[3]), fill=colour)
        pen.line([(box[2], box[1] - 4 * scale), (box[2], box[3] + 4 * scale)], fill=RED, width=max(1, round(3 * scale)))
        pen.text((box[2] + 8 * scale, line), "limit", font=_font(_SMALL * scale), fill=_SOFT, anchor="ls")
        line -= 32 * scale


def _bold(pen: ImageDraw.ImageDraw, at: tuple[float, float], text: str, size: float, colour: str, anchor: str) -> None:
    """The font has one weight; a line round its letters makes them bold."""
    stroke = 0.022 * size
    pen.text(at, text, font=_font(size), fill=colour, anchor=anchor, stroke_width=stroke, stroke_fill=colour)


_fonts: dict[int, ImageFont.FreeTypeFont | ImageFont.ImageFont] = {}


def _font(size: float) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """The font that Pillow brings along, so that no file of the system is needed."""
    key = max(round(size), 8)
    if key not in _fonts:
        _fonts[key] = ImageFont.load_default(key)
    return _fonts[key]
