"""Rows of a carrier whose liquids swing high: with every liquid in it by itself, instead of the few that stand for all.

The few are exact where what a liquid answers is linear (`scene/carriers.py`); its first mode slides on a paraboloid.
Of 20 vials they are off by 2e-5 of a limit at crests of 0.6 of the radius, 1e-3 at 0.85 and 7e-3 at 1.5.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from nospill.certification.between_instants import peaks_between, with_peaks
from nospill.certification.replay import MINIMUM_RATE, replay
from nospill.certification.traces import constraint_traces
from nospill.certification.verdict import Trace
from nospill.laws.constraints.base import OF_OBJECTS
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import with_single_liquids
from nospill.scene.scene import Scene

LUMPED_UP_TO = 0.5
"""Crest as a part of the radius, or half side, up to which few liquids stand for all in a carrier."""


def with_liquids_apart(
    traces: Iterable[Trace],
    trajectory: Trajectory,
    scene: Scene,
    *,
    motion: JointMotion | None = None,
    rate: float = MINIMUM_RATE,
) -> tuple[Trace, ...]:
    """Traces of a scene, those of carriers whose liquids swing high with each liquid by itself.

    Args:
        traces: of every object, with few liquids for all of a carrier.
        trajectory: the record, with its holds.
        scene: what it must keep to.
        motion: what the receiver's joints do; the spline through the recorded positions when left out.
        rate: Hz, the least rate of the grid.
    """
    traces = tuple(traces)
    high = _swinging_high(traces, scene)
    apart = tuple(
        single for cargo in scene.cargo if cargo.name in high and (single := with_single_liquids(cargo)) is not cargo
    )
    if not apart:
        return traces
    motion, alone = motion or trajectory.motion, replace(scene, cargo=apart)
    played = replay(trajectory, alone, motion=motion, rate=rate)
    liquid_traces = constraint_traces(trajectory, alone, played, points=OF_OBJECTS)
    liquid_traces = with_peaks(liquid_traces, peaks_between(trajectory, alone, played, liquid_traces, motion))
    names = {cargo.name for cargo in apart}
    exact = {trace.id: trace for trace in liquid_traces if trace.subject in names}
    return tuple(exact.get(trace.id, trace) for trace in traces)


def _swinging_high(traces: Iterable[Trace], scene: Scene) -> set[str]:
    """Names of carriers in which a crest is higher than few liquids can stand for all."""
    carried = {cargo.name: cargo for cargo in scene.cargo if cargo.carrier}
    return {
        carried[trace.subject].carrier
        for trace in traces
        if trace.constraint == SloshHeight.name
        and trace.subject in carried
        and float(np.max(trace.value)) > LUMPED_UP_TO * _radius(carried[trace.subject])
    }


def _radius(cargo: Cargo) -> float:
    return float(np.min(cargo.container.footprint.half_lengths))
