"""Largest figures of a motion for whoever reads one line only: what it takes, what it keeps free, what it uses up."""

from __future__ import annotations

from dataclasses import dataclass

from nospill.certification.rims import rim_distances
from nospill.certification.verdict import Row
from nospill.certification.wording import margin_text, row_text
from nospill.core.short_names import short_names
from nospill.laws.constraints.base import Role
from nospill.laws.constraints.joint_position import JointPosition
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.constraints.tilt import Tilt
from nospill.plots.evidence import Evidence
from nospill.scene.scene import Scene

_HOUR = 3600.0
_MOST_LIQUIDS = 6
MOST_IN_A_ROW = 9
"""Tiles for which a sheet has space in a row; the last ones are left out."""


@dataclass(frozen=True, slots=True)
class Tile:
    """One figure.

    Attributes:
        value: with its unit.
        label: what it is.
        ok: False where the limit it is about fails.
    """

    value: str
    label: str
    ok: bool = True


def tiles(evidence: Evidence) -> tuple[Tile, ...]:
    """Duration and moves an hour, what is left, then the fullest limit of every kind."""
    certificate, rules = evidence.judgement.certificate, evidence.plan.scene.motion
    joints = evidence.plan.scene.robot.joints
    short = dict(zip(joints, short_names(joints), strict=True))
    moves = int(_HOUR / (evidence.end_time + rules.hold_before + rules.hold_after))
    worst = certificate.worst
    kinds = [_fullest(certificate.rows, SloshHeight.name), _fullest(certificate.rows, ResidualHeight.name)]
    joint_limits = [
        row
        for row in certificate.rows
        if row.known is not None and row.known.role is Role.JOINT and row.constraint != JointPosition.name
    ]
    shown = [
        Tile(f"{evidence.end_time:.3f} s", "duration"),
        *_sooner(evidence),
        Tile(f"{moves:,}".replace(",", "\u202f"), "moves an hour, one way"),
        Tile(margin_text(worst), f"smallest margin: {worst.constraint}", worst.ok),
        *_rim(evidence),
        *(_height(row) for row in kinds if row is not None),
    ]
    tilt = _fullest(certificate.rows, Tilt.name)
    if tilt is not None and rules.tilt_free:
        text = row_text(tilt)
        shown.append(Tile(f"{text.value}°", f"largest tilt angle, {text.limit}° allowed", tilt.ok))
    if joint_limits:
        row = max(joint_limits, key=lambda item: (not item.ok, item.use))
        shown.append(Tile(row_text(row).use, f"of {row.constraint}, {short.get(row.subject, row.subject)}", row.ok))
    shown.append(Tile(f"{evidence.maxima.tray_acceleration:.3g} m/s²", "largest tray acceleration"))
    return tuple(shown)


def task_text(scene: Scene, names: str) -> str:
    """The arm and its load, as "UR5e carries c1, c2: 0.42 l, 1.3 kg", from the names of the objects."""
    return f"{scene.robot.title} " + (f"carries {names}: {carried(scene)}" if scene.cargo else "moves an empty tray")


def carried(scene: Scene) -> str:
    """What the tray carries, in figures: "0.42 l, 1.3 kg"."""
    litres = 1e3 * sum(
        item.container.volume(item.filling.liquid_height) for item in scene.cargo if item.filling is not None
    )
    mass = sum(item.total.mass for item in scene.standing)
    liquid = f"{litres:.2g} l, " if litres > 0.0 else ""
    return f"{liquid}{mass:.2g} kg"


def liquid_tiles(evidence: Evidence) -> tuple[Tile, ...]:
    """How high every liquid rises; of many those that come nearest to their limits."""
    rows = [row for row in evidence.judgement.certificate.rows if row.constraint == SloshHeight.name]
    fullest = sorted(rows, key=lambda row: (not row.ok, row.use), reverse=True)[:_MOST_LIQUIDS]
    return tuple(_height(row) for row in rows if row in fullest)


def _height(row: Row) -> Tile:
    text = row_text(row)
    what = "rises" if row.constraint == SloshHeight.name else "after the end"
    return Tile(f"{text.value} mm", f"{row.subject} {what}, {text.limit} mm allowed", row.ok)


def _sooner(evidence: Evidence) -> list[Tile]:
    """Seconds saved against what the plan was compared with."""
    saved = {name: other - evidence.end_time for name, other in evidence.plan.report.compared.items()}
    return [Tile(f"{seconds:.2f} s".replace("-", "−"), f"less than a {name}") for name, seconds in saved.items()]


def _rim(evidence: Evidence) -> list[Tile]:
    """How far below its rim the liquid stays that comes nearest to it, with its tolerances; rounded down."""
    distances = rim_distances(evidence.plan.scene, evidence.judgement.certificate.rows)
    if not distances:
        return []
    nearest = distances[0]
    text = f"{nearest.left:.1f} mm".replace("-", "−")
    return [Tile(text, f"left to the rim of {nearest.subject}", nearest.left >= 0.0)]


def _fullest(rows: tuple[Row, ...], constraint: str) -> Row | None:
    own = [row for row in rows if row.constraint == constraint]
    return max(own, key=lambda row: (not row.ok, row.use), default=None)
