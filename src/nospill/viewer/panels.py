"""What the charts beside the scene hold: lines and limits of a plan over time, and what holds it back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.certification.limiting import limiting_names, limiting_rows
from nospill.core.short_names import short_names
from nospill.drawing.timeline import Film
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.scene.cargo import titles_of

_MOST_LANES, _EVERY = 6, 4
"""Lanes of a plan; of so many instants of the judge one is drawn."""


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a panel: its name, times (m,) s and values (m,) in the panel's unit."""

    name: str
    t: np.ndarray
    values: np.ndarray


@dataclass(frozen=True, slots=True)
class Limit:
    """A limit of a panel: its value, its name, and the time in s from which it holds."""

    value: float
    name: str
    start: float = 0.0


@dataclass(frozen=True, slots=True)
class Panel:
    """Lines over time with limits, all in the unit of the title; from `low` to `high`; `note` stands below."""

    title: str
    lines: tuple[Line, ...]
    limits: tuple[Limit, ...]
    low: float
    high: float
    note: str = ""


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


def contents(film: Film, before: str) -> list[tuple[int, Panel | Lanes]]:
    """A plan's panels, titled with `before` in front, with their rank from top to bottom."""
    return [*_lanes(film, before), *_panels(film, before)]


def _lanes(film: Film, before: str) -> list[tuple[int, Lanes]]:
    """What holds a plan back, with its rank; nothing where the motion comes near no limit."""
    rows = limiting_rows(film.judgement, film.plan.scene)[:_MOST_LANES]
    names = limiting_names([item.row for item in rows], film.plan.scene.robot.joints)
    lanes = [
        Lane(name, item.share, item.t[::_EVERY], item.use[::_EVERY], item.at_limit[::_EVERY])
        for name, item in zip(names, rows, strict=True)
    ]
    return [(0, Lanes(f"{before}what holds it back (hatched)", tuple(lanes)))] if lanes else []


def _panels(film: Film, before: str) -> list[tuple[int, Panel]]:
    """A plan's panels with their rank from top to bottom."""
    panels: list[tuple[int, Panel]] = []
    titles = titles_of(film.plan.scene.cargo)
    if film.liquids:
        limits, note = _height_limits(film)
        lines = [Line(titles[name], film.t, 1e3 * track.height) for name, track in film.liquids.items()]
        # A liquid that leaves its cup must not squeeze the others; 1.6 limits show that it did.
        reached = min(max(float(np.max(line.values)) for line in lines), 1.6 * limits[0].value)
        highest = max(limits[0].value, reached)
        panels.append((1, Panel(f"{before}liquid height [mm]", tuple(lines), limits, 0.0, 1.15 * highest, note)))
    uses = [Line(titles[name], film.t, use) for name, use in film.contact_use.items()]
    if uses:
        top = float(np.clip(1.1 * max(np.max(line.values) for line in uses), 1.15, 2.0))
        panels.append((2, Panel(f"{before}contact, use of limit [1]", tuple(uses), (Limit(1.0, "limit 1"),), 0.0, top)))
    speeds = [
        Line(name, film.t, film.joint_speed_use[:, index])
        for index, name in enumerate(short_names(film.plan.scene.robot.joints))
    ]
    reach = max(1.15, 1.05 * max(float(np.max(np.abs(line.values))) for line in speeds))
    both = (Limit(1.0, "limit 1"), Limit(-1.0, "limit -1"))
    panels.append((3, Panel(f"{before}joint speed over limit [1]", tuple(speeds), both, -reach, reach)))
    return panels


def _height_limits(film: Film) -> tuple[tuple[Limit, ...], str]:
    """Limits of the heights, mm, the highest first, named by the objects they are of; those after the end in words."""
    titles = titles_of(film.plan.scene.cargo)
    heights = {titles[name]: track.limit for name, track in film.liquids.items()}
    rows = [row for row in film.judgement.certificate.rows if row.constraint == ResidualHeight.name]
    later = _group_limits({titles.get(row.subject, row.label): row.limit for row in rows}, len(film.liquids))
    # The end has no space for names, and the limits there are near each other.
    limits = (
        *(Limit(value, name) for value, name in _group_limits(heights, len(film.liquids))),
        *(Limit(value, "", film.end_time) for value, _ in later),
    )
    return limits, f"limit after the end: {'; '.join(name for _, name in later)}" if later else ""


def _group_limits(limits: dict[str, float], all_of_them: int) -> list[tuple[float, str]]:
    """Limits in mm with their text, the highest first; the objects are named where not all have the same."""
    found = []
    for value in sorted(set(limits.values()), reverse=True):
        names = [name for name, own in limits.items() if own == value]
        whose = "" if len(names) == all_of_them else f" {', '.join(names)}"
        found.append((1e3 * value, f"{1e3 * value:.3g} mm{whose}"))
    return found
