"""What a motion leaves of each liquid's waves, in four figures: linear heights promise more than water keeps.

Linear, of second order, by the nonlinear flow, and the higher of the first two with all frequencies of the liquids off
by `OFF`, up and down: what a fill, a temperature or a contact line other than stated does to waves that the motion
stills by their phase.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from nospill.certification.by_flow import broken_flows
from nospill.certification.carriers import with_liquids_apart
from nospill.certification.replay import Replay, replay
from nospill.certification.run import Run, run_of
from nospill.certification.traces import constraint_traces
from nospill.certification.verdict import Trace
from nospill.errors import ModelError
from nospill.laws.constraints.base import OF_OBJECTS, EvaluationPoint
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.motion.holds import held_trajectory
from nospill.motion.trajectory import Trajectory
from nospill.scene.cargo import Cargo, Tolerance
from nospill.scene.heights import by_nonlinear_flow
from nospill.scene.scene import Scene
from nospill.scene.tolerances import corner_scenes

OFF = 0.01
"""Relative, of all frequencies of a liquid."""
_NAMED = 4
"""Liquids that the line names, those with the most beyond their limits."""


@dataclass(frozen=True, slots=True)
class LeftAfterEnd:
    """Greatest heights of one liquid after the end, m.

    Attributes:
        limit: of the row.
        linear: of the modes alone.
        second_order: None where it is not known.
        off: of the highest order that is known, with frequencies `OFF` higher or lower; None where it cannot be
            integrated, and where it begins with a swing, which is stated for its own frequencies.
        by_flow: as the nonlinear flow has it; None where it does not follow the liquid, or breaks down.
    """

    limit: float
    linear: float
    second_order: float | None
    off: float | None
    by_flow: float | None = None

    @property
    def most(self) -> float:
        """The greatest of the four, m."""
        return max(self.linear, self.second_order or 0.0, self.by_flow or 0.0, self.off or 0.0)


def left_after_end(trajectory: Trajectory, scene: Scene, played: Replay | None = None) -> dict[str, LeftAfterEnd]:
    """Of every open liquid with a row on its residual height, by object; of the published physics none.

    Args:
        trajectory: the record.
        scene: what it must keep to; its own tolerances and range of speeds are left out.
        played: the replay of the scene as stated, where the motion was judged already.

    Raises:
        ModelError: the liquids as stated cannot be integrated.
    """
    if scene.fidelity != "full" or scene.motion.end != "residual":
        return {}
    asked = replace(
        scene,
        cargo=tuple(_off(item) for item in scene.cargo),
        obstacles=(),
        motion=replace(
            scene.motion, slosh_height="second order", residual_height="second order", speed_range=None, stop=False
        ),
        tracking=None,
    )
    run = run_of(held_trajectory(trajectory, scene.motion), scene.controller)
    stated = played or replay(run.record, asked, motion=run.motion or run.record.motion)
    try:
        others = _heights_of_others(run, asked)
    except ModelError:  # of the liquids with frequencies that are off
        others = {}
    of_flow = _heights_by_flow(run, asked, stated)
    lids = {item.name for item in scene.cargo if item.filling is not None and item.filling.lid}
    found = {}
    for trace in constraint_traces(run.record, asked, stated, points=[EvaluationPoint.END]):
        if trace.constraint != ResidualHeight.name or trace.subject in lids:
            continue
        height = float(np.max(trace.value))
        found[trace.subject] = LeftAfterEnd(
            limit=float(np.max(np.abs(trace.limit))),
            linear=height if trace.linear is None else float(np.max(trace.linear)),
            second_order=None if trace.linear is None else height,
            off=max(others.get(trace.subject, []), default=None),
            by_flow=of_flow.get(trace.subject),
        )
    return found


def _heights_by_flow(run: Run, scene: Scene, stated: Replay) -> dict[str, float]:
    """Heights after the end, m, of the liquids that the nonlinear flow follows to the end, by object."""
    asked = replace(scene, motion=replace(scene.motion, residual_height="nonlinear"))
    broken = broken_flows(asked, stated)
    followed = {item.name for item in asked.cargo if by_nonlinear_flow(item, "nonlinear")} - broken.keys()
    if not followed:
        return {}
    traces = constraint_traces(run.record, asked, stated, points=[EvaluationPoint.END])
    return {
        trace.subject: float(np.max(trace.value))
        for trace in traces
        if trace.constraint == ResidualHeight.name and trace.subject in followed
    }


def _heights_of_others(run: Run, scene: Scene) -> dict[str, list[float]]:
    """Heights after the end of the liquids with frequencies that are off, m, by object."""
    found: dict[str, list[float]] = {}
    for corner in corner_scenes(scene):
        for trace in _at_the_end(run, corner.scene):
            if trace.constraint == ResidualHeight.name and trace.subject in corner.texts:
                found.setdefault(trace.subject, []).append(float(np.max(trace.value)))
    return found


def _at_the_end(run: Run, scene: Scene) -> tuple[Trace, ...]:
    """Traces of the rows on the final state; of carriers whose liquids swing high with each liquid by itself."""
    motion = run.motion or run.record.motion
    played = replay(run.record, scene, motion=motion)
    if not any(item.carrier for item in scene.cargo):
        return constraint_traces(run.record, scene, played, points=[EvaluationPoint.END])
    traces = constraint_traces(run.record, scene, played, points=OF_OBJECTS)
    return with_liquids_apart(traces, run.record, scene, motion=motion)


def _off(cargo: Cargo) -> Cargo:
    """An object whose liquid's frequencies may be off, and nothing else."""
    filling = cargo.filling
    certain = filling is None or filling.lid or filling.initial_swing is not None
    return replace(cargo, tolerance=None if certain else Tolerance(frequency=OFF))


def left_line(left: Mapping[str, LeftAfterEnd]) -> str:
    """The figures of the liquids with the most beyond their limits, in one line; empty where there are none.

    "left after the end (linear, of second order, by the whole flow, frequencies 1 % off): c1 2.2, 5.8, 6, 6.1 of 3 mm".
    """
    worst = sorted(left, key=lambda name: -left[name].most / max(left[name].limit, 1e-12))
    named = [name for name in left if name in worst[:_NAMED]]
    more = f"; and {len(left) - len(named)} more" if len(left) > len(named) else ""
    head = f"left after the end (linear, of second order, by the whole flow, frequencies {100 * OFF:g} % off)"
    return f"{head}: " + "; ".join(_figures(name, left[name]) for name in named) + more if left else ""


def _figures(name: str, own: LeftAfterEnd) -> str:
    heights = (own.linear, own.second_order, own.by_flow, own.off)
    shown = ", ".join("not known" if value is None else f"{1e3 * value:.2g}" for value in heights)
    return f"{name} {shown} of {1e3 * own.limit:.3g} mm"


def left_written(left: Mapping[str, LeftAfterEnd] | None) -> dict[str, dict[str, Any]] | None:
    """For summary.json."""
    return None if left is None else {name: asdict(own) for name, own in left.items()}


def left_read(found: Mapping[str, Mapping[str, Any]] | None) -> dict[str, LeftAfterEnd] | None:
    """What `left_written` wrote.

    Raises:
        TypeError: a key is missing, or it is no table.
    """
    if not (found is None or (isinstance(found, dict) and all(isinstance(own, dict) for own in found.values()))):
        raise TypeError("no table of liquids")
    return None if found is None else {name: LeftAfterEnd(**own) for name, own in found.items()}
