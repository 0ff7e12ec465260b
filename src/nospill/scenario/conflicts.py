"""Keys of a scenario that do not go together: one sentence each, with what to leave out or to state."""

from __future__ import annotations

import math
from collections.abc import Sequence

from nospill.core.units import as_written, format_quantity
from nospill.errors import ScenarioError
from nospill.paths.path import Path
from nospill.scenario.model import Scenario
from nospill.scene.cargo import Cargo
from nospill.scene.heights import HeightOrder, by_nonlinear_flow, linear_since, to_second_order
from nospill.scene.scene import FULL_MODES
from nospill.scene.variants import liquid_offsets

_LEVEL = math.radians(0.1)
"""Lean of a tray on which a liquid rests: 0.06 mm at the wall of a cup of 35 mm."""
MOST_REST_SAMPLES = 200_000
"""Samples of rest before and after a motion: 100 s at each end at 1 kHz."""


def check_motion(scenario: Scenario) -> None:
    """Refuse rules of [motion] that contradict each other or the rest of the scenario.

    Raises:
        ScenarioError: they do; as all functions here.
    """
    if scenario.motion.max_jerk is not None and scenario.motion.path_jerk_limit is not None:
        raise ScenarioError("max_jerk and path_jerk_limit both bound the jerk along the path; keep one of them")
    samples = scenario.output.rate * (scenario.motion.hold_before + scenario.motion.hold_after)
    if samples > MOST_REST_SAMPLES:
        raise ScenarioError(
            f"hold_before and hold_after are {samples:.0f} samples of rest at {scenario.output.rate:g} Hz; at most "
            f"{MOST_REST_SAMPLES} are written and judged; shorten them or lower output.rate"
        )
    if scenario.motion.tilt == "free" and scenario.path.type == "joints":
        raise ScenarioError('tilt = "free" and a path of the joints: the tray leans as the path says; leave tilt out')
    _check_speed_range(scenario)
    swinging = next((entry.name for entry in scenario.cargo if entry.initial_swing is not None), None)
    before = "hold_before" if scenario.motion.hold_before > 0.0 else "[approach]" if scenario.approach else ""
    if swinging is not None and before:
        raise ScenarioError(
            f"{before} comes before the motion, at whose beginning {as_written(swinging)} has its initial_swing; leave "
            "one of them out, and give the swing that is left after the wait"
        )


def check_height(scenario: Scenario, cargo: tuple[Cargo, ...]) -> None:
    """Refuse heights of second order and of the nonlinear flow where the scene has none."""
    residual, stated = residual_order(scenario, cargo)[0], scenario.motion.slosh_height
    over_band = scenario.tolerance is not None and scenario.tolerance.has_band
    if residual != "linear" and over_band:
        raise ScenarioError(
            f'residual_height = "{residual}" and tolerance.tracking are stated together: over a band of arms heights '
            'after the end are those of the modes alone; write residual_height = "linear", or leave tracking out'
        )
    if residual != "linear" and height_order(scenario, cargo)[0] == "linear":
        raise ScenarioError(
            f'residual_height = "{residual}" is stated where slosh heights are linear: {_way_to_second_order(scenario)}'
        )
    if stated == "nonlinear" and over_band:
        raise ScenarioError(
            'slosh_height = "nonlinear" and tolerance.tracking are stated together: over a band of arms heights are of '
            'second order; write slosh_height = "second order", or leave tracking out'
        )
    if stated is None or stated == "linear":
        return
    if scenario.fidelity != "full":
        raise ScenarioError(
            f'slosh_height = "{stated}" and fidelity = "deliverable" are stated together: the published physics are '
            "linear; leave one of them out"
        )
    for item in cargo:
        reason = linear_since(item)
        if reason is not None:
            raise ScenarioError(
                f'slosh_height = "{stated}": it is not known of {as_written(item.name)}, for {reason}; write '
                'slosh_height = "linear", or leave it out'
            )


def _way_to_second_order(scenario: Scenario) -> str:
    """Why slosh heights of a scenario are linear, and what to leave out or to state."""
    if scenario.fidelity != "full":
        return f'fidelity = "{scenario.fidelity}" is of linear heights; leave one of the two out'
    if scenario.motion.slosh_height == "linear":
        return 'slosh_height = "linear" says so; leave one of the two out'
    return 'over speed_range they are; state slosh_height = "second order" too, or leave residual_height out'


def height_order(scenario: Scenario, cargo: tuple[Cargo, ...]) -> tuple[HeightOrder, str]:
    """To which order heights are judged, and why all of them are linear where they are.

    Where it is not stated they are those of the nonlinear flow where heights after the end are.
    """
    order, reason = _height_order(scenario)
    by_flow = scenario.motion.slosh_height is None and residual_order(scenario, cargo)[0] == "nonlinear"
    return ("nonlinear", "") if by_flow and order != "linear" else (order, reason)


def _height_order(scenario: Scenario) -> tuple[HeightOrder, str]:
    """The same, to the second order where it is not stated."""
    if scenario.fidelity != "full":
        return "linear", ""
    stated = scenario.motion.slosh_height
    if stated is not None:
        return stated, "motion.slosh_height says so" if stated == "linear" else ""
    if scenario.motion.speed_range is not None:
        return "linear", "over motion.speed_range the second order is asked for only where it is stated"
    return "second order", ""


def residual_order(scenario: Scenario, cargo: tuple[Cargo, ...]) -> tuple[HeightOrder, str]:
    """To which order heights after the end are judged, and why all of them are linear where they are.

    Where it is not stated they are those of the nonlinear flow, where that follows every liquid whose second order is
    known. What it does not know of a single one would be of second order, and kept by far smoother motions of all.
    """
    stated = scenario.motion.residual_height
    if stated is not None:
        return stated, "motion.residual_height says so" if stated == "linear" else ""
    if _height_order(scenario)[0] == "linear":
        return "linear", ""
    known = [item for item in cargo if to_second_order(item, "nonlinear")]
    if not known:
        return "linear", ""
    reason = _not_followed(scenario, known)
    return ("linear", reason) if reason else ("nonlinear", "")


def _not_followed(scenario: Scenario, known: Sequence[Cargo]) -> str:
    """Why the nonlinear flow does not follow all liquids of second order, as the end of a sentence; empty if it does.

    Args:
        scenario: what is stated.
        known: its objects with such a liquid.
    """
    if scenario.motion.speed_range is not None:
        return "motion.speed_range has other speeds than the planned one"
    if scenario.tolerance is not None and scenario.tolerance.has_band:
        return "tolerance.tracking is a band of arms"
    if scenario.planning.slosh_modes is not None and scenario.planning.slosh_modes < FULL_MODES:
        return "planning.slosh_modes leaves modes out"
    for item in known:
        if any(offset.frequency for offset in liquid_offsets(item)):
            return f"{as_written(item.name)} has a range of frequencies"
        if not by_nonlinear_flow(item, "nonlinear"):
            return f"{as_written(item.name)} swings when the motion begins"
    return ""


def check_still_end(scenario: Scenario) -> None:
    """Refuse liquids that stand still at the end with a band of arms, which end at no one instant."""
    still = scenario.motion.end != "residual" and any(entry.liquid is not None for entry in scenario.cargo)
    if still and scenario.tolerance is not None and scenario.tolerance.has_band:
        raise ScenarioError(
            f'end = "{scenario.motion.end}" and tolerance.tracking are stated together: joints that are late by '
            'unknown times leave a swing, at no instant zero; write end = "residual", or leave tracking out'
        )


def check_ends(path: Path, cargo: tuple[Cargo, ...]) -> None:
    """Refuse a path of the joints at whose ends the tray leans with liquids on it: they rest level with the tray."""
    liquid = next((item.name for item in cargo if item.filling is not None), None)
    if path.joint_curve is None or liquid is None:
        return
    for verb, lean in zip(("starts", "ends"), path.joint_curve.lean[[0, -1]], strict=True):
        if lean > _LEVEL:
            shown, most = (format_quantity(float(angle), "angle", digits=3) for angle in (lean, _LEVEL))
            raise ScenarioError(
                f"the tray leans {shown} where the path {verb}, and {as_written(liquid)} has a liquid, which rests on "
                f"a tray that is level to {most}; change that point"
            )


def _check_speed_range(scenario: Scenario) -> None:
    if scenario.motion.speed_range is None:
        return
    least, greatest = scenario.motion.speed_range
    if not least < greatest:
        raise ScenarioError(
            f"speed_range runs from {100 * least:.4g} % to {100 * greatest:.4g} %; write the least speed first, as in "
            'speed_range = ["25 %", "100 %"]'
        )
    if scenario.motion.end != "residual" and any(entry.liquid is not None for entry in scenario.cargo):
        raise ScenarioError(
            f'speed_range and end = "{scenario.motion.end}" are stated together: liquids that stand still after the '
            'motion at one speed do not at another; write end = "residual"'
        )
    swinging = any(entry.initial_swing is not None for entry in scenario.cargo)
    late = scenario.controller is not None and scenario.controller.is_late
    band = scenario.tolerance is not None and scenario.tolerance.has_band
    other = "[controller]" if late else "initial_swing" if swinging else "tolerance.tracking" if band else ""
    if other:
        raise ScenarioError(
            f"speed_range and {other} are stated together: what {other} describes does not slow down with the motion; "
            "leave one of them out"
        )
