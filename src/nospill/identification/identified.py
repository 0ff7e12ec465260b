"""What a run teaches the next plan: numbers with intervals, as tables of a scenario."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nospill.certification.certificate import judge_joints
from nospill.errors import ScenarioError
from nospill.execution.executed import require_liquids
from nospill.execution.log import JointLog
from nospill.execution.motion import RecordedMotion, Span, recorded_motion, samples
from nospill.identification.estimates import WIDE, Estimate
from nospill.identification.joint_fit import JointFit, against_the_first, fit_joints
from nospill.identification.liquid_fit import LiquidFit, fit_liquid
from nospill.laws.constraints.slip import Slip
from nospill.motion.control import commanded
from nospill.motion.interpolation import QUINTIC_SPLINE, JointMotion, JointSamples
from nospill.plans.plan import Plan
from nospill.scene.scene import Scene
from nospill.simulation.motion_file import Heights

_AROUND = 0.02
"""s; of rest that is judged before the motion, and ten times as much after it."""


@dataclass(frozen=True, slots=True)
class FrictionBound:
    """What an object that stayed, or slid, says of its friction.

    Attributes:
        subject: the object.
        friction: coefficient that the motion needed.
        slid: whether it slid, so that its friction is less; else it is more.
    """

    subject: str
    friction: float
    slid: bool


@dataclass(frozen=True, slots=True, eq=False)
class Identified:
    """What a run tells.

    Attributes:
        scene: what it was compared with.
        recorded: the log.
        liquids: of the cups that were measured.
        joints: empty where nobody knows what was asked for.
        of_command: whether delays are against the command in the log; else against the joint that begins first.
        frictions: of objects that were said to have stayed or slid.
    """

    scene: Scene
    recorded: RecordedMotion
    liquids: tuple[LiquidFit, ...]
    joints: tuple[JointFit, ...]
    of_command: bool
    frictions: tuple[FrictionBound, ...]

    @property
    def unidentifiable(self) -> list[Estimate]:
        """What this motion does not tell."""
        of_joints = [own for fit in self.joints for own in (fit.delay, fit.lag)]
        return [
            own for own in [*(own for fit in self.liquids for own in fit.estimates), *of_joints] if not own.identifiable
        ]

    @property
    def unexplained(self) -> list[JointFit]:
        """Joints that do what no delay and lag does."""
        return [fit for fit in self.joints if fit.unexplained]


def identified(
    log: JointLog,
    scene: Scene,
    *,
    plan: Plan | None = None,
    measured: Mapping[str, Heights] | None = None,
    stayed: Collection[str] = (),
    slid: Collection[str] = (),
) -> Identified:
    """Learn from a run.

    Args:
        log: of the joints; with its command perhaps.
        scene: with the numbers as stated.
        plan: whose command was executed, where the log does not say.
        measured: heights of liquids, by object.
        stayed: objects that did not slide.
        slid: objects that slid.

    Raises:
        ScenarioError: nothing to learn from, or a name of no object; the log is not of this robot or no whole motion.
        ModelError: a liquid leaves its cup.
    """
    given = dict(measured or {})
    require_liquids(given, scene)
    names = [cargo.name for cargo in scene.cargo]
    for name in (*stayed, *slid):
        if name not in names:
            raise ScenarioError(f"--stayed or --slid {name}: no such object; there are: {', '.join(names)}")
    recorded = recorded_motion(log, scene)
    command = _command(recorded, plan)
    if not (given or stayed or slid or command):
        raise ScenarioError(
            f"{log.origin}: nothing to learn from: give measured heights (--measured), the plan that was executed "
            "(--plan), a log with its command, or what slid and what stayed"
        )
    joints: tuple[JointFit, ...] = ()
    if command is not None:
        joints = fit_joints(recorded, *command)
        joints = joints if log.command is not None else against_the_first(joints)
    liquids = tuple(
        fit_liquid(recorded.held(), scene, name, heights, begin=recorded.begin, end=recorded.end)
        for name, heights in given.items()
    )
    frictions = _frictions(recorded, scene, stayed, slid) if stayed or slid else ()
    return Identified(scene, recorded, liquids, joints, log.command is not None, frictions)


def _command(recorded: RecordedMotion, plan: Plan | None) -> tuple[JointMotion, tuple[float, float]] | None:
    """What was asked for, and from when to when."""
    log, sampling = recorded.log, recorded.sampling
    if log.command is not None:
        asked = JointSamples(sampling.t, log.command[sampling.kept])
    elif plan is not None:
        asked = commanded(plan.trajectory, plan.scene.controller)
    else:
        return None
    return QUINTIC_SPLINE.motion(asked), (float(asked.t[0]), float(asked.t[-1]))


def _frictions(
    recorded: RecordedMotion, scene: Scene, stayed: Collection[str], slid: Collection[str]
) -> tuple[FrictionBound, ...]:
    span = Span(recorded.begin - _AROUND, recorded.begin, recorded.end, recorded.end + 10.0 * _AROUND)
    record = samples(recorded.held(), scene.robot.joints, span, 500.0)
    rows = judge_joints(record, scene, motion=recorded.held()).certificate.rows
    uses = {row.subject: row.worst_value for row in rows if row.constraint == Slip.name}
    planned = {cargo.name: cargo.planned_friction for cargo in scene.cargo}
    return tuple(
        FrictionBound(name, uses[name] * planned[name], slid=group is slid)
        for group in (stayed, slid)
        for name in group
    )


def scenario_text(learnt: Identified) -> str:
    """Tables `[controller]` and `[tolerance]` for a scenario, with what they come from as comments."""
    lines = [f"# Learnt from {learnt.recorded.log.origin}."]
    for fit in learnt.liquids:
        fill, damping = fit.of("fill"), fit.of("damping")
        lines.append(f"# {fit.subject}: fill {_interval(fill, 1e3, 'mm')}, stated {1e3 * fit.stated[0]:.4g} mm;")
        lines.append(f"#   damping ratio {_interval(damping, 1.0, '')}, stated {fit.stated[1]:.4g}.")
    for bound in learnt.frictions:
        word = "slid: friction below" if bound.slid else "stayed: friction above"
        lines.append(f"# {bound.subject} {word} {bound.friction:.3f}.")
    identified_fits = [fit for fit in learnt.joints if fit.moves and fit.lag.identifiable and fit.delay.identifiable]
    if identified_fits:
        lines += ["", "[controller]"]
        if len(identified_fits) < len(learnt.joints):
            lines.append("# the mean of the other joints stands where this motion does not tell")
        lines += [
            f"# {text}; the scenario's law is of first order"
            for text in map(second_order_text, identified_fits)
            if text
        ]
        for key in ("delay", "lag"):
            known = {fit.joint: max(getattr(fit, key).value, 0.0) for fit in identified_fits}
            others = sum(known.values()) / len(known)  # one controller leads them all
            values = [known.get(fit.joint, others) for fit in learnt.joints]
            listed = ", ".join(f'"{round(1e3 * value, 2):g} ms"' for value in values)
            lines.append(f"{key} = [{listed}]")
    tolerance = _tolerance(learnt)
    if tolerance:
        lines += ["", "[tolerance]", *tolerance]
    return "\n".join(lines) + "\n"


def second_order_text(fit: JointFit) -> str:
    """What a lag of second order makes of a joint, in a line; empty where one of first order does."""
    fitted = fit.second
    if fitted is None:
        return ""
    numbers = ", ".join(
        f"{what} {_interval(value, factor, unit)}"
        for what, value, factor, unit in (
            ("natural frequency", fitted.frequency, 1.0, "rad/s"),
            ("damping ratio", fitted.damping, 1.0, ""),
            ("delay", fitted.delay, 1e3, "ms"),
        )
    )
    return (
        f"{fit.joint} follows with second order: {numbers}; {1e3 * fitted.left:.2g} mrad rms are left, "
        f"{1e3 * fit.left:.2g} with first order"
    )


def _tolerance(learnt: Identified) -> list[str]:
    """Ranges that hold what is stated and what was learnt of every cup."""
    lines = []
    rises = [
        abs(end - fit.stated[0])
        for fit in learnt.liquids
        if (estimate := fit.of("fill")).identifiable
        for end in estimate.interval
    ]
    if rises:
        lines.append(f'liquid_height = "{np.ceil(1e4 * max(rises)) / 10:.1f} mm"')
    factors = [
        end / fit.stated[1]
        for fit in learnt.liquids
        if (estimate := fit.of("damping")).identifiable
        for end in estimate.interval
    ]
    if factors:
        low, high = max(min(1.0, *factors), 0.01), max(1.0, *factors)
        lines.append(f"damping = [{np.floor(100 * low) / 100:.2f}, {np.ceil(100 * high) / 100:.2f}]")
    return lines


def _interval(own: Estimate, factor: float, unit: str) -> str:
    if not own.identifiable:
        return "not identifiable from this motion"
    if own.ends is not None:
        low, high = own.ends
        return f"{factor * own.value:.4g} {unit}".rstrip() + f" ({factor * low:.4g} to {factor * high:.4g})"
    return f"{factor * own.value:.4g} +- {factor * own.half_width:.2g} {unit}".rstrip()


def identified_table(learnt: Identified) -> dict[str, Any]:
    """Everything as plain values in SI units; a deviation is null where the motion tells nothing."""

    def plain(own: Estimate) -> dict[str, Any]:
        wide = own.half_width if np.isfinite(own.half_width) else None
        ends = {} if own.ends is None else {"interval": list(own.ends)}
        return {"value": own.value, "half_width": wide, "unit": own.unit, "identifiable": own.identifiable} | ends

    return {
        "log": learnt.recorded.log.origin,
        "confidence": {"level": 0.95, "deviations": WIDE},
        "liquids": {
            fit.subject: {own.name: plain(own) for own in fit.estimates} | {"left_m": fit.left}
            for fit in learnt.liquids
        },
        "joints": {
            fit.joint: {"delay": plain(fit.delay), "lag": plain(fit.lag), "left_rad": fit.left}
            | (
                {}
                if (own := fit.second) is None
                else {
                    "second_order": {
                        "delay": plain(own.delay),
                        "frequency": plain(own.frequency),
                        "damping": plain(own.damping),
                        "left_rad": own.left,
                    }
                }
            )
            for fit in learnt.joints
        },
        "delays_are_behind_command": learnt.of_command,
        "friction": [{"subject": own.subject, "friction": own.friction, "slid": own.slid} for own in learnt.frictions],
    }
