"""What happens to what stands on the tray: whether it spills, slides, turns, tips, lifts or touches.

That is another question than whether limits hold, which keep a reserve, and those of the arm and the path besides.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from nospill.certification.verdict import Row
from nospill.core.units import listed
from nospill.laws.constraints.base import Role, RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.constraints.lift import Lift
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slip import Slip
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.constraints.tip import Tip
from nospill.laws.constraints.twist import Twist

CONTACT_VERBS = {Lift.name: "lifts", Slip.name: "slides", Tip.name: "tips", Twist.name: "turns"}
"""Constraint -> what an object does that breaks it."""

_VERBS = {SloshHeight.name: "spills", ResidualHeight.name: "spills", **CONTACT_VERBS}
_OF_WHAT = {
    SloshHeight.name: "of the way to the rim",
    ResidualHeight.name: "of the way to the rim",
    Lift.name: "of its weight",
    Slip.name: "of the measured friction",
    Twist.name: "of the measured friction",
    Tip.name: "of the whole footprint",
}


def is_on_tray(row: Row) -> bool:
    """Whether a row is about liquids, contacts or distances, and not about the arm, the tray's motion or the record."""
    return row.known is not None and row.known.role in (Role.LIQUID, Role.CONTACT, Role.CLEARANCE)


def tray_first(rows: Iterable[Row]) -> list[Row]:
    """Rows in their order, those about liquids, contacts and distances before the others."""
    return sorted(rows, key=lambda row: not is_on_tray(row))


def happening_line(uses: Mapping[RowId, float]) -> str:
    """What happens in a sentence without a full stop.

    Args:
        uses: of the limits with nothing in reserve, as `tracked_rows.without_reserve` has them.
    """
    known = {row: use for row, use in uses.items() if row.constraint in _VERBS or row.constraint == Clearance.name}
    said: dict[str, str] = {}
    for row in sorted((row for row, use in known.items() if use > 1.0), key=lambda row: -known[row]):
        if row.constraint == Clearance.name:
            said.setdefault(row.subject, f"{row.subject.replace(' to ', ' and ')} touch")
        else:
            does = f"{row.subject} {_VERBS[row.constraint]}"
            said.setdefault(does, f"{does} ({_figure(row, known[row])})")
    if said:
        return f"on the tray: {listed(list(said.values()), last='and')}"
    held = "on the tray: nothing spills, slides, turns, tips, lifts or touches"
    nearest = max((row for row in known if row.constraint in _VERBS), key=lambda row: known[row], default=None)
    if nearest is None:
        return held
    return f"{held}; nearest to it: {nearest.constraint} of {nearest.subject}, {_figure(nearest, known[nearest])}"


def _figure(row: RowId, use: float) -> str:
    return f"{100 * use:.1f} % {_OF_WHAT[row.constraint]}"
