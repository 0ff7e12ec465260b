"""What the figures show: a plan, the judge's evidence for it, and what follows from both in closed form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.limiting import Limiting, limiting_rows, limiting_text
from nospill.certification.other_speeds import SpeedUse, uses_at
from nospill.certification.second_order import heights_after
from nospill.certification.verdict import Row, Trace
from nospill.core.frames import SX, frame_at_rest
from nospill.core.trees import constants
from nospill.laws.constraints import constraints_of
from nospill.laws.constraints.base import EvaluationPoint, RowId
from nospill.laws.sample import coordinate_count, sample_objects, split_states
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.height import crest
from nospill.laws.slosh.residual import free_motion
from nospill.plans.plan import Plan
from nospill.plans.records import MotionMaxima, motion_maxima
from nospill.scene.cargo import titles_of

_SPEEDS = tuple(float(speed) for speed in np.linspace(0.1, 1.0, 19))
"""Parts of the planned speed."""

AFTER_END = 0.4
"""s; how long the free liquid is shown after the motion, a little more than one swing of a cup."""


def evidence_of(plan: Plan, judgement: Judgement) -> Evidence:
    """What figures and reports read: objects and the rows about them go by the labels of the objects."""
    titles = titles_of(plan.scene.cargo)
    if all(name == title for name, title in titles.items()):
        return Evidence(plan, judgement)

    def rows(found: Sequence[Row]) -> tuple[Row, ...]:
        return tuple(replace(row, subject=titles.get(row.subject, row.subject)) for row in found)

    def titled(row: RowId) -> RowId:
        return RowId(row.constraint, titles.get(row.subject, row.subject))

    scene = replace(plan.scene, cargo=tuple(replace(item, name=titles[item.name]) for item in plan.scene.cargo))
    trajectory = replace(
        plan.trajectory, slosh={titles.get(name, name): track for name, track in plan.trajectory.slosh.items()}
    )
    savings = {titled(RowId.of(label)).label: saved for label, saved in plan.report.savings.items()}
    certificate, full = judgement.certificate, judgement.certificate.full_model
    return Evidence(
        replace(plan, scene=scene, trajectory=trajectory, report=replace(plan.report, savings=savings)),
        replace(
            judgement,
            certificate=replace(
                certificate, rows=rows(certificate.rows), full_model=None if full is None else rows(full)
            ),
            traces=tuple(replace(item, subject=titles.get(item.subject, item.subject)) for item in judgement.traces),
            corners=rows(judgement.corners),
            corner_use={titled(row): use for row, use in judgement.corner_use.items()},
        ),
    )


@dataclass(frozen=True)  # without slots: what several figures read is worked out once
class Evidence:
    """A plan and its judgement, as the figures read them."""

    plan: Plan
    judgement: Judgement

    @property
    def end_time(self) -> float:
        """End of the motion, s."""
        return self.plan.duration

    @cached_property
    def maxima(self) -> MotionMaxima:
        """Largest figures of the motion as judged here."""
        return motion_maxima(self.judgement, self.plan.scene)

    @cached_property
    def limiting(self) -> tuple[Limiting, ...]:
        """The limits that the motion comes near, the one that holds it longest first."""
        return limiting_rows(self.judgement, self.plan.scene)

    @cached_property
    def other_speeds(self) -> tuple[SpeedUse, ...]:
        """What the motion uses of its limits on objects from a tenth of its speed to all of it."""
        return uses_at(self.plan.trajectory, self.plan.scene, _SPEEDS)

    @property
    def limiting_text(self) -> str:
        """What holds the motion back, in one sentence without a full stop; empty where nothing does."""
        return limiting_text(self.maxima.time_at_limit, self.plan.scene.robot.joints)

    def traces(self, constraint: str) -> tuple[Trace, ...]:
        """The traces of one constraint, a subject each; empty where it does not apply."""
        return tuple(trace for trace in self.judgement.traces if trace.constraint == constraint)

    def by_constraint(self, point: EvaluationPoint) -> dict[str, tuple[Trace, ...]]:
        """The traces of every constraint of one point that applies, by constraint, in the order of the certificate."""
        names = [constraint.name for constraint in constraints_of(self.plan.scene) if constraint.evaluated_at is point]
        return {name: traces for name in names if (traces := self.traces(name))}

    def free_heights(self) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Surface heights after the end, the tray at rest: times (m,) s, and heights (m,) m per object with liquid.

        The modes swing as in `slosh.residual`; the height follows from them as in the constraint, to the second order
        where the scene asks for it.
        """
        scene, played = self.plan.scene, self.judgement.replay
        structure, numbers = structure_of(scene), numbers_of(scene)
        count = coordinate_count(structure)
        after = np.linspace(0.0, AFTER_END, 401)
        if count == 0:
            return played.t[-1] + after, {}
        states = free_motion(scene, played.slosh_displacement[-1], played.slosh_velocity[-1], after)
        q, still = SX.sym("q", count), SX.zeros(count)
        fixed = constants(numbers)
        objects = sample_objects(
            structure, fixed, frame_at_rest(fixed.gravity), split_states(structure, q, still, still)
        )
        heights = [crest(item.structure, item.surface, item.yaw_heights) for item in objects if item.structure.liquid]
        table = np.array(ca.Function("free", [q], [ca.densify(ca.vertcat(*heights))])(ca.DM(states.T)).full())
        names = [cargo.name for cargo in scene.cargo if cargo.filling]
        to_order = heights_after(scene, played, after)
        return played.t[-1] + after, dict(zip(names, table, strict=True)) | to_order
