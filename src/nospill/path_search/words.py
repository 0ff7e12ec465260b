"""Which bodies come too near, and by how much, in words."""

from __future__ import annotations

from nospill.collisions.along_path import Nearness
from nospill.collisions.bodies import LOAD, TRAY, Body
from nospill.core.units import as_written, format_quantity
from nospill.errors import Reason
from nospill.laws.constraints.clearance import Clearance


def in_words(nearness: Nearness, where: str) -> str:
    """As 'the forearm_link enters "column" by 12 mm at s = 0.41'."""
    pair = nearness.pair
    distance = nearness.slack + pair.limit
    first, second = _name_text(pair.first), _name_text(pair.second)
    if pair.note:
        where = f"{where} ({pair.note})".lstrip()
    if pair.second.of_region:
        return f"{first} reach {_length_text(-distance)} out of {second} {where}".rstrip()
    if distance < 0.0:
        return f"{first} enters {second} by {_length_text(-distance)} {where}".rstrip()
    kept = _length_text(pair.limit)
    return f"{first} comes within {_length_text(distance)} of {second} {where}, and {kept} must be kept"


def nearness_reason(nearness: Nearness, kind: str) -> Reason:
    """The same for programs."""
    return Reason(kind, Clearance.name, nearness.pair.subject, at_s=nearness.s, excess=-nearness.slack, unit="m")


def _name_text(body: Body) -> str:
    """An obstacle or object by its own name, in quotes; a part of the arm, or the tray, without."""
    own = body.obstacle is not None or (body.on_path and body.name not in (TRAY, LOAD))
    return as_written(body.name) if own else f"the {body.name}"


def _length_text(length: float) -> str:
    return format_quantity(length, "length", digits=3)
