"""A plan's liquids followed by their nonlinear flow: how high the water really goes, and what is left after the end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plans.plan import Plan
from nospill.plans.warnings.second_order import AFTER, CREST_ERROR, RESIDUAL_ERROR
from nospill.potential_flow import BodyRows, Crests, crests_along, rows_at
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.cargo import Cargo
from nospill.scene.heights import unsupported
from nospill.scene.scene import Scene
from nospill.verify.report import Peak
from nospill.verify.tray_motion import PlayedJoints, planned_joints


@dataclass(frozen=True, slots=True)
class CupReport:
    """What one liquid does.

    Attributes:
        name: of the object.
        limit: on the slosh height, m.
        residual_limit: on the height after the end, m; None where there is none.
        certified: highest crest in the plan's certificate and when.
        crests: over time, linear, to the second order and in full.
        history: (2, m) s and m, the height that the certificate judged.
    """

    name: str
    limit: float
    residual_limit: float | None
    certified: Peak
    crests: Crests
    history: np.ndarray

    @property
    def linear(self) -> Peak:
        """Highest crest to the first order."""
        return Peak(*self.crests.highest(self.crests.linear))

    @property
    def second(self) -> Peak:
        """Highest crest to the second order."""
        return Peak(*self.crests.highest(self.crests.second))

    @property
    def full(self) -> Peak:
        """Highest crest of the full flow, as far as it goes."""
        return Peak(*self.crests.highest(self.crests.full))

    @property
    def residual(self) -> tuple[float | None, float | None, float | None]:
        """Greatest heights after the end, m: linear, second order, full; None of a flow that does not get there."""
        found = self.crests
        linear, second, full = (found.after_end(values) for values in (found.linear, found.second, found.full))
        return linear, second, full

    @property
    def over(self) -> str | None:
        """By how much the water is over its limits, in words; None where it keeps them or the flow is not trusted."""
        if self.crests.doubt is not None:
            return None
        parts = []
        if self.full.value > (1 + CREST_ERROR) * self.limit:
            parts.append(
                f"crest of {1e3 * self.full.value:.1f} mm at {self.full.at_s:.2f} s, "
                f"{1e3 * (self.full.value - self.limit):.1f} mm over the limit"
            )
        left, allowed = self.residual[2], self.residual_limit
        if left is not None and allowed is not None and left > (1 + RESIDUAL_ERROR) * allowed:
            parts.append(f"{1e3 * left:.1f} mm after the end, {1e3 * (left - allowed):.1f} mm over the limit")
        return "; ".join(parts) or None

    @property
    def ok(self) -> bool:
        """Whether the flow is trusted and keeps the limits."""
        return self.crests.doubt is None and self.over is None

    @property
    def sentence(self) -> str:
        """What is to be said of it."""
        if self.crests.doubt is not None:
            return f"{self.name}: {self.crests.doubt}; its figures are no verdict."
        return f"{self.name}: {self.over or 'the water keeps its limits'}."


@dataclass(frozen=True, slots=True)
class WaterReport:
    """The liquids of a plan.

    Attributes:
        cups: those that were followed, in the order of the scene.
        left_out: (name, reason) of liquids that the flow is not known of.
        source: where the joint motion came from.
    """

    cups: tuple[CupReport, ...]
    left_out: tuple[tuple[str, str], ...]
    source: str

    @property
    def ok(self) -> bool:
        """Whether every liquid that was followed keeps its limits."""
        return all(item.ok for item in self.cups)

    @property
    def verdict(self) -> str:
        """In a few words."""
        if not self.cups:
            return "no liquid was followed"
        if any(item.over for item in self.cups):
            return "the water does not keep every limit"
        return "the water keeps its limits" if self.ok else "the flow is in doubt: no verdict"

    @property
    def message(self) -> str:
        """One sentence for every liquid that does not keep its limits or cannot be followed."""
        lines = [item.sentence for item in self.cups if not item.ok]
        lines += [f"{name} is not followed: {reason}." for name, reason in self.left_out]
        if not lines:
            return "The water keeps its limits." if self.cups else "There is no liquid."
        return " ".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """For a record, figures in mm."""
        return {
            "ok": self.ok,
            "message": self.message,
            "joints": self.source,
            "liquids": [_table(item) for item in self.cups],
            "left_out": [{"name": name, "reason": reason} for name, reason in self.left_out],
        }


def _table(cup: CupReport) -> dict[str, Any]:
    peaks = {"certified": cup.certified, "linear": cup.linear, "second": cup.second, "full": cup.full}
    left = dict(zip(("linear", "second", "full"), cup.residual, strict=True))
    found = cup.crests
    return {
        "name": cup.name,
        "ok": cup.ok,
        "limit_mm": 1e3 * cup.limit,
        **{f"{name}_mm": 1e3 * peak.value for name, peak in peaks.items()},
        **{f"{name}_at_s": peak.at_s for name, peak in peaks.items()},
        "residual_limit_mm": _millimetres(cup.residual_limit),
        **{f"residual_{name}_mm": _millimetres(value) for name, value in left.items()},
        "steepest": float(np.max(found.steepness)),
        "spread": found.spread,
        "breaks_at_s": found.breaks_at,
        "doubt": found.doubt,
        "message": cup.sentence,
    }


def _millimetres(value: float | None) -> float | None:
    return None if value is None else 1e3 * value


def verify_water(plan: Plan, *, joints: PlayedJoints | None = None) -> WaterReport:
    """Follow every liquid of a plan by its potential flow. Nothing is written.

    Args:
        plan: certified or not.
        joints: the joint motion; by default the plan's own trajectory.

    Raises:
        ModelError: the certificate's own height cannot be integrated.
        PlanFolderError: the joint motion is none of this robot.
    """
    given = joints or planned_joints(plan.trajectory, plan.scene, source="trajectory")
    cups, left_out = [], []
    for cargo in plan.scene.cargo:
        reason = unsupported(cargo)
        if cargo.filling is None and not cargo.carrier:
            continue
        if reason is not None:
            left_out.append((cargo.name, reason))
            continue
        crests = crests_along(cargo, _rows(given, plan.scene, cargo), given.start, given.end, after=AFTER)
        cups.append(_report(plan, cargo, crests))
    return WaterReport(tuple(cups), tuple(left_out), given.source)


def _report(plan: Plan, cargo: Cargo, crests: Crests) -> CupReport:
    assert cargo.filling is not None
    judged = plan.history(SloshHeight.name, cargo.name)
    highest = int(np.argmax(judged.demand))
    row = next((row for row in plan.certificate.rows if row.id == RowId(ResidualHeight.name, cargo.name)), None)
    return CupReport(
        name=cargo.name,
        limit=cargo.filling.max_slosh_height,
        residual_limit=None if row is None else abs(row.limit),
        certified=Peak(float(judged.demand[highest]), float(judged.t[highest])),
        crests=crests,
        history=np.stack([judged.t, judged.demand]),
    )


def _rows(joints: PlayedJoints, scene: Scene, cargo: Cargo) -> BodyRows:
    """Motion of a container from the joints."""
    place = np.array([*cargo.position, 0.0])

    def rows(t: np.ndarray) -> np.ndarray:
        tray = kinematics(scene.robot).motions(*(joints.motion(t, order) for order in range(3)), tool=scene.tray.tool)
        lifted = tray.acceleration + np.array([0.0, 0.0, scene.gravity])
        vectors = (tray.angular_velocity, tray.angular_acceleration, lifted)
        return rows_at(
            np.concatenate([np.einsum("mji,mj->im", tray.rotation, item) for item in vectors]), place, cargo.yaw
        )

    return rows
